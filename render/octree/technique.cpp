#include "render/octree/technique.h"

#include "render/octree/octree.h"

namespace maquette {

/// The scene's octree: traced visibility and the reflector technique of that name share it.
TechniqueInfo octree_technique() {
  TechniqueInfo info;
  info.name = "octree";
  info.kind = TechniqueKind::shared;
  info.help = "the scene's octree";
  info.settings = {
      {.name = "octree.depth",
       .default_value = 9,
       .min = 1,
       .max = kOctreeMaxDepth,
       .unit = "levels",
       .help = "cells are the width of the model / 2^depth (the part that holds nearly all triangles; what lies around "
               "it is "
               "coarser)"},
      {.name = "octree.bake",
       .default_value = std::string(),
       .help = "folder of `maquette bake octree`; empty: the cache"},
  };
  return info;
}

}  // namespace maquette
