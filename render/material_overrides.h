#pragma once

#include <map>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// The materials with those of `sources` replaced: material name (or `*`) -> MERL path, `builtin:NAME` or
/// `builtin:glass`.
std::vector<Material> override_materials(std::vector<Material> materials,
                                         const std::map<std::string, std::string>& sources);

/// Share of a material that is a pane of glass; the rest of it is a surface. `builtin:glass` and `extras` may leave the
/// factor 0.
float pane_share(const Material& material);

}  // namespace maquette
