#pragma once

#include <cstddef>

#include "scenes/scene.h"

namespace maquette {

inline constexpr int kMaxSubdivisionLevels = 6;

/// Throws Error naming the fault: sizes that do not match, indices out of range, repeated corners, too many levels,
/// NaN.
void check_cage(const SubdivisionCage& cage);

/// What the limit surface has at `cage.levels`, without computing it: 6 indices a quad.
std::size_t count_limit_indices(const SubdivisionCage& cage);

}  // namespace maquette
