#pragma once

#include "render/technique/settings.h"
#include "render/technique/technique.h"

namespace maquette {

Technique octree_technique();

/// Levels by which cells of much detail may be finer than `octree.depth`; 0 where cells have BRDFs, which are as coarse
/// as the depth says.
int octree_detail(const Settings& settings);

}  // namespace maquette
