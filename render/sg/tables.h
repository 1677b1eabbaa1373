#pragma once

#include <memory>

#include "render/prefilter/lookup_mode.h"

namespace maquette {

/// Maps of the sky convolved with spherical Gaussians over a ladder of sharpness, and the lobes' energies.
/// Source: Wang et al. 2009, "All-Frequency Rendering of Dynamic, Spatially-Varying Reflectance".
std::unique_ptr<LookupTables> make_sg_tables(const Environment& environment);

}  // namespace maquette
