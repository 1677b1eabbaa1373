#pragma once

#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// All numbers of the punctual lights that shine, and where they stand, for hashes of content.
std::vector<float> light_numbers(const Scene& scene);

}  // namespace maquette
