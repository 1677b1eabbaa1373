#include "scenes/scene_files.h"

#include <nlohmann/json.hpp>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_file.h"
#include "scenes/json_fault.h"

namespace maquette {

std::vector<std::string> scene_files(const std::string& path) {
  constexpr int kMostNested = 200;  // as parse_checked has it
  std::vector<std::string> files;
  try {
    const std::vector<std::byte> bytes = read_file(path);
    gltf::Warnings ignored;
    const auto text = gltf::split_container(path, bytes, &ignored).json;
    if (has_too_many_values(text) || is_nested_deeper(text, kMostNested)) return files;
    const nlohmann::json root = nlohmann::json::parse(text);
    for (const char* array : {"buffers", "images"}) {
      if (!root.contains(array)) continue;
      for (const nlohmann::json& element : root.at(array)) {
        const std::string uri = element.is_object() ? element.value("uri", std::string()) : std::string();
        if (!uri.empty() && !gltf::is_data_uri(uri)) files.push_back(gltf::resolve_uri(path, uri));
      }
    }
  } catch (const Error&) {
    files.clear();
  } catch (const nlohmann::json::exception&) {
    files.clear();
  }
  return files;
}

}  // namespace maquette
