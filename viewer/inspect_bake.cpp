#include "viewer/inspect_bake.h"

#include <filesystem>

#include "scenes/bake_file.h"
#include "scenes/error.h"

namespace maquette {

std::optional<nlohmann::ordered_json> inspect_bake(const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path file(path);
  if (file.filename() != "bake.exr") return std::nullopt;
  const BakeFile bake = load_bake_file(path);
  nlohmann::ordered_json json;
  json["kind"] = "bake";
  for (const auto& [name, value] : bake.attributes) json[name == "kind" ? "of" : name] = value;
  std::size_t blocks = 0, bytes = 0;
  std::error_code ignored;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(file.parent_path().empty() ? "." : file.parent_path())) {
    if (entry.path().extension() != ".exr") continue;
    bytes += entry.file_size(ignored);
    blocks += entry.path().filename() != "bake.exr" ? 1 : 0;
  }
  json["blocks_done"] = blocks;
  json["bytes_on_disk"] = bytes;
  return json;
}

}  // namespace maquette
