#pragma once

#include <cstdint>
#include <vector>

#include "render/reference/path_scene.h"
#include "render/reflections/mirrored_layer.h"
#include "render/reflections/targets.h"

namespace maquette {

/// Of the scene's triangles, begin and end.
struct TriangleRange {
  std::uint32_t begin = 0, end = 0;
};

/// Writes `targets->tint`: per channel, the share of the light that panes and coverage between the mirrored rays'
/// origins and their hits leave, the one formula of panes (shaders/shared/fresnel.glsl). `own[k]`: triangles of
/// reflector k, which do not count for its own rays; empty: all count. Where something opaque lies in between, as
/// techniques that approximate may have it, it is passed over. `layers`: what blended surfaces add; null: these are
/// passed over too. On all cores.
void find_pane_tint(const PathScene& scene, const std::vector<TriangleRange>& own, ReflectionTargets* targets,
                    MirroredLayers* layers);

}  // namespace maquette
