#pragma once

#include <cstring>
#include <glm/glm.hpp>
#include <vector>

#include "render/gl/objects.h"
#include "render/lights/light_grid.h"

namespace maquette {

/// The sampled lights on the GPU, and the grid by which they are chosen: three texels of the grid's place, one a
/// cluster (its first light and their number), the cells' rows, four texels a light (shaders/shading/lights.glsl).
class LightBuffers {
 public:
  explicit LightBuffers(const LightList& list)
      : count_(static_cast<int>(list.lights.size())),
        buffer_(Buffer::from("lights", texels_of(build_light_grid(list)))),
        view_(Texture::make_buffer("lights", GL_RGBA32F, buffer_)) {}
  int count() const { return count_; }
  void bind() const { glBindTextureUnit(27, view_.get()); }
  std::size_t bytes() const { return buffer_.bytes(); }

 private:
  static std::vector<glm::vec4> texels_of(const LightGrid& grid) {
    std::vector<glm::vec4> texels{{grid.low, static_cast<float>(grid.stride / 4)},
                                  {1.0f / grid.cell_size, static_cast<float>(grid.clusters())},
                                  {glm::vec3(grid.cells), 0.0f}};
    for (int k = 0; k < grid.clusters(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      texels.push_back({grid.first[i], grid.first[i + 1] - grid.first[i], 0.0f, 0.0f});
    }
    const std::size_t rows = texels.size(), lights = rows + grid.cumulative.size() / 4;
    texels[2].w = static_cast<float>(lights);
    texels.resize(lights + 4 * grid.lights.size());
    std::memcpy(&texels[rows], grid.cumulative.data(), grid.cumulative.size() * sizeof(float));
    std::memcpy(&texels[lights], grid.lights.data(), grid.lights.size() * sizeof(LightRecord));
    return texels;
  }
  int count_ = 0;
  Buffer buffer_;
  Texture view_;
};

}  // namespace maquette
