#pragma once

#include <memory>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

struct MipLevel;

/// Mean colours of textures for the octree's cells: small mip chains of linear RGBA on the CPU.
class OctreeTextures {
 public:
  /// Keeps only the textures that represent a material's colour: the emission texture if the material has one and is
  /// not cut out, otherwise the base colour texture.
  OctreeTextures(const Scene& scene, const std::vector<Material>& materials);

  bool textured(int material) const;
  int uv_set(int material) const;
  /// The texture's colour (1 without a texture) with alpha, averaged over about `uv_span` (units of UV) around `uv`.
  glm::vec4 mean_color(int material, const glm::vec2& uv, float uv_span) const;
  /// Alpha of the material's factor, and whether it is cut out at `cutoff`.
  bool cut_out(int material) const { return at(material) && at(material)->alpha_masked; }
  float alpha_factor(int material) const { return at(material) ? at(material)->alpha : 1.0f; }
  float cutoff(int material) const { return at(material) ? at(material)->cutoff : 0.0f; }
  /// Hash of everything that mean_color depends on.
  std::uint64_t content(int material) const { return at(material) ? at(material)->content : 0; }

 private:
  using Chain = std::vector<MipLevel>;
  struct Entry {
    TextureRef reference;
    std::shared_ptr<const Chain> chain;  ///< null without a texture
    bool alpha_masked = false;
    float alpha = 1.0f, cutoff = 0.5f;
    std::uint64_t content = 0;
  };
  static std::shared_ptr<const Chain> make_chain(const TextureImage& image);
  const Entry* at(int material) const {
    return material >= 0 && material < static_cast<int>(entries_.size()) ? &entries_[static_cast<std::size_t>(material)]
                                                                         : nullptr;
  }
  std::vector<Entry> entries_;
};

}  // namespace maquette
