#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/materials/merl_shared.h"
#include "scenes/brdf.h"

namespace maquette {

/// A BrdfTable in words with a shared exponent (shared/rgb9e5.glsl, bias by the table's largest value): an entry's
/// channels err by at most 1 / 512 of its largest one, down to 2^-31 of the table's largest; below, by 2^-39 of that.
/// Entries lie in bricks of 2 x 2 x 4 (theta_h, theta_d, phi_d), one line of memory each, so that interpolation reads
/// 2.8 lines in the mean, mostly of one page, where rows of floats are 4.8 lines of two to four pages.
class PackedBrdf {
 public:
  PackedBrdf() = default;
  explicit PackedBrdf(const BrdfTable& table);
  /// Asks for what look_up reads.
  void prefetch(const shared::MerlCell& cell) const;
  /// 1/sr, trilinear.
  glm::vec3 look_up(const shared::MerlCell& cell) const;

 private:
  struct alignas(64) Brick {
    std::array<std::uint32_t, 16> words;
  };
  std::array<const std::uint32_t*, 8> corners_of(const shared::MerlCell& cell) const;
  std::vector<Brick> bricks_;
  int bias_ = 0;
};

}  // namespace maquette
