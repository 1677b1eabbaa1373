#pragma once

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "render/shading/shading_mode.h"

namespace maquette {

/// Fills the points between those that were shaded, coarse to fine, by weights over depth, normal and material.
class Upsampling {
 public:
  void fit(const GridSize& size);
  /// `bind_own`: binds what is known of shaded points, which then take part in what is interpolated at them; null: they
  /// stay as they are.
  /// `tiles`: where points are to be filled; coarse levels are filled everywhere. `levels`: that are interpolated.
  void fill(const LayerContext& layer, const Texture& axes, const Texture& marks, const std::function<void()>& bind_own,
            const TileList& tiles, int levels);
  const QuadList& plain_quads() const { return plain_quads_; }
  const QuadList& mixed_quads() const { return mixed_quads_; }
  static std::vector<ShaderVariant> shader_variants();
  std::size_t bytes() const { return weights_.bytes(); }

 private:
  enum class Step {
    once,  ///< weights are computed for this frame alone
    find,  ///< weights are computed for the frames to come
    kept   ///< weights were computed before
  };
  struct Rule {
    bool textures = false, own = false;
    bool cubic = false, tiles = false;  ///< of levels above the finest, of levels within a tile
    Step step = Step::once;
    bool middle = false;  ///< of four points, else between two
  };
  static ShaderVariant variant(const Rule& rule);
  static ShaderVariant quads_variant(bool textures, bool own);
  void fill_levels(const LayerContext& layer, Step step, bool own, const TileList& tiles, int levels) const;
  void list_quads(const LayerContext& layer);

  GridSize size_;
  Texture weights_;                                          ///< RG32UI (shaders/bandwidth/fill.comp)
  std::optional<std::pair<std::uint32_t, int>> weights_of_;  ///< surfaces' revision, levels
  QuadList plain_quads_, mixed_quads_;                       ///< with several points a pixel
  Buffer quad_counts_;
};

}  // namespace maquette
