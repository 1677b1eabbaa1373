// Writes built-in scenes as .glb files: store_scenes FOLDER NAME...
#include <cstdio>
#include <exception>
#include <string>

#include "scenes/scene.h"

int main(int count, char** arguments) try {
  for (int i = 2; i < count; ++i) {
    const std::string name = arguments[i];
    maquette::save_glb(std::string(arguments[1]) + "/" + name + ".glb", maquette::load_scene("builtin:" + name));
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "store_scenes: %s\n", error.what());
  return 1;
}
