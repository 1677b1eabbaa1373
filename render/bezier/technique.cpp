#include "render/bezier/technique.h"

#include "render/reflections/technique.h"

namespace maquette {

TechniqueInfo bezier_technique() {
  TechniqueInfo info;
  info.name = "bezier";
  info.kind = TechniqueKind::reflector;
  info.help = "vertices projected into Bezier patches by Fermat's principle, edges bent by subdivision";
  info.settings = {
      {.name = "bezier.tolerance",
       .default_value = 0.5,
       .min = 0.05,
       .max = 16.0,
       .unit = "pixels",
       .help =
           "how far a reflected edge may bend before it is halved, in pixels of the reflected picture; the picture is "
           "the same, the time is not"},
      {.name = "bezier.levels",
       .default_value = 5,
       .min = 0,
       .max = 8,
       .help = "how often an edge may be halved for that"},
  };
  info.quality_steps = resolution_steps();
  info.quality_steps.push_back(
      {.settings = {{"reflections.resolution", std::string("full")}, {"bezier.tolerance", 0.125}}});
  info.add_passes = [](const SceneFacts&, const Settings&, const ViewInfo&, FramePlan* plan) {
    plan->passes.push_back({"projection", "the scene's triangles that may be seen in a patch, projected into it"});
  };
  return info;
}

}  // namespace maquette
