#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace maquette {

struct EmbeddedShader {
  std::string_view path;  ///< below shaders/
  std::string_view text;
};
/// Every shader of the build, written by cmake/write_embedded_shaders.cmake.
const std::vector<EmbeddedShader>& embedded_shaders();

}  // namespace maquette
