#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <span>
#include <string>

#include "scenes/bake_file.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette {

/// Sixteen digits.
inline std::string hex(std::uint64_t value) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

/// Of a bake file; throws Error naming `path` where it is not there.
inline std::string attribute(const std::string& path, const BakeFile& file, const std::string& name) {
  const auto found = file.attributes.find(name);
  if (found == file.attributes.end()) throw Error(path, "the bake has no attribute '" + name + "'", "bake it again");
  return found->second;
}

/// Key of what attributes say.
inline std::string key_of_attributes(const std::map<std::string, std::string>& attributes) {
  std::string text;
  for (const auto& [name, value] : attributes) text += name + "=" + value + ";";
  return hex(content_hash(std::as_bytes(std::span(text))));
}

/// Name of a scene for the folder of a bake: its file's stem, or what follows `builtin:`.
std::string bake_name_of_scene(const std::string& scene);

}  // namespace maquette
