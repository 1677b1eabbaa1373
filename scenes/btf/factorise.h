#pragma once

#include <vector>

#include "scenes/btf/btf.h"

namespace maquette {

/// Directions of lights with what the factorisation needs of them, made once for all views that share them.
struct BtfLights {
  std::shared_ptr<const DirectionMesh> mesh;
  std::vector<double> shares;  ///< of the hemisphere, [light], sum 1
};
BtfLights make_btf_lights(std::vector<glm::dvec3> directions);

/// Factorises the images of one view by principal components, lights weighted by their solid angles: the components
/// minimise the error of rho over the hemisphere of lights. `images`: [light][texel][rgb] of rho, finite; overwritten.
/// Fills the finest level only. Weights have the mean square 1 over the lights, and the largest one is positive.
/// Missing rank (fewer lights than components) is filled with zeros. Cost: texels * lights^2.
/// Source: principal components by the Gram matrix of the smaller side, Sirovich 1987 ("method of snapshots"). It
/// squares the singular values: components below 1e-6 of the first one are noise.
BtfView factorise_btf_view(const glm::dvec3& direction, const BtfLights& lights, int components,
                           std::vector<float>* images);

}  // namespace maquette
