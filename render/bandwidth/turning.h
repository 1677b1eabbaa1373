#pragma once

#include <cstdint>
#include <optional>

#include "render/gl/objects.h"
#include "render/renderer.h"

namespace maquette {

/// What mode `bandwidth` keeps of each grid point from frame to frame while only the light turns (shaders/turning).
struct TurnHistory {
  /// All that a point's radiance depends on but the light's rotation.
  struct Key {
    FrameRequest request;     ///< rotation 0
    std::uint32_t epoch = 0;  ///< of everything but indirect light
    std::string visibility;
    bool lights = false;
    bool operator==(const Key&) const = default;
  };
  Texture mean;     ///< RGBA32F: mean without clamping, and the samples that it is worth
  Texture renewed;  ///< R32UI: number of the frame that last renewed the point
  Texture sun;      ///< RGBA32F: the sun's light at the frame's points, which is not carried on
  Buffer counters;  ///< TurnCounters of shaders/turning/item.glsl
  std::optional<Key> key;
  float rotation_rad = 0.0f;
  std::uint32_t frame = 1;  ///< number of the frame at hand, from 2

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
  bool goes_on() const { return angle_rad != 0.0f; }
};

}  // namespace maquette
