#pragma once

#include <map>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// The materials, with overrides from `sources`: material name (or `*`) -> MERL path, `builtin:NAME` or
/// `builtin:glass`.
std::vector<Material> override_materials(std::vector<Material> materials,
                                         const std::map<std::string, std::string>& sources);

/// Share of a material that is a pane of glass; the rest is an opaque surface. With `builtin:glass` or `extras` the
/// factor itself may be 0.
float pane_share(const Material& material);

}  // namespace maquette
