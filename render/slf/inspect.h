#pragma once

#include <optional>
#include <string>

#include "render/bake/bake_command.h"

namespace maquette {

/// Of a whole bake of incident light: its light, and the RMS that local PCA of it has over clusters and components.
/// Nothing for other folders. Throws Error.
std::optional<BakeFigures> inspect_light_field(const std::string& folder);

}  // namespace maquette
