#include "render/prt/technique.h"

#include "render/frame/vocabulary.h"
#include "render/prt/bake_command.h"
#include "render/prt/job.h"
#include "render/prt/mode.h"
#include "render/prt/store.h"

namespace maquette {

namespace {

/// How light, transfer and materials are represented.
std::vector<SettingDeclaration> compression_settings() {
  return {
      {.name = "prt.faces",
       .default_value = 16,
       .min = 4,
       .max = 32,
       .unit = "texels",
       .help = "side of a light cube face: 4, 8, 16 or 32"},
      {.name = "prt.coefficients",
       .default_value = 64,
       .min = 1,
       .max = 1024,
       .help = "Haar coefficients of the light that are kept for each face of its cube, chosen over all faces"},
      {.name = "prt.clusters",
       .default_value = 32,
       .min = 1,
       .max = kMostTransferClusters,
       .help = "clusters that compress the transfer of each view and component"},
      {.name = "prt.components",
       .default_value = 6,
       .min = 0,
       .max = kMostTransferComponents,
       .help = "components of the transfer in each cluster; 0: its mean alone"},
      {.name = "prt.btf_components",
       .default_value = kMostMaterialComponents,
       .min = 0,
       .max = kMostMaterialComponents,
       .help = "eigen-textures of a material, besides the mean, whose transfer is computed at most"},
      {.name = "prt.btf_error",
       .default_value = 2.0,
       .min = 0.0,
       .max = 100.0,
       .unit = "%",
       .help = "a material gets the fewest eigen-textures that miss no more of what it reflects of lights 90 degrees "
               "wide (RMS); 0: prt.btf_components alone counts"},
      {.name = "prt.bounces",
       .default_value = 0,
       .min = 0,
       .max = 16,
       .help = "reflections of light between the parts, before the one that is seen; from 1 on transfer is by colour: "
               "three times the time and the light side"},
  };
}

/// Vertices and rays, parts, and when it is baked.
std::vector<SettingDeclaration> bake_settings() {
  return {
      {.name = "prt.vertices",
       .default_value = 0,
       .min = 0,
       .max = 2000000,
       .unit = "vertices",
       .help = "at least so many, by dividing the triangles of the parts with the longest edges; 0: those of the mesh"},
      {.name = "prt.vertex_error",
       .default_value = 0.0,
       .min = 0.0,
       .max = 100.0,
       .unit = "%",
       .help =
           "divides the triangles of each part until light that is interpolated between its vertices misses what "
           "arrives in the middles of edges by no more (RMS; up to 200,000 vertices); 0: prt.vertices alone counts"},
      {.name = "prt.form",
       .default_value = std::string("auto"),
       .help = "views: material and transfer are factorised for each sampled view; joint: for all views together, with "
               "fewer bytes a vertex, and more sums when the light changes; auto: joint where weights by views take "
               "more than 256 MiB",
       .choices = {"auto", "views", "joint"}},
      {.name = "prt.texel_clusters",
       .default_value = 8,
       .min = 1,
       .max = 64,
       .help = "clusters of a material's texels, in the joint form"},
      {.name = "prt.joint_clusters",
       .default_value = 8,
       .min = 1,
       .max = kMostTransferClusters,
       .help = "clusters of vertices for each function of a material, in the joint form"},
      {.name = "prt.rays",
       .default_value = 2,
       .min = 1,
       .max = 8,
       .unit = "rays",
       .help = "along each side of a texel of the light cube, for each vertex"},
      {.name = "prt.parts",
       .default_value = std::string(),
       .help = "names of nodes that get transfer, with what is below them, separated by semicolons; empty: all opaque "
               "surfaces that the mode shades"},
      {.name = "prt.ground",
       .default_value = std::string("apart"),
       .help =
           "a ground that is added below the scene (ground.kind), whose light turns with the sky: apart: the default "
           "mode shades it; none: it stays black",
       .choices = {"apart", "none"}},
      {.name = "prt.shadows",
       .default_value = std::string("scene"),
       .help = "what casts shadows on the parts: scene: every opaque surface; parts: they alone, so that they may be "
               "turned by themselves",
       .choices = {"scene", "parts"}},
      {.name = "prt.bake", .default_value = std::string(), .help = "folder of `maquette bake prt`; empty: the cache"},
      {.name = "prt.run",
       .default_value = std::string("auto"),
       .help = "auto: what is not baked is baked as soon as a frame needs it; hold: it is not, and a bake in work ends "
               "(what it has made is kept in the cache); what is there is shown",
       .choices = {"auto", "hold"}},
      {.name = "prt.stale",
       .default_value = std::string("refuse"),
       .help = "a bake in prt.bake whose parts were turned without what casts shadows on them: refuse or show",
       .choices = {"refuse", "show"}},
  };
}

}  // namespace

Technique prt_technique() {
  Technique info;
  info.name = "prt";
  info.help = "precomputed radiance transfer: BTFs and other materials with shadows, under a sky that turns";
  info.settings = compression_settings();
  for (SettingDeclaration& setting : bake_settings()) info.settings.push_back(std::move(setting));
  for (const int coefficients : {4, 16, 20, 64, 120})
    info.quality_steps.push_back({.settings = {{"prt.coefficients", coefficients}}});
  info.make_mode = make_transfer_mode;
  info.shader_variants = transfer_shader_variants;
  info.own_bake = OwnBake{"prt", "the light of its vertices is a sum over precomputed transfer",
                          [] { return std::make_unique<TransferStore>(); }, false, transfer_bake_settings()};
  info.bakes = {transfer_bake_command()};
  info.check = [](const SceneFacts&, const Settings& settings) -> std::optional<std::string> {
    const std::string& asked = settings.get_string("shading.visibility");
    if (asked == "baked" || asked == "rays" || asked == "traced")
      return "precomputed transfer holds all shadows (shading.visibility=" + asked + " has nothing to do)";
    return std::nullopt;
  };
  info.add_passes = [](const PlanInput& input, ShadingPlan* shading, FramePlan* plan) {
    const TransferForm form = choose_transfer_form(input.settings, input.facts);
    plan->passes.push_back({"transfer_vertices",
                            (form.joint ? "light of every vertex, by function of the materials; joint form: "
                                        : "light of every vertex, by component; form by views: ") +
                                form.reason,
                            {},
                            {"prt"}});
    plan->passes.push_back({"shade", "every visible pixel, by eigen-textures", {"surfaces", "prt"}, {"radiance"}});
    plan->left_out.push_back({words::kBandwidth, "mode " + shading->mode + " predicts nothing"});
  };
  info.views = {
      {"prt_vertices", "the vertex nearest to each point", ViewColors::color},
      {"prt_clusters", "clusters of the transfer of the materials' means", ViewColors::color},
      {"prt_light", "light on the materials' means: cosine and shadow times the environment, cd/m2",
       ViewColors::radiance},
      {"prt_component", "light on the first component of the materials, cd/m2; black where it takes light away",
       ViewColors::radiance},
      {"prt_error", "RMS error of the vertices' compressed transfer, relative to the mean of their material"},
      {"prt_kept", "light of the kept coefficients: over the sky, and what of it falls on parts, cd/m2",
       ViewColors::radiance}};
  info.words = {
      {Word::Kind::pass, "transfer_vertices",
       "sums of weights and relit components, for the sampled views near each vertex's"},
      {Word::Kind::feature, "prt", "the precomputed transfer"},
      {Word::Kind::counter, "prt_vertices", "with precomputed transfer"},
      {Word::Kind::counter, "prt_vertex_bytes", "of weights and clusters a vertex takes"},
      {Word::Kind::counter, "prt_coefficients", "of the light that are kept"},
      {Word::Kind::counter, "prt_error",
       "RMS of what light, transfer and materials lose in their factorisations, relative"},
      {Word::Kind::counter, "prt_pixels_without", "of the mode's parts that have no transfer, and stay black"},
      {Word::Kind::counter, "light_update_ms", "of the last change of light, until its sums are on the device"},
      {Word::Kind::pass, "bake_prt",
       "preparation: starts the bake of radiance transfer, or takes it over when it is done, and relights it"}};
  return info;
}

}  // namespace maquette
