#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/materials/merl_shared.h"
#include "scenes/brdf.h"

namespace maquette {

/// A BrdfTable in eight bytes an entry, three mantissas of 16 bits and their exponent: channels err by at most 2^-16 of
/// the entry's largest one, and by 2^-127 of 1/sr. Entries lie in bricks of 2 x 2 x 2 (theta_h, theta_d, phi_d), one
/// line of memory each, so that interpolation reads 3.4 lines in the mean, mostly of one page, where rows of floats are
/// 4.8 lines of two to four pages.
class PackedBrdf {
 public:
  PackedBrdf() = default;
  explicit PackedBrdf(const BrdfTable& table);
  /// Asks for what look_up reads.
  void prefetch(const shared::MerlCell& cell) const;
  /// 1/sr, trilinear.
  glm::vec3 look_up(const shared::MerlCell& cell) const;

 private:
  /// Mantissas of red and green, of blue and float's exponent of their unit; the first of each pair in the low half.
  struct Entry {
    std::uint32_t red_green = 0, blue_exponent = 0;
  };
  struct alignas(64) Brick {
    std::array<Entry, 8> entries;
  };
  static Entry pack(const glm::vec3& f);
  std::array<const Entry*, 8> corners_of(const shared::MerlCell& cell) const;
  std::vector<Brick> bricks_;
};

}  // namespace maquette
