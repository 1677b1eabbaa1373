#pragma once

#include <cstdint>
#include <optional>

#include "render/gl/objects.h"
#include "render/renderer.h"

namespace maquette {

/// The light that the frame before stood in, mode `bandwidth`, and all else that a point's radiance depends on.
struct DrawnLight {
  struct Key {
    FrameRequest request;     ///< rotation 0
    std::uint32_t epoch = 0;  ///< of everything but indirect light
    std::string visibility;
    bool lights = false;
    bool operator==(const Key&) const = default;
  };
  Key key;
  float rotation_rad = 0.0f;
  bool scheduled = false;  ///< its points may go on
};

/// What mode `bandwidth` keeps of each grid point from frame to frame while only the light turns (shaders/turning).
struct TurnHistory {
  Texture mean;               ///< RGBA32F: mean without clamping, and the samples that it is worth
  Texture renewed;            ///< R32UI: number of the frame that last renewed the point
  Texture sun;                ///< RGBA32F: the sun's light at the frame's points, which is not carried on
  Buffer counters;            ///< TurnCounters of shaders/turning/item.glsl
  std::uint32_t frame = 1;    ///< number of the frame at hand, from 2
  float sample_scale = 1.0f;  ///< of wanted samples, for the frame to come

  static TurnHistory make(int grid_width, int grid_height);
  std::size_t bytes() const { return mean.bytes() + renewed.bytes() + sun.bytes(); }
};

/// Base count of samples, and density of points along an axis, of a frame that goes on, over those of one from nothing.
/// What stands still for an instant only is worth less.
constexpr float kTurningSamples = 0.5f, kTurningDensity = 0.65f;
/// The same density where masks shadow: their cells' edges move over the surfaces as the light turns.
constexpr float kTurningMaskedDensity = 1.0f;

/// How the frame at hand goes on from the one before.
struct Turn {
  float angle_rad = 0.0f;  ///< of the light since the frame before, in (-pi, pi]; 0: everything is drawn anew
  std::uint32_t frame = 2;
  bool begins = false;  ///< the frame before stood still: surfaces are known, but no point has a past
  bool goes_on() const { return angle_rad != 0.0f; }
};

/// What a sample that looks back costs in samples under one sky: it sees two, in items so short that beginning them
/// counts.
constexpr float kLookingBack = 3.5f;
/// What the points of a frame may cost on average, over the base count, and over what going on costs: about half of
/// what it takes to begin anew.
constexpr float kTurningBudget = 1.5f, kGoingOnBudget = 1.25f;
constexpr float kLeastSampleScale = 0.25f;

/// Counts of a frame's lists.
struct TurnCost {
  double points = 0.0, samples = 0.0;
  double looking_back = 0.0;  ///< of the samples
};
/// Scale of wanted samples at which lists as these, made with `scale`, are worth their budget. `fewest`: samples of a
/// point that goes on.
float budgeted_scale(float scale, const TurnCost& cost, int base_count, int fewest);

}  // namespace maquette
