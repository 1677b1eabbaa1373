#pragma once

#include <optional>
#include <vector>

#include "render/frame/context.h"
#include "render/indirect/indirect_buffers.h"

namespace maquette {

/// Indirect light at every point of a layer, kept until it changes: of one bake, or of two that the light rotates
/// between.
class IndirectPass {
 public:
  /// Computes it anew where it has changed: everywhere, or, where only measured tables were swapped, in `changed` tiles
  /// (null: everywhere).
  void run(const LayerContext& layer, const TileList* changed);
  /// True when run() would compute nothing.
  bool is_current(const LayerContext& layer) const;
  /// Binds the light of each bake for composing; their count.
  std::size_t bind(const FrameContext& frame) const;
  std::size_t bytes() const { return light_[0].bytes() + light_[1].bytes(); }
  static std::vector<ShaderVariant> shader_variants();

 private:
  struct Drawn {
    Key points;                ///< all that it depends on besides measured tables
    std::uint32_t tables = 0;  ///< revision
    std::uint32_t serial = 0;  ///< of the bake
    bool operator==(const Drawn&) const = default;
  };
  static Drawn drawn_of(const LayerContext& layer, const IndirectKey& key);

  Texture light_[2];  ///< RGBA32F, cd/m2, of the bakes with even and odd numbers
  std::optional<Drawn> drawn_[2];
};

}  // namespace maquette
