#include "viewer/inspect_bake.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "render/technique/registry.h"
#include "scenes/bake_file.h"
#include "viewer/json_values.h"

namespace maquette {

std::optional<nlohmann::ordered_json> inspect_bake(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path file = fs::is_directory(path, ignored) ? fs::path(path) / "bake.exr" : fs::path(path);
  if (file.filename() != "bake.exr" || !fs::exists(file, ignored)) return std::nullopt;
  const BakeFile bake = load_bake_file(file.string());
  nlohmann::ordered_json json;
  json["kind"] = "bake";
  for (const auto& [name, value] : bake.attributes) json[name == "kind" ? "of" : name] = value;
  std::size_t blocks = 0, bytes = 0;
  const fs::path folder = file.parent_path().empty() ? fs::path(".") : file.parent_path();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".exr") continue;
    bytes += entry.file_size(ignored);
    blocks += entry.path().filename() != "bake.exr" ? 1 : 0;
  }
  json["blocks_done"] = blocks;
  json["bytes_on_disk"] = bytes;
  for (const BakeCommand& command : builtin_registry().bakes()) {
    const auto figures = command.inspect ? command.inspect(folder.string()) : std::nullopt;
    if (!figures) continue;
    for (const auto& [name, value] : *figures) {
      std::string pointer = "/" + name;
      std::replace(pointer.begin(), pointer.end(), '.', '/');
      json[nlohmann::ordered_json::json_pointer(pointer)] = number(value);
    }
  }
  return json;
}

}  // namespace maquette
