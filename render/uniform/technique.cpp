#include "render/uniform/technique.h"

#include "render/frame/vocabulary.h"
#include "render/uniform/mode.h"

namespace maquette {

Technique uniform_technique() {
  Technique info;
  info.name = "uniform";
  info.help = "the same estimator with a fixed count at every pixel: the baseline";
  info.settings = {
      {.name = "uniform.samples",
       .default_value = 64,
       .min = 1,
       .max = 65536,
       .unit = "samples",
       .help = "shading samples a pixel (--samples wins)"},
  };
  for (int samples = 4; samples <= 4096; samples *= 4) info.quality_steps.push_back({.samples = samples});
  info.can = {.samples = true, .shadows = true, .indirect = true, .lights = true};
  info.samples_setting = "uniform.samples";
  info.make_mode = make_uniform_mode;
  info.shader_variants = uniform_shader_variants;
  info.add_passes = [](const PlanInput&, ShadingPlan* shading, FramePlan* plan) {
    plan->passes.push_back({"mark", "lists every visible pixel", {"surfaces"}, {"work"}});
    plan->passes.push_back({"shade", "every visible pixel, a fixed count of samples", {"work"}, {"radiance"}});
    plan->left_out.push_back({words::kBandwidth, "mode " + shading->mode + " predicts nothing"});
    plan->left_out.push_back({"upsample", "every pixel is shaded"});
  };
  return info;
}

}  // namespace maquette
