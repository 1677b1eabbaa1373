#include "render/splitsum/technique.h"

namespace maquette {

TechniqueInfo splitsum_technique() {
  TechniqueInfo info;
  info.name = "splitsum";
  info.help = "a prefiltered GGX fit of every material, as other viewers do";
  info.check = [](const SceneFacts&, const Settings& settings) -> std::optional<std::string> {
    if (settings.get_string("shading.visibility") == "baked")
      return "mode splitsum knows no visibility (shading.visibility=baked); use mode bandwidth or uniform";
    return std::nullopt;
  };
  info.add_passes = [](const SceneFacts&, const Settings&, const ViewInfo&, FramePlan* plan) {
    plan->passes.push_back({"prefilter", "the environment filtered for each roughness, once"});
    plan->passes.push_back({"shade", "every visible pixel, by lookups"});
    plan->left_out.push_back({"bandwidth", "mode splitsum predicts nothing"});
    plan->left_out.push_back({"sampling", "lookups take no samples: --samples has no effect"});
  };
  return info;
}

}  // namespace maquette
