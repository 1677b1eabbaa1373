#pragma once

#include <cstdint>
#include <optional>

#include "render/environment/environment_buffers.h"

namespace maquette {

/// The environment's list of light samples, which all points of a frame read from.
class LightSamples {
 public:
  /// Before the first frame of a picture: a list of the seed's own. What all samples of a list have in common is no
  /// noise that other seeds tell of.
  void begin_picture(EnvironmentBuffers* environment, std::uint32_t seed) {
    if (seed_ != seed) environment->resample(seed);
    seed_ = seed;
  }
  /// The next picture draws its own, whatever is drawn now.
  void forget() { seed_.reset(); }
  /// Draws them anew, for frame number `frame` of a picture.
  void renew(EnvironmentBuffers* environment, std::uint32_t seed, int frame) {
    environment->resample(seed * 0x9e3779b9u + static_cast<std::uint32_t>(frame));
    seed_.reset();
  }
  /// The same when a point that takes `count` more samples after its first `begin` would come to the list's end.
  void renew_for(EnvironmentBuffers* environment, std::uint32_t seed, int frame, std::int64_t begin,
                 std::int64_t count) {
    constexpr std::int64_t kLength = EnvironmentBuffers::kListLength;
    if (begin > 0 && begin / kLength != (begin + count) / kLength) renew(environment, seed, frame);
  }

 private:
  std::optional<std::uint32_t> seed_ = 0;  ///< whose first samples are drawn; empty: later ones
};

}  // namespace maquette
