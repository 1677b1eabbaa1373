#include "render/raytraced/technique.h"

#include "render/raytraced/tracer.h"
#include "render/reflections/technique.h"

namespace maquette {

Technique raytraced_technique() {
  Technique info;
  info.name = "raytraced";
  info.kind = TechniqueKind::reflector;
  info.help = "a ray for every pixel of a reflector: exact, the reference of the others, and slow where the driver is";
  info.can = {.keeps_hits = true, .skips_rays = true, .is_exact = true};
  info.make_reflector = make_raytraced_reflections;
  info.make_glossy = make_glossy_raytraced_reflections;
  info.quality_steps = resolution_steps();
  info.add_passes = [](const PlanInput&, ShadingPlan*, FramePlan* plan) {
    plan->passes.push_back(
        {"rays", "the mirrored ray of every pixel of a reflector, traced on the processor", {"rays"}, {"hits"}});
    add_resolve_pass(plan);
  };
  return info;
}

}  // namespace maquette
