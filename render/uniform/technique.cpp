#include "render/uniform/technique.h"

namespace maquette {

TechniqueInfo uniform_technique() {
  TechniqueInfo info;
  info.name = "uniform";
  info.help = "the same estimator with a fixed count at every pixel: the baseline";
  info.default_samples = 64;
  info.settings = {
      {.name = "uniform.samples",
       .default_value = 64,
       .min = 1,
       .max = 65536,
       .unit = "samples",
       .help = "shading samples a pixel (--samples wins)"},
  };
  for (int samples = 4; samples <= 4096; samples *= 4) info.quality_steps.push_back({.samples = samples});
  info.add_passes = [](const SceneFacts&, const Settings&, const ViewInfo&, FramePlan* plan) {
    plan->passes.push_back({"shade", "every visible pixel, a fixed count of samples"});
    plan->left_out.push_back({"bandwidth", "mode uniform predicts nothing"});
    plan->left_out.push_back({"upsample", "every pixel is shaded"});
  };
  return info;
}

}  // namespace maquette
