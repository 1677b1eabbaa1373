#pragma once

#include <memory>

#include "render/prefilter/lookup_mode.h"

namespace maquette {

/// GGX maps of the sky at kGgxLevels roughnesses and the split-sum table.
/// Source: Karis 2013, "Real Shading in Unreal Engine 4".
std::unique_ptr<LookupTables> make_splitsum_tables(const Environment& environment);

}  // namespace maquette
