#include "render/bandwidth/technique.h"

#include "render/bandwidth/mode.h"

namespace maquette {

namespace {

void add_bandwidth_passes(const PlanInput& in, ShadingPlan* shading, FramePlan* plan) {
  const FrameStatus& status = in.status;
  const bool levels = in.settings.get_int("bandwidth.max_level") > 0;
  const auto add = [&](PlannedPass pass) { plan->passes.push_back(std::move(pass)); };
  shading->texture_bandwidth = in.facts.has_textures;
  add({"curvature", "the curvature of surfaces on the screen", {"surfaces"}, {"curvature"}});
  if (status.tables_swapped)
    add({"replaced_materials",
         "measured tables were swapped: lists the tiles that show them",
         {"surfaces"},
         {"replaced_materials"}});
  add({"bandwidth",
       status.light_rotated    ? "only the light rotated: predicted anew for a part of the tiles"
       : status.tables_swapped ? "only measured tables were swapped: predicted anew where they are seen"
                               : "predicts bandwidth and variance at every visible pixel",
       {"surfaces", "curvature"},
       {"prediction"}});
  add({"pyramid", "coarse levels of bandwidth, variance, depth and normals", {"prediction"}, {"prediction"}});
  if (status.accumulated > 0)
    add({"measure", "nothing moved: the frames so far say where samples are worth most", {"prediction"}, {"rates"}});
  add({"mark",
       levels ? "the points that the prediction asks for" : "every pixel: bandwidth.max_level is 0",
       {"prediction"},
       {"work"}});
  add({"shade",
       status.light_rotated
           ? std::string("only the light rotated: points are reused, corrected by what the rotation changed; ") +
                 (status.sun_apart ? "the sun is drawn apart, anew at each point"
                                   : "the environment has no sun to draw apart")
       : status.tables_swapped ? "only measured tables were swapped: the points of other materials are kept"
       : levels                ? "coarse to fine, only the pixels that the prediction asks for"
                               : "every pixel: bandwidth.max_level is 0",
       {"work"},
       {"radiance"}});
  if (levels || in.view.msaa > 1)
    add({"upsample", "bilateral over depth, normal and material", {"radiance"}, {"radiance"}});
  else
    plan->left_out.push_back({"upsample", "bandwidth.max_level is 0"});
  if (in.facts.has_textures)
    plan->features.push_back({"texture_bandwidth", "textures vary over the surface"});
  else
    plan->left_out.push_back({"texture_bandwidth", "no material has a texture"});
}

}  // namespace

Technique bandwidth_technique() {
  Technique info;
  info.name = "bandwidth";
  info.help = "predicted-bandwidth deferred shading: shades where the picture varies, interpolates elsewhere";
  info.settings = {
      {.name = "bandwidth.samples",
       .default_value = 64,
       .min = 1,
       .max = 65536,
       .unit = "samples",
       .help = "shading samples a shaded pixel, before the predicted variance scales them (--samples wins)"},
      {.name = "bandwidth.max_level",
       .default_value = 4,
       .min = 0,
       .max = 5,
       .help = "coarsest level: pixels shaded 2^level apart; 0 shades every pixel"},
      {.name = "bandwidth.quality",
       .default_value = 1.0,
       .min = 0.05,
       .max = 16.0,
       .help = "scales the predicted sampling rate: 2 shades twice as densely along each axis"},
  };
  for (int samples = 4; samples <= 4096; samples *= 4) info.quality_steps.push_back({.samples = samples});
  info.can = {.samples = true,
              .shadows = true,
              .indirect = true,
              .lights = true,
              .averages_points = true,
              .sweeps_visibility = true};
  info.samples_setting = "bandwidth.samples";
  info.make_mode = make_bandwidth_mode;
  info.shader_variants = bandwidth_shader_variants;
  info.views = bandwidth_views();
  info.add_passes = add_bandwidth_passes;
  info.words = {
      {Word::Kind::pass, "curvature", "curvature and footprint of surfaces along the screen, for the prediction"},
      {Word::Kind::pass, "replaced_materials", "lists the tiles that show a material whose measured table was swapped"},
      {Word::Kind::pass, "bandwidth", "predicts local bandwidth and variance at every visible pixel"},
      {Word::Kind::pass, "pyramid", "coarse levels of bandwidth, variance, depth and normals"},
      {Word::Kind::pass, "measure",
       "while nothing moves: how much each shaded point varies from sample to sample, and how far interpolation is "
       "from what points measure themselves"},
      {Word::Kind::pass, "upsample",
       "fills the pixels between, bilateral over depth, normal and material, along the footprint where it is "
       "stretched"},
      {Word::Kind::counter, "continued_points",
       "shaded points that reused their history, where only the light rotated"},
  };
  return info;
}

}  // namespace maquette
