#pragma once

#include <cstddef>
#include <string>

#include "render/slf/light_field.h"

namespace maquette::bench {

/// Bytes of outgoing light as one half-float EXR a direction (ZIP), of covered texels and the disc's bins only; the
/// files are written to `scratch` one by one.
std::size_t bytes_of_slices(const OutgoingField& field, const std::string& scratch);
/// Bytes of the same compressed, as they are drawn with: cluster, normal and weights of covered texels, means and
/// components of the disc's bins.
std::size_t bytes_resident(const LightField& field, std::size_t texels, std::size_t bins);

}  // namespace maquette::bench
