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
  /// The eight entries around a coordinate, as sums of one number for each axis: of the lower and the upper corner; and
  /// where it lies between them.
  struct Place {
    std::array<std::int32_t, 2> theta_h{}, theta_d{}, phi_d{};
    glm::vec3 fraction{0.0f};
    /// Upper corners of phi_d come second, of theta_d third and of theta_h last.
    std::int32_t entry(std::size_t corner) const {
      return theta_h[corner / 4] + theta_d[corner / 2 % 2] + phi_d[corner % 2];
    }
  };
  static Place place_of(const shared::MerlCell& cell) {
    return {{of_theta_h(cell.lower.x), of_theta_h(cell.upper.x)},
            {of_theta_d(cell.lower.y), of_theta_d(cell.upper.y)},
            {of_phi_d(cell.lower.z), of_phi_d(cell.upper.z)},
            cell.fraction};
  }
  /// Asks for what look_up reads.
  void prefetch(const Place& place) const;
  /// 1/sr, trilinear.
  glm::vec3 look_up(const Place& place) const;

 private:
  /// Mantissas of red and green, of blue and float's exponent of their unit; the first of each pair in the low half.
  struct Entry {
    std::uint32_t red_green = 0, blue_exponent = 0;
  };
  struct alignas(64) Brick {
    std::array<Entry, 8> entries;
  };
  static Entry pack(const glm::vec3& f);
  static constexpr int kThetaDBricks = kThetaDCount / 2, kPhiDBricks = kPhiDCount / 2;
  // Of an axis: the brick, and the place in it.
  static constexpr int of_theta_h(int i) { return i / 2 * (kThetaDBricks * kPhiDBricks * 8) + i % 2 * 4; }
  static constexpr int of_theta_d(int i) { return i / 2 * (kPhiDBricks * 8) + i % 2 * 2; }
  static constexpr int of_phi_d(int i) { return i / 2 * 8 + i % 2; }
  std::vector<Brick> bricks_;
};

}  // namespace maquette
