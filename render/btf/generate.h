#pragma once

#include <string>

#include "render/btf/small_scale_light.h"
#include "scenes/btf/btf.h"

namespace maquette {

struct BtfGeneratorOptions {
  int texels = 256;  ///< along each side; cells a texel side: geometry.side / texels, whole
  int components = 8;
  double tile_m = 0.0256;
  std::vector<glm::dvec3> views, lights;
  SmallLightOptions light;
};

/// Ray traces the images of a SmallGeometry from all views under all lights, rectified to the base plane: a texel shows
/// what is seen from its view through its place in that plane, one ray through the middle of each of its cells. One
/// view after the other is factorised; the images of one are in memory at once. Deterministic. Cost: 2 rays for each
/// cell and direction, and one addition for each cell, view and light.
Btf generate_btf(const std::string& name, const SmallGeometry& geometry, const BtfGeneratorOptions& options,
                 const BtfTask& task = {});

/// The images of one view as rho, [light][texel][rgb], row 0 at +y. Adds the share of cell and light pairs in view that
/// no light reaches straight to `shadowed`, if it is given.
std::vector<float> trace_btf_view(const SmallGeometry& geometry, const TileRays& rays, const SmallScaleLight& light,
                                  const glm::dvec3& view, int texels, double* shadowed = nullptr);

}  // namespace maquette
