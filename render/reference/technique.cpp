#include "render/reference/technique.h"

#include "render/frame/vocabulary.h"
#include "render/reference/mode.h"

namespace maquette {

Technique reference_technique() {
  Technique info;
  info.name = "reference";
  info.help = "progressive path tracing on the processor: what the other modes are judged by";
  info.settings = {
      {.name = "reference.samples",
       .default_value = 64,
       .min = 1,
       .max = 1048576,
       .unit = "paths",
       .help = "paths a pixel (--samples wins)"},
      {.name = "reference.transport",
       .default_value = std::string("full"),
       .help =
           "full: all light paths; direct: what uniform with shading.visibility=none claims, the environment and the "
           "scene's lights without shadows",
       .choices = {"full", "direct"}},
      {.name = "reference.bounces",
       .default_value = 64,
       .min = 0,
       .max = 4096,
       .unit = "bounces",
       .help = "longest path in full transport; roulette ends nearly all before"},
      {.name = "reference.adaptive",
       .default_value = true,
       .help = "paths go where the picture is noisy; false: the same number for every pixel"},
  };
  for (int samples = 1; samples <= 1024; samples *= 4) info.quality_steps.push_back({.samples = samples});
  info.restricted_settings = {{"reference.transport", std::string("direct")}};
  info.can = {.samples = true, .shadows = false, .indirect = false, .lights = true, .traces_picture = true};
  info.samples_setting = "reference.samples";
  info.make_picture_mode = make_reference_mode;
  info.add_passes = [](const PlanInput& in, ShadingPlan* shading, FramePlan* plan) {
    const bool full = in.settings.get_string("reference.transport") == "full";
    plan->passes.push_back({"trace",
                            std::to_string(in.facts.triangle_count) + " triangles, paths through every pixel, " +
                                (full ? "all light paths" : "direct light without shadows"),
                            {},
                            {"picture"}});
    for (const char* word : {"raster", "gbuffer", "shade"}) plan->left_out.push_back({word, "rays find what is seen"});
    plan->left_out.push_back({words::kBandwidth, "mode " + shading->mode + " predicts nothing"});
    plan->left_out.push_back({"upsample", "every pixel is traced"});
    if (full)
      plan->features.push_back({"visibility", "every ray finds its own shadows"});
    else
      plan->left_out.push_back({"visibility", "reference.transport is direct"});
    if (full)
      plan->features.push_back({"indirect", "paths go on from surface to surface"});
    else
      plan->left_out.push_back({"indirect", "reference.transport is direct"});
  };
  info.words = {
      {Word::Kind::pass, "trace", "rays on the processor, from what is seen to what lights it"},
      {Word::Kind::counter, "paths", "in the picture so far"},
      {Word::Kind::counter, "rays", "in the picture so far; of reflector techniques: mirrored rays that were followed"},
  };
  return info;
}

}  // namespace maquette
