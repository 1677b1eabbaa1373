#include "render/materials/texture_atlas.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace maquette {

namespace {

/// Converts sRGB bytes to square roots of linear light, which shaders decode with one multiplication. Alpha is kept.
void recode_srgb(std::vector<std::uint32_t>* texels) {
  std::array<std::uint32_t, 256> code{};
  for (std::size_t i = 0; i < code.size(); ++i) {
    const double v = static_cast<double>(i) / 255.0;
    const double linear = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    code[i] = static_cast<std::uint32_t>(std::sqrt(linear) * 255.0 + 0.5);
  }
  for (std::uint32_t& t : *texels)
    t = code[t & 255u] | code[t >> 8 & 255u] << 8 | code[t >> 16 & 255u] << 16 | (t & 0xff000000u);
}

/// Appends the mip chain of an image (box filter in the stored encoding) and returns the number of levels.
int append_mips(const TextureImage& image, bool srgb, std::vector<std::uint32_t>* texels) {
  std::vector<std::uint32_t> level(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  std::memcpy(level.data(), image.rgba.data(), level.size() * 4);
  if (srgb) recode_srgb(&level);
  int width = image.width, height = image.height, levels = 1;
  texels->insert(texels->end(), level.begin(), level.end());
  while (width > 1 || height > 1) {
    const int w = std::max(1, width / 2), h = std::max(1, height / 2);
    std::vector<std::uint32_t> next(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        std::uint32_t out = 0;
        for (int shift = 0; shift < 32; shift += 8) {
          std::uint32_t sum = 2;
          for (int k = 0; k < 4; ++k) {
            const int sx = std::min(2 * x + (k & 1), width - 1), sy = std::min(2 * y + (k >> 1), height - 1);
            sum += level[static_cast<std::size_t>(sy * width + sx)] >> shift & 255u;
          }
          out |= (sum / 4) << shift;
        }
        next[static_cast<std::size_t>(y * w + x)] = out;
      }
    }
    texels->insert(texels->end(), next.begin(), next.end());
    level = std::move(next);
    width = w;
    height = h;
    ++levels;
  }
  return levels;
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
  switch (role) {
    case TextureRole::base_color:
      return m.base_color_texture;
    case TextureRole::metallic_roughness:
      return m.metallic_roughness_texture;
    case TextureRole::normal:
      return m.normal_texture;
    case TextureRole::emissive:
      return m.emissive_texture;
    case TextureRole::occlusion:
      return m.occlusion_texture;
    default:
      return m.clearcoat_texture;
  }
}

TextureAtlas build_texture_atlas(const Scene& scene) {
  TextureAtlas atlas;
  StoredImages stored;
  stored.offsets.assign(2 * scene.images.size(), -1);
  stored.levels.assign(2 * scene.images.size(), 0);
  for (const Material& m : scene.materials) {
    std::array<int, kTextureRoles> textures;
    textures.fill(-1);
    for (std::size_t k = 0; k < kTextureRoles; ++k) {
      const auto role = static_cast<TextureRole>(k);
      const bool srgb = role == TextureRole::base_color || role == TextureRole::emissive;
      if (texture_of(m, role)) textures[k] = add_texture(scene, texture_of(m, role), srgb, &stored, &atlas);
    }
    atlas.of_material.push_back(textures);
  }
  return atlas;
}

}  // namespace maquette
