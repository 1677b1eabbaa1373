#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace maquette {

/// What a bake's first file says of itself, and how many blocks stand beside it; nothing for other EXR files. Throws
/// Error for a bake that is damaged.
std::optional<nlohmann::ordered_json> inspect_bake(const std::string& path);

}  // namespace maquette
