// The mean of a minified texture is the mean of its texels in linear light, for every size.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/packing.hpp>
#include <random>

#include "render/materials/texture_atlas.h"
#include "tests/support/chi_square.h"

namespace maquette {
namespace {

double linear_from_srgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

TEST(MipChain, EndsInTheMeanOfLinearLight) {
  std::mt19937 random(test::test_seed(5));
  for (const glm::ivec2& size :
       {glm::ivec2(1, 1), glm::ivec2(2, 2), glm::ivec2(3, 3), glm::ivec2(5, 2), glm::ivec2(7, 13), glm::ivec2(31, 1),
        glm::ivec2(33, 17), glm::ivec2(100, 75), glm::ivec2(64, 64)}) {
    Scene scene;
    TextureImage image;
    image.width = size.x;
    image.height = size.y;
    for (int i = 0; i < 4 * size.x * size.y; ++i)
      image.rgba.push_back(static_cast<std::uint8_t>(random() % 7 == 0 ? random() % 256 : random() % 12));
    glm::dvec4 as_color(0.0), as_data(0.0);
    for (std::size_t i = 0; i < image.rgba.size(); ++i) {
      const double v = image.rgba[i] / 255.0, share = 1.0 / (size.x * size.y);
      const auto c = static_cast<int>(i % 4);
      as_color[c] += share * (c == 3 ? v : linear_from_srgb(v));
      as_data[c] += share * v;
    }
    scene.images.push_back(image);
    Material m;
    m.emissive_texture.image = m.metallic_roughness_texture.image = 0;
    scene.materials.push_back(m);
    const TextureAtlas atlas = build_texture_atlas(scene);
    for (const auto& [role, mean] :
         {std::pair(TextureRole::emissive, as_color), std::pair(TextureRole::metallic_roughness, as_data)}) {
      const auto record = static_cast<std::size_t>(3 * atlas.of_material[0][static_cast<std::size_t>(role)]);
      std::size_t last = std::bit_cast<std::uint32_t>(atlas.records[record].x);
      int w = size.x, h = size.y;
      for (int level = 1; level < static_cast<int>(atlas.records[record].w); ++level) {
        last += static_cast<std::size_t>(w * h);
        w = std::max(w / 2, 1);
        h = std::max(h / 2, 1);
      }
      ASSERT_EQ(w * h, 1);
      const glm::vec2 rg = glm::unpackUnorm2x16(atlas.texels[last].x), ba = glm::unpackUnorm2x16(atlas.texels[last].y);
      for (int c = 0; c < 4; ++c) {
        double stored = static_cast<double>(c < 2 ? rg[c] : ba[c - 2]);
        if (role == TextureRole::emissive && c < 3) stored *= stored;
        EXPECT_NEAR(stored, mean[c], 1e-3 * mean[c] + 1e-6) << size.x << " x " << size.y << ", channel " << c;
      }
    }
  }
}

}  // namespace
}  // namespace maquette
