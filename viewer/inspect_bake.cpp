#include "viewer/inspect_bake.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "render/technique/registry.h"
#include "scenes/bake_file.h"
#include "viewer/command_line.h"
#include "viewer/json_values.h"
#include "viewer/session.h"

namespace maquette {

namespace {

namespace fs = std::filesystem;

/// The first file of a bake; empty: there is none.
fs::path manifest_of(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored))
    return path.filename() == "bake.exr" && fs::exists(path, ignored) ? path : fs::path();
  if (fs::exists(path / "bake.exr", ignored)) return path / "bake.exr";
  std::vector<fs::path> inside;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, ignored))
    if (fs::exists(entry.path() / "bake.exr", ignored)) inside.push_back(entry.path() / "bake.exr");
  return inside.size() == 1 ? inside.front() : fs::path();
}

/// Null where it is not known or not there.
std::shared_ptr<const Scene> scene_of(const CommandLine& line, const BakeFile& bake) {
  SceneOptions options = line.options;
  const auto named = bake.attributes.find("scene_file");
  std::error_code ignored;
  if (line.files.size() > 1)
    options.scene = line.files[1];
  else if (named != bake.attributes.end() &&
           (named->second.starts_with("builtin:") || fs::exists(named->second, ignored)))
    options.scene = named->second;
  else
    return nullptr;
  return load_session_scene(options);
}

}  // namespace

std::optional<nlohmann::ordered_json> inspect_bake(const CommandLine& line) {
  const fs::path file = manifest_of(line.files[0]);
  if (file.empty()) return std::nullopt;
  std::error_code ignored;
  const BakeFile bake = load_bake_file(file.string());
  nlohmann::ordered_json json;
  json["kind"] = "bake";
  for (const auto& [name, value] : bake.attributes)
    if (!name.starts_with("list.")) json[name == "kind" ? "of" : name] = value;
  std::size_t blocks = 0, bytes = 0;
  const fs::path folder = file.parent_path().empty() ? fs::path(".") : file.parent_path();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".exr") continue;
    bytes += entry.file_size(ignored);
    blocks += entry.path().filename() != "bake.exr" ? 1 : 0;
  }
  json["blocks_done"] = blocks;
  json["bytes_on_disk"] = bytes;
  const std::shared_ptr<const Scene> scene = scene_of(line, bake);
  for (const BakeCommand& command : builtin_registry().bakes()) {
    const auto figures = command.inspect ? command.inspect(folder.string(), scene.get()) : std::nullopt;
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
