#pragma once

#include "render/bake/bake_command.h"

namespace maquette {

/// `maquette bake octree`: the octree, and the BRDFs of its cells where `octree.brdf` asks for them.
BakeCommand octree_bake_command();

}  // namespace maquette
