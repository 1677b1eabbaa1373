#include "render/slf/technique.h"

#include "render/frame/vocabulary.h"
#include "render/slf/bake_command.h"
#include "render/slf/mode.h"
#include "render/slf/store.h"

namespace maquette {

namespace {

std::vector<SettingDeclaration> light_field_settings() {
  return {
      {.name = "slf.texels",
       .default_value = 256,
       .min = 1,
       .max = kLargestAtlas,
       .unit = "texels",
       .help = "side of the atlas (wins over slf.texels_per_m)"},
      {.name = "slf.texels_per_m",
       .default_value = 0.0,
       .min = 0.0,
       .max = 100000.0,
       .unit = "1/m",
       .help = "density of texels, from which the atlas' side follows; 0: by slf.texels"},
      {.name = "slf.parts",
       .default_value = std::string(),
       .help = "names of nodes that get texels, with what is below them, separated by semicolons; empty: all opaque "
               "surfaces that the mode shades"},
      {.name = "slf.directions",
       .default_value = Lumisphere::kDefaultSide,
       .min = 1,
       .max = Lumisphere::kLargestSide,
       .unit = "bins",
       .help = "side of the parabolic maps of directions at a texel"},
      {.name = "slf.paths",
       .default_value = 32,
       .min = 1,
       .max = 4096,
       .unit = "paths",
       .help = "light paths through each bin of each texel; 16 will do for broad lobes"},
      {.name = "slf.basis",
       .default_value = std::string("haar"),
       .help = "how arriving light is multiplied with materials: bins: all of them; harmonics: of bands 0 to 5; haar: "
               "the coefficients that matter",
       .choices = {"bins", "harmonics", "haar"}},
      {.name = "slf.haar_error",
       .default_value = 0.005,
       .min = 0.0,
       .max = 1.0,
       .help = "share of outgoing light that leaving out Haar coefficients may change"},
      {.name = "slf.route",
       .default_value = std::string("fields"),
       .help =
           "fields: outgoing light is computed and compressed; clusters: arriving light and materials are "
           "compressed, and drawn by a table of what they make of each other (its 128 MiB are shared by their errors)",
       .choices = {"fields", "clusters"}},
      {.name = "slf.clusters",
       .default_value = 128,
       .min = 0,
       .max = kMostClusters,
       .help = "clusters of the compression; 1: plain principal components; 0: nothing is compressed"},
      {.name = "slf.components",
       .default_value = 8,
       .min = 0,
       .max = kMostComponents,
       .help = "components of each cluster; 0: its mean alone"},
      {.name = "slf.bake", .default_value = std::string(), .help = "folder of `maquette bake slf`; empty: the cache"},
      {.name = "slf.run",
       .default_value = std::string("auto"),
       .help = "auto: what is not baked is baked as soon as a frame needs it; hold: it is not, and a bake in work ends "
               "(what it has made is kept in the cache); what is there is shown, with a note of what has changed since",
       .choices = {"auto", "hold"}},
      {.name = "slf.slice_tilt",
       .default_value = 0.0,
       .min = 0.0,
       .max = 85.0,
       .unit = "degrees",
       .help = "of the direction of the view slf_slice from the normal of each texel"},
      {.name = "slf.slice_turn",
       .default_value = 0.0,
       .min = -360.0,
       .max = 360.0,
       .unit = "degrees",
       .help = "of that direction about the normal, from the texel's first tangent"},
      {.name = "slf.stale",
       .default_value = std::string("refuse"),
       .help = "a bake in slf.bake that was made under other light: refuse or show",
       .choices = {"refuse", "show"}},
  };
}

}  // namespace

Technique slf_technique() {
  Technique info;
  info.name = "slf";
  info.help = "surface light fields: the radiance that leaves each texel in each direction, baked with all light paths";
  info.settings = light_field_settings();
  for (const auto& [clusters, components] :
       {std::pair(1, 4), std::pair(8, 4), std::pair(32, 4), std::pair(128, 4), std::pair(128, 8), std::pair(0, 8)})
    info.quality_steps.push_back({.settings = {{"slf.clusters", clusters}, {"slf.components", components}}});
  info.make_mode = make_light_field_mode;
  info.shader_variants = light_field_shader_variants;
  info.own_bake = OwnBake{"slf", "the radiance that leaves its surfaces is looked up",
                          [] { return std::make_unique<LightFieldStore>(); }, true, light_field_bake_settings()};
  info.bakes = {light_field_bake_command()};
  info.check = [](const SceneFacts&, const Settings& settings) -> std::optional<std::string> {
    const std::string& asked = settings.get_string("shading.visibility");
    if (asked == "baked" || asked == "rays")
      return "surface light fields hold all shadows (shading.visibility=" + asked + " has nothing to do)";
    return std::nullopt;
  };
  info.add_passes = [](const PlanInput&, ShadingPlan* shading, FramePlan* plan) {
    plan->passes.push_back({"shade", "every visible pixel, by lookups", {"surfaces"}, {"radiance"}});
    plan->left_out.push_back({words::kBandwidth, "mode " + shading->mode + " predicts nothing"});
  };
  info.views = {
      {"slf_texels", "texels of the light field's atlas, in the colours of their charts", ViewColors::color},
      {"slf_charts", "charts of the light field's atlas", ViewColors::color},
      {"slf_clusters", "clusters of the compressed light field", ViewColors::color},
      {"slf_errors", "RMS that compression adds to a texel, relative to the mean of all"},
      {"slf_weights", "the first three weights of the compressed light field, as the colour of their direction",
       ViewColors::color},
      {"slf_slice",
       "radiance that leaves every texel in one direction of its frame (slf.slice_tilt, slf.slice_turn): a slice of "
       "the light field, as it is drawn",
       ViewColors::radiance}};
  info.words = {{Word::Kind::feature, "slf", "the surface light field"},
                {Word::Kind::counter, "slf_pixels", "that the light field showed"},
                {Word::Kind::counter, "slf_pixels_without", "of the mode's parts that have no texels, and stay black"},
                {Word::Kind::pass, "bake_slf",
                 "preparation: starts the bake of surface light fields, or takes it over when it is done"}};
  return info;
}

}  // namespace maquette
