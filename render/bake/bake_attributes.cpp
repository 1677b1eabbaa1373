#include "render/bake/bake_attributes.h"

#include <filesystem>

namespace maquette {

std::string bake_name_of_scene(const std::string& scene) {
  if (scene.rfind("builtin:", 0) == 0) return scene.substr(8);
  return std::filesystem::path(scene).stem().string();
}

}  // namespace maquette
