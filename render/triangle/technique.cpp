#include "render/triangle/technique.h"

#include "render/reflections/nearest_hits.h"
#include "render/reflections/technique.h"
#include "render/triangle/reflections.h"

namespace maquette {

Technique triangle_technique() {
  Technique info;
  info.name = "triangle";
  info.kind = TechniqueKind::reflector;
  info.help =
      "vertices projected into triangles with normals, where the cubic of each has its root; serves meshes and patches";
  info.settings = {
      {.name = "triangle.side",
       .default_value = 8,
       .min = 2,
       .max = 32,
       .help = "a patch becomes this many quads a side; the picture is the same, the time is not"},
  };
  info.can.keeps_hits = true;
  info.make_reflector = make_triangle_reflections;
  info.shader_variants = triangle_shader_variants;
  info.quality_steps = resolution_steps();
  info.add_passes = [](const PlanInput&, ShadingPlan*, FramePlan* plan) {
    plan->passes.push_back(
        {"projection", "the scene's triangles that may be seen in a triangle of a reflector, projected into it", {"rays"},
         {"hits"}});
    add_resolve_pass(plan);
  };
  return info;
}

}  // namespace maquette
