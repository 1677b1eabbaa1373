#include "render/octree/technique.h"

#include "render/octree/bake_command.h"
#include "render/octree/octree.h"
#include "render/octree/reflections.h"

namespace maquette {

/// Traced visibility shares the octree and its settings.
Technique octree_technique() {
  Technique info;
  info.name = "octree";
  info.kind = TechniqueKind::reflector;
  info.help =
      "rays through the scene's octree, whose cells stand for the surfaces in them: the cost hardly grows with the "
      "scene";
  info.settings = {
      {.name = "octree.depth",
       .default_value = 9,
       .min = 1,
       .max = kOctreeMaxDepth,
       .unit = "levels",
       .help = "cells are the width of the model / 2^depth (the part that holds nearly all triangles; what lies around "
               "it is "
               "coarser)"},
      {.name = "octree.detail",
       .default_value = kOctreeMaxDetail,
       .min = 0,
       .max = kOctreeMaxDetail,
       .unit = "levels",
       .help =
           "so many levels finer are cells that hold several materials, writing, or a surface that turns; none where "
           "octree.brdf gives such cells a BRDF"},
      {.name = "octree.brdf",
       .default_value = std::string("none"),
       .help = "cells with a BRDF of their own, transparency included: none; mixed: those of several materials or not "
               "flat; all: the flat ones too, at the 98 directions of a cell instead of their material's own lobes",
       .choices = {"none", "mixed", "all"}},
      {.name = "octree.interest",
       .default_value = std::string(),
       .help = "what gets cells of octree.depth, two levels coarser elsewhere: names of nodes and boxes "
               "x0,y0,z0,x1,y1,z1 (m), separated by semicolons; empty: everything"},
      {.name = "octree.bake",
       .default_value = std::string(),
       .help = "folder of `maquette bake octree`, which is only read; empty: the cache"},
  };
  info.can = {.needs_octree = true, .hits_cells = true, .skips_rays = true, .skips_cheap_rays = true};
  info.has_effect = [](const Technique& mode, const Technique* reflector, const Settings& settings) {
    return (reflector && reflector->can.needs_octree) ||
           (mode.can.shadows && settings.get_string("shading.visibility") == "traced");
  };
  info.make_reflector = make_octree_reflections;
  info.make_glossy = make_glossy_octree_reflections;
  info.bakes = {octree_bake_command()};
  info.shader_variants = [] {
    std::vector<ShaderVariant> variants = octree_reflection_shader_variants();
    variants.push_back({"octree/trace_rays.comp", "", {}});  // of tests and benchmarks
    return variants;
  };
  info.quality_steps = {{.settings = {{"octree.depth", 7}, {"reflections.resolution", std::string("quarter")}}},
                        {.settings = {{"octree.depth", 8}, {"reflections.resolution", std::string("half")}}},
                        {.settings = {{"octree.depth", 9}, {"reflections.resolution", std::string("half")}}},
                        {.settings = {{"octree.depth", 9}, {"reflections.resolution", std::string("full")}}}};
  info.add_passes = [](const PlanInput&, ShadingPlan*, FramePlan* plan) {
    plan->passes.push_back(
        {"rays", "the mirrored ray of every pixel of a reflector, through the octree", {"rays"}, {"hits"}});
  };
  info.words = {
      {Word::Kind::counter, "octree_steps", "cells that the mirrored rays looked at"},
      {Word::Kind::counter, "cell_layers", "cells that were shaded by BRDFs of their own"},
      {Word::Kind::counter, "octree_fine_cells", "leaves of the finest level, also where visibility is traced"},
      {Word::Kind::counter, "octree_coarse_cells", "leaves of coarser levels"},
  };
  return info;
}

int octree_detail(const Settings& settings) {
  return settings.get_string("octree.brdf") == "none" ? settings.get_int("octree.detail") : 0;
}

}  // namespace maquette
