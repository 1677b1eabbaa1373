#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace maquette {

struct CommandLine;

/// What a bake's first file says of itself, how many blocks stand beside it, and the figures of its kind; nothing for
/// other files. Its path, its folder, or a folder with that one inside. The scene is the second file of the line, else
/// the one that the bake names, where it is there. Throws Error for a bake that is damaged.
std::optional<nlohmann::ordered_json> inspect_bake(const CommandLine& line);

}  // namespace maquette
