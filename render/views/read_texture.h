#pragma once

#include <cstddef>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "render/gl/objects.h"

namespace maquette {

/// All texels of level 0, row by row.
template <typename T>
std::vector<T> read_texture(const Texture& texture, GLenum format, GLenum type, int channels) {
  std::vector<T> data(static_cast<std::size_t>(texture.width()) * static_cast<std::size_t>(texture.height()) *
                      static_cast<std::size_t>(channels));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(texture.get(), 0, format, type, static_cast<GLsizei>(data.size() * sizeof(T)), data.data());
  return data;
}

/// Of images of four channels: `value` gets those of the grid point, or of the block of `points_a_side` that it is in.
template <typename T, typename Value>
std::function<glm::vec3(int, int)> value_of_texels(const Texture& source, GLenum format, GLenum type,
                                                   int points_a_side, Value value) {
  return [w = source.width(), texels = read_texture<T>(source, format, type, 4), points_a_side, value](int x, int y) {
    return value(&texels[4 * static_cast<std::size_t>(y / points_a_side * w + x / points_a_side)]);
  };
}

}  // namespace maquette
