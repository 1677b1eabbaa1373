#pragma once

#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// The materials of `scene` as glTF; textures and samplers are added to `root`, names of extensions to `extensions`.
/// `path` is where the file will be: measured tables in its folder or below are named relative to it.
std::vector<nlohmann::json> materials_to_json(const Scene& scene, const std::string& path, nlohmann::json* root,
                                              std::set<std::string>* extensions);

}  // namespace maquette
