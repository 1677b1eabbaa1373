#pragma once

#include <cstddef>

#include "scenes/scene.h"

namespace maquette {

inline constexpr int kMaxSubdivisionLevels = 6;

/// Throws Error naming the fault: mismatched sizes, indices out of range, repeated corners, too many levels, NaN.
void check_cage(const SubdivisionCage& cage);

/// Number of indices of the limit surface at `cage.levels`, without computing it: 6 a quad.
std::size_t count_limit_indices(const SubdivisionCage& cage);

}  // namespace maquette
