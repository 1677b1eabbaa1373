#pragma once

#include <string>
#include <vector>

namespace maquette {

/// Files that a .gltf or .glb names: its buffers and images, without `data:`. Nothing of a file that cannot be read.
std::vector<std::string> scene_files(const std::string& path);

}  // namespace maquette
