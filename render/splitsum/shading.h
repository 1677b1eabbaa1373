#pragma once

#include <memory>

#include "render/lookup_mode.h"

namespace maquette {

/// GGX maps of the sky at kGgxLevels roughnesses and the split-sum table.
/// Source: Karis 2013, "Real Shading in Unreal Engine 4".
std::unique_ptr<LookupMode> make_splitsum_shading(const Environment& environment);

}  // namespace maquette
