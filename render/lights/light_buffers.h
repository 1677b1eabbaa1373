#pragma once

#include <cstring>
#include <glm/glm.hpp>
#include <vector>

#include "render/gl/bindings.h"
#include "render/gl/objects.h"
#include "render/lights/light_grid.h"

namespace maquette {

/// The sampled lights on the GPU, and the grid that chooses them: three texels for the grid's position and size, one
/// for each node of the tree, the cells' rows (sums, nodes, light), and four texels for each light
/// (shaders/shading/lights.glsl).
class LightBuffers {
 public:
  explicit LightBuffers(const LightList& list)
      : count_(static_cast<int>(list.lights.size())),
        buffer_(Buffer::from("lights", texels_of(build_light_grid(list)))),
        view_(Texture::make_buffer("lights", GL_RGBA32F, buffer_)) {}
  int count() const { return count_; }
  void bind() const { glBindTextureUnit(kUnitLights, view_.get()); }
  std::size_t bytes() const { return buffer_.bytes(); }

 private:
  static std::vector<glm::vec4> texels_of(const LightGrid& grid) {
    std::vector<glm::vec4> texels{{grid.low, static_cast<float>(grid.stride / 4)},
                                  {1.0f / grid.cell_size, static_cast<float>(grid.nodes.size())},
                                  {glm::vec3(grid.cells), 0.0f}};
    for (const LightNode& node : grid.nodes) texels.push_back({node.first, node.count, node.before, node.share});
    const auto stride = static_cast<std::size_t>(grid.stride);
    for (std::size_t cell = 0; cell < grid.lux.size(); ++cell) {
      for (std::size_t k = cell * stride; k < (cell + 1) * stride; k += 4)
        texels.push_back({grid.cumulative[k], grid.cumulative[k + 1], grid.cumulative[k + 2], grid.cumulative[k + 3]});
      for (std::size_t k = cell * stride; k < (cell + 1) * stride; k += 4)
        texels.push_back({grid.cut[k], grid.cut[k + 1], grid.cut[k + 2], grid.cut[k + 3]});
      texels.push_back({grid.lux[cell], 0.0f, 0.0f, 0.0f});
    }
    const std::size_t lights = texels.size();
    texels[2].w = static_cast<float>(lights);
    texels.resize(lights + 4 * grid.lights.size());
    std::memcpy(static_cast<void*>(texels.data() + lights), grid.lights.data(),
                grid.lights.size() * sizeof(LightRecord));
    return texels;
  }
  int count_ = 0;
  Buffer buffer_;
  Texture view_;
};

}  // namespace maquette
