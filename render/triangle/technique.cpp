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
  info.can = {.needs_eye = true, .keeps_hits = true};
  info.make_reflector = make_triangle_reflections;
  info.shader_variants = triangle_shader_variants;
  info.quality_steps = resolution_steps();
  info.add_passes = [](const PlanInput&, ShadingPlan*, FramePlan* plan) {
    plan->passes.push_back({"projection",
                            "the scene's triangles that may be seen in a triangle of a reflector, projected into it",
                            {"rays"},
                            {"hits"}});
    add_resolve_pass(plan);
  };
  info.words = {
      {Word::Kind::counter, "mirror_triangles", "of the reflectors"},
      {Word::Kind::counter, "mirrored_clusters", "pairs of a mirror triangle and a cluster of scene triangles"},
      {Word::Kind::counter, "cubic_roots", "that were searched"},
      {Word::Kind::counter, "unplaced_triangles", "kept by the mirrored frustum alone"},
      {Word::Kind::counter, "projected_vertices", "of the scene, in mirrors"},
      {Word::Kind::counter, "reflected_triangles", "that were drawn there"},
  };
  return info;
}

}  // namespace maquette
