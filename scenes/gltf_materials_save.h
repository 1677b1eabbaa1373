#pragma once

#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// The materials of `scene` as glTF; adds textures and samplers to `root`, and names of extensions to `extensions`.
/// `path` is the file's path: measured tables in its folder or below are named relative to it.
std::vector<nlohmann::json> materials_to_json(const Scene& scene, const std::string& path, nlohmann::json* root,
                                              std::set<std::string>* extensions);

}  // namespace maquette
