#include "render/bandwidth/technique.h"

namespace maquette {

TechniqueInfo bandwidth_technique() {
  TechniqueInfo info;
  info.name = "bandwidth";
  info.help = "predicted-bandwidth deferred shading: shades where the picture varies, interpolates elsewhere";
  info.default_samples = 64;
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
  info.add_passes = [](const SceneFacts& facts, const Settings& settings, const ViewInfo&, FramePlan* plan) {
    plan->texture_bandwidth = facts.has_textures;
    plan->passes.push_back({"bandwidth", "predicts bandwidth and variance at every visible pixel"});
    if (settings.get_int("bandwidth.max_level") > 0) {
      plan->passes.push_back({"pyramid", "coarse levels of bandwidth, variance, depth and normals"});
      plan->passes.push_back({"shade", "coarse to fine, only the pixels that the prediction asks for"});
      plan->passes.push_back({"upsample", "bilateral over depth, normal and material"});
    } else {
      plan->passes.push_back({"shade", "every pixel: bandwidth.max_level is 0"});
      plan->left_out.push_back({"pyramid", "bandwidth.max_level is 0"});
      plan->left_out.push_back({"upsample", "bandwidth.max_level is 0"});
    }
    if (facts.has_textures)
      plan->passes.push_back({"texture_bandwidth", "textures vary over the surface"});
    else
      plan->left_out.push_back({"texture_bandwidth", "no material has a texture"});
  };
  return info;
}

}  // namespace maquette
