#include "render/materials/texture_atlas.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <set>

#include "scenes/error.h"
#include "scenes/mip_chain.h"
#include "scenes/parallel.h"
#include "scenes/texels.h"

namespace maquette {

namespace {

/// A texel of 4 x 16 bits; colours as square roots of linear light, which shaders decode with one multiplication.
glm::uvec2 encode(const glm::vec4& linear, bool srgb) {
  const glm::vec4 c = srgb ? glm::vec4(glm::sqrt(glm::vec3(linear)), linear.a) : linear;
  return {glm::packUnorm2x16({c.r, c.g}), glm::packUnorm2x16({c.b, c.a})};
}

/// Appends the mip chain of an image, filtered in linear light, and returns the number of levels.
int append_mips(const TextureImage& image, bool srgb, std::vector<glm::uvec2>* texels) {
  const Texels decode(image, srgb);
  const auto append = [&](int width, int height, const auto& texel) {
    const std::size_t first = texels->size();
    texels->resize(first + static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    parallel_for(0, height, [&](int y) {
      glm::uvec2* row = texels->data() + first + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      for (int x = 0; x < width; ++x) row[x] = encode(texel(x, y), srgb);
    });
  };
  append(image.width, image.height, decode);
  int levels = 1;
  MipLevel level{image.width, image.height, {}};
  while (level.width > 1 || level.height > 1) {
    level = levels == 1 ? halve(level.width, level.height, decode) : halve(level);
    append(level.width, level.height, [&](int x, int y) { return level.at(x, y); });
    ++levels;
  }
  return levels;
}

std::size_t chain_texels(int width, int height) {
  std::size_t texels = 0;
  for (;; width = std::max(1, width / 2), height = std::max(1, height / 2)) {
    texels += static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (width == 1 && height == 1) return texels;
  }
}

/// Texels that the atlas of a scene will have. An image that is read both as colour and as data counts twice.
std::size_t count_texels(const Scene& scene) {
  std::set<std::pair<int, bool>> stored;
  std::size_t texels = 0;
  for (const Material& m : scene.materials)
    for (std::size_t k = 0; k < kTextureRoles; ++k) {
      const auto role = static_cast<TextureRole>(k);
      const int index = texture_of(m, role).image;
      if (index < 0 || !stored.emplace(index, is_colour(role)).second) continue;
      const TextureImage& image = scene.images[static_cast<std::size_t>(index)];
      texels += chain_texels(image.width, image.height);
    }
  return texels;
}

/// Codes of shaders/shared/texture_filter.glsl.
int wrap_code(Wrap wrap) { return wrap == Wrap::repeat ? 0 : wrap == Wrap::mirrored_repeat ? 1 : 2; }

/// Images in the atlas so far; an image that is read both as colour and as data is stored twice.
struct StoredImages {
  std::vector<int> offsets, levels;  // [2 * image + srgb]; offset -1: not yet
};

int add_texture(const Scene& scene, const TextureRef& r, bool srgb, StoredImages* stored, TextureAtlas* atlas) {
  const auto image_index = static_cast<std::size_t>(r.image);
  const TextureImage& image = scene.images[image_index];
  const std::size_t slot = 2 * image_index + (srgb ? 1 : 0);
  if (stored->offsets[slot] < 0) {
    stored->offsets[slot] = static_cast<int>(atlas->texels.size());
    stored->levels[slot] = append_mips(image, srgb, &atlas->texels);
  }
  const float c = std::cos(r.rotation_rad), s = std::sin(r.rotation_rad);
  atlas->records.emplace_back(std::bit_cast<float>(stored->offsets[slot]), image.width, image.height,
                              stored->levels[slot]);
  // KHR_texture_transform: uv' = translation * rotation * scale * uv, rotation counter-clockwise in UV with v down.
  atlas->records.emplace_back(c * r.scale.x, s * r.scale.y, -s * r.scale.x, c * r.scale.y);
  const int flags = (srgb ? 1 : 0) | (r.uv_set == 1 ? 2 : 0) | (r.nearest ? 4 : 0);
  atlas->records.emplace_back(r.offset, wrap_code(r.wrap_s) + 4 * wrap_code(r.wrap_t), flags);
  atlas->images.push_back(r.image);
  return static_cast<int>(atlas->images.size()) - 1;
}

}  // namespace

const TextureRef& texture_of(const Material& m, TextureRole role) {
  static_assert(kMaterialTextures.size() == kTextureRoles);
  return m.*kMaterialTextures[static_cast<std::size_t>(role)];
}

bool is_colour(TextureRole role) {
  return role == TextureRole::base_color || role == TextureRole::emissive || role == TextureRole::specular_color ||
         role == TextureRole::sheen_color;
}

TextureAtlas build_texture_atlas(const Scene& scene) {
  TextureAtlas atlas;
  // What 32 bits of offsets hold; drivers may have a lower limit.
  constexpr std::size_t kMostTexels = std::size_t{1} << 30;
  const std::size_t texels = count_texels(scene);
  if (texels > kMostTexels)
    throw Error(scene.name, "its textures have " + std::to_string(texels) + " texels with their mip chains",
                "use smaller images");
  atlas.texels.reserve(texels);
  StoredImages stored;
  stored.offsets.assign(2 * scene.images.size(), -1);
  stored.levels.assign(2 * scene.images.size(), 0);
  for (const Material& m : scene.materials) {
    std::array<int, kTextureRoles> textures;
    textures.fill(-1);
    for (std::size_t k = 0; k < kTextureRoles; ++k) {
      const auto role = static_cast<TextureRole>(k);
      if (texture_of(m, role)) textures[k] = add_texture(scene, texture_of(m, role), is_colour(role), &stored, &atlas);
    }
    atlas.of_material.push_back(textures);
  }
  return atlas;
}

}  // namespace maquette
