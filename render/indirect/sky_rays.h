#pragma once

#include <atomic>
#include <glm/glm.hpp>
#include <vector>

#include "render/indirect/indirect_light.h"

namespace maquette {

/// What irradiance from the visibility maps (sums over `cells`, which are those of `sky`) lacks or has too much of,
/// [side][point], by shadow rays to importance samples of the sky: each counts what passes along it less what the maps
/// say. Without bias but noisy; the mean over points counts. About 4 million rays in all. Zero without the scene of
/// `links`, and where `cancel` is set.
std::vector<glm::vec3> error_of_maps(const IndirectLinks& links, const VisibilityBake& bits, const IndirectSky& sky,
                                     const SkyCells& cells, const std::atomic<bool>& cancel);

}  // namespace maquette
