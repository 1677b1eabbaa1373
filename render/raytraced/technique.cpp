#include "render/raytraced/technique.h"

#include "render/reflections/technique.h"

namespace maquette {

TechniqueInfo raytraced_technique() {
  TechniqueInfo info;
  info.name = "raytraced";
  info.kind = TechniqueKind::reflector;
  info.help = "a ray for every pixel of a reflector: exact, the reference of the others, and slow where the driver is";
  info.quality_steps = resolution_steps();
  info.add_passes = [](const SceneFacts&, const Settings&, const ViewInfo&, FramePlan* plan) {
    plan->passes.push_back({"rays", "the mirrored ray of every pixel of a reflector, traced on the processor"});
  };
  return info;
}

}  // namespace maquette
