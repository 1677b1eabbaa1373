#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/shading/sampled_shading.h"

namespace maquette {

/// Base count of samples, and density of points along an axis, of a frame that reuses points, over those of one from
/// nothing. What stands still for an instant only is worth less.
constexpr float kReuseSamples = 0.5f, kReuseDensity = 0.65f;
/// The same density where baked visibility shadows: its cells' edges move over the surfaces as the light rotates.
constexpr float kReuseShadowedDensity = 1.0f;

/// What a sample that looks back costs in samples under one sky: it sees two, in items so short that beginning them
/// counts.
constexpr float kLookingBack = 3.5f;
/// What the points of a frame may cost on average, over the base count, and over what reuse costs: about half of what
/// it takes to begin anew.
constexpr float kReuseBudget = 1.5f, kLookingBackBudget = 1.25f;
constexpr float kLeastSampleScale = 0.25f;

/// Counts of a frame's lists.
struct ReuseCost {
  double points = 0.0, samples = 0.0;
  double looking_back = 0.0;  ///< of the samples
};
/// Scale of wanted samples at which lists as these, made with `scale`, are worth their budget. `fewest`: samples of a
/// point that is reused.
float budgeted_scale(float scale, const ReuseCost& cost, int base_count, int fewest);

/// How the light of this frame differs from that of the frame before, when only its rotation has changed.
struct LightRotation {
  float angle_rad = 0.0f;  ///< since the frame before, in (-pi, pi]; 0: everything is drawn anew
  std::uint32_t frame = 2;
  bool begins = false;  ///< the frame before stood still: surfaces are known, but no point has a history
  explicit operator bool() const { return angle_rad != 0.0f; }
};
/// The tiles whose prediction and marks are renewed in this frame.
TileShare renewed_share(const LightRotation& rotation);

/// What mode `bandwidth` keeps of each grid point while only the environment rotates, and how it shades then: every
/// point's mean is corrected by what its samples changed (shaders/rotation).
class TemporalReuse {
 public:
  /// What this frame can reuse. `points`: all that points depend on besides the request and measured tables' swaps.
  LightRotation begin(const FrameStart& start, const Key& points, const GridSize& size);
  /// Nothing is kept.
  void clear();
  bool has_history() const { return history_.has_value(); }

  void shade(const LayerContext& layer, const LightRotation& rotation, const Texture& axes, SampledShading* sampled);

  std::size_t reused_points() const { return reused_points_; }
  std::size_t bytes() const { return history_ ? history_->bytes() : 0; }
  static std::vector<ShaderVariant> shader_variants();

 private:
  struct History {
    Texture mean;               ///< RGBA32F: mean without clamping, and the samples that it is worth
    Texture renewed;            ///< R32UI: number of the frame that last renewed the point
    Texture sun;                ///< RGBA32F: the sun's light at the frame's points, which is not carried on
    Buffer counters;            ///< Counters of shaders/rotation/item.glsl
    std::uint32_t frame = 1;    ///< number of the frame at hand, from 2
    float sample_scale = 1.0f;  ///< of wanted samples, for the frame to come

    History(int grid_width, int grid_height);
    std::size_t bytes() const { return mean.bytes() + renewed.bytes() + sun.bytes(); }
  };
  /// The light of the frame before, and all else that its points depended on.
  struct DrawnLight {
    FrameRequest request;  ///< with rotation 0
    Key points;
    float rotation_rad = 0.0f;
    bool reused = false;  ///< its points may be reused
  };
  /// Of one band.
  struct Band {
    const LayerContext& layer;
    const LightRotation& rotation;
    const Texture& axes;
    SampledShading& sampled;
    std::size_t number = 0;
    unsigned counters[16] = {};
  };
  void schedule(Band* band);
  void shade_band(Band* band);
  void shade_round(Band* band, int round, const unsigned large_items[2], const unsigned small_items[2]);
  /// Items `first` to `first + count` of a list of `schedule`.
  void shade_items(const Band& band, int list, bool reuses_history, unsigned first, unsigned count);
  /// The sun's light at the points of a list, where the environment has one.
  void shade_sun(const Band& band, int list, unsigned points);

  std::optional<History> history_;
  std::optional<DrawnLight> drawn_;
  float sample_scale_ = 1.0f;  ///< of the lists at hand
  std::size_t reused_points_ = 0;
};

}  // namespace maquette
