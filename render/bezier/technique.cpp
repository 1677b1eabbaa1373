#include "render/bezier/technique.h"

#include "render/bezier/projection.h"
#include "render/reflections/technique.h"

namespace maquette {

Technique bezier_technique() {
  Technique info;
  info.name = "bezier";
  info.kind = TechniqueKind::reflector;
  info.help = "vertices projected into Bezier patches by Fermat's principle, edges bent by subdivision";
  info.settings = {
      {.name = "bezier.tolerance",
       .default_value = 0.5,
       .min = 0.05,
       .max = 16.0,
       .unit = "pixels",
       .help = "the curvature of a reflected edge above which it is halved, in pixels of the reflected picture; the "
               "picture is "
               "the same, the time is not"},
      {.name = "bezier.levels",
       .default_value = 5,
       .min = 0,
       .max = 8,
       .help = "how often an edge may be halved for that"},
      {.name = "bezier.draw",
       .default_value = std::string("triangles"),
       .help = "triangles: what a pixel shows is held against its own ray; points: each vertex alone, where the patch "
               "shows it, with nothing between them",
       .choices = {"triangles", "points"}},
      {.name = "bezier.point_size",
       .default_value = 1,
       .min = 1,
       .max = 8,
       .unit = "pixels",
       .help = "side of a point, in pixels of the reflected picture"},
  };
  info.quality_steps = resolution_steps();
  info.quality_steps.push_back(
      {.settings = {{"reflections.resolution", std::string("full")}, {"bezier.tolerance", 0.125}}});
  info.can = {.needs_eye = true, .needs_patches = true, .keeps_hits = true};
  info.make_reflector = make_bezier_reflections;
  info.shader_variants = bezier_shader_variants;
  info.add_passes = [](const PlanInput& in, ShadingPlan*, FramePlan* plan) {
    const bool points = in.settings.get_string("bezier.draw") == "points";
    plan->passes.push_back({"projection",
                            points ? "vertices that may be seen in a patch, drawn as points"
                                   : "the scene's triangles that may be seen in a patch, projected into it",
                            {"rays"},
                            {"hits"}});
    add_resolve_pass(plan);
    if (points) plan->left_out.push_back({"resolve", "points are drawn: nothing lies between vertices"});
  };
  info.words = {
      {Word::Kind::counter, "newton_steps", "of the search for the mirrored points"},
      {Word::Kind::counter, "lost_vertices", "whose search failed"},
      {Word::Kind::counter, "uncertain_vertices", "perhaps seen more than once"},
      {Word::Kind::counter, "dropped_triangles", "that were not drawn"},
      {Word::Kind::counter, "uncertain_pixels",
       "hatched: shown beyond a caustic, or where a mesh's ray is far from its patch's"},
      {Word::Kind::counter, "halved_pieces", "of reflected triangles"},
      {Word::Kind::counter, "fitted_patches", "of curved meshes"},
      {Word::Kind::counter, "fit_error_mm", "of curved meshes: the largest distance of a vertex"},
  };
  return info;
}

}  // namespace maquette
