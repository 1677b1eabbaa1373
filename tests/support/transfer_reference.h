#pragma once

#include <cstdint>
#include <vector>

#include "render/prt/cube_light.h"
#include "render/prt/transfer_mesh.h"
#include "render/reference/path_scene.h"
#include "scenes/image.h"

namespace maquette::test {

/// What the picture of precomputed transfer is held against: at every pixel the sum over all directions of a light
/// cube, with the pixel's own view, texels and shadows.
struct TransferReference {
  const PathScene& scene;  ///< with BTFs
  const CubeDirections& cube;
  CubeLight light;
  int rays = 2;        ///< a side of a direction's texel, as the bake
  int components = 2;  ///< of the BTFs, besides the mean
  /// What arrives is found at its vertices, and is linear between them; null: at each pixel. Of the scene's geometry.
  const TransferMesh* vertices = nullptr;
  std::vector<std::uint32_t> light_of = {};  ///< [vertex] whose light it has (light_sources)
};

/// Radiance of what is seen; alpha 1 where that is a surface with a BTF.
Image trace_transfer_reference(const TransferReference& reference, const CameraView& camera, int width, int height);

}  // namespace maquette::test
