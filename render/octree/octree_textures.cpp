#include "render/octree/octree_textures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "scenes/files.h"
#include "scenes/mip_chain.h"
#include "scenes/texels.h"

namespace maquette {

namespace {

/// Finer texels are averaged when the mip chain is made: cells are millimetres wide.
constexpr int kMaxSide = 512;

float wrapped(float x, Wrap wrap) {
  if (wrap == Wrap::clamp_to_edge) return std::clamp(x, 0.0f, 1.0f);
  const float cycle = std::floor(x);
  const float rest = x - cycle;
  return wrap == Wrap::mirrored_repeat && std::fmod(std::abs(cycle), 2.0f) >= 1.0f ? 1.0f - rest : rest;
}

}  // namespace

std::shared_ptr<const OctreeTextures::Chain> OctreeTextures::make_chain(const TextureImage& image) {
  auto chain = std::make_shared<Chain>();
  const Texels decode(image, true);
  MipLevel level{image.width, image.height, {}};
  if (std::max(image.width, image.height) <= kMaxSide) {
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) level.texels.push_back(decode(x, y));
    chain->push_back(level);
  }
  while (level.width > 1 || level.height > 1) {
    level = level.texels.empty() ? halve(level.width, level.height, decode) : halve(level);
    if (std::max(level.width, level.height) <= kMaxSide) chain->push_back(level);
  }
  return chain;
}

OctreeTextures::OctreeTextures(const Scene& scene, const std::vector<Material>& materials) {
  std::map<int, std::shared_ptr<const Chain>> chains;
  std::map<int, std::uint64_t> hashes;
  for (const Material& material : materials) {
    Entry entry;
    entry.alpha_masked = material.alpha_mode == AlphaMode::mask;
    const bool glows = material.emissive != glm::vec3(0.0f) && material.emissive_texture && !entry.alpha_masked;
    entry.reference = glows ? material.emissive_texture : material.base_color_texture;
    entry.alpha = material.base_color.a;
    entry.cutoff = material.alpha_cutoff;
    const int image = entry.reference.image;
    if (image >= 0 && image < static_cast<int>(scene.images.size())) {
      const TextureImage& source = scene.images[static_cast<std::size_t>(image)];
      if (!chains[image]) {
        chains[image] = make_chain(source);
        hashes[image] = content_hash(std::as_bytes(std::span(source.rgba)));
        if (!source.rgba16.empty())
          hashes[image] = content_hash(std::as_bytes(std::span(source.rgba16)), hashes[image]);
      }
      entry.chain = chains[image];
      const TextureRef& r = entry.reference;
      const float numbers[] = {r.offset.x,
                               r.offset.y,
                               r.scale.x,
                               r.scale.y,
                               r.rotation_rad,
                               static_cast<float>(r.uv_set),
                               static_cast<float>(r.wrap_s),
                               static_cast<float>(r.wrap_t)};
      entry.content = content_hash(std::as_bytes(std::span(numbers)), hashes[image]);
    }
    if (entry.alpha_masked) {
      const float mask[] = {entry.alpha, entry.cutoff};
      entry.content = content_hash(std::as_bytes(std::span(mask)), entry.content);
    }
    entries_.push_back(std::move(entry));
  }
}

bool OctreeTextures::textured(int material) const { return at(material) && at(material)->chain != nullptr; }
int OctreeTextures::uv_set(int material) const { return at(material) ? at(material)->reference.uv_set : 0; }

glm::vec4 OctreeTextures::mean_color(int material, const glm::vec2& uv, float uv_span) const {
  const Entry* entry = at(material);
  if (!entry || !entry->chain) return glm::vec4(1.0f);
  const TextureRef& r = entry->reference;
  // KHR_texture_transform: scale, then rotate, then move.
  const float c = std::cos(r.rotation_rad), s = std::sin(r.rotation_rad);
  const glm::vec2 scaled = uv * r.scale;
  const glm::vec2 at_uv = r.offset + glm::vec2(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x);
  const float span = uv_span * std::max(std::abs(r.scale.x), std::abs(r.scale.y));
  const Chain& chain = *entry->chain;
  const float texels = span * static_cast<float>(std::max(chain[0].width, chain[0].height));
  const int level = std::isfinite(texels) ? std::clamp(static_cast<int>(std::lround(std::log2(std::max(texels, 1.0f)))),
                                                       0, static_cast<int>(chain.size()) - 1)
                                          : static_cast<int>(chain.size()) - 1;
  const MipLevel& l = chain[static_cast<std::size_t>(level)];
  if (!std::isfinite(at_uv.x) || !std::isfinite(at_uv.y)) return chain.back().texels[0];
  const int x = std::clamp(static_cast<int>(wrapped(at_uv.x, r.wrap_s) * static_cast<float>(l.width)), 0, l.width - 1);
  const int y =
      std::clamp(static_cast<int>(wrapped(at_uv.y, r.wrap_t) * static_cast<float>(l.height)), 0, l.height - 1);
  return l.at(x, y);
}

}  // namespace maquette
