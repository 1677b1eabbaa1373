#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/math/shared_formulas.h"
#include "scenes/brdf.h"

namespace maquette {

/// A BrdfTable with eight bytes an entry: three mantissas of 16 bits and a shared exponent. The error of a channel is
/// at most 2^-16 of the entry's largest channel, plus 2^-127 1/sr. Entries are stored in bricks of 2 x 2 x 2 (theta_h,
/// theta_d, phi_d), one cache line each, so that interpolation reads 3.4 lines on average, mostly of one page; rows of
/// floats need 4.8 lines of two to four pages.
class PackedBrdf {
 public:
  PackedBrdf() = default;
  explicit PackedBrdf(const BrdfTable& table);
  /// The eight entries around a coordinate. An entry's index is the sum of one number for each axis, of the lower or
  /// the upper corner. `fraction`: position between the corners.
  struct Cell {
    std::array<std::int32_t, 2> theta_h{}, theta_d{}, phi_d{};
    glm::vec3 fraction{0.0f};
    /// Bit 0 of `corner`: the upper corner along phi_d, bit 1: along theta_d, bit 2: along theta_h.
    std::int32_t entry(std::size_t corner) const {
      return theta_h[corner / 4] + theta_d[corner / 2 % 2] + phi_d[corner % 2];
    }
  };
  static Cell cell_of(const shared::MerlCell& cell) {
    return {{of_theta_h(cell.lower.x), of_theta_h(cell.upper.x)},
            {of_theta_d(cell.lower.y), of_theta_d(cell.upper.y)},
            {of_phi_d(cell.lower.z), of_phi_d(cell.upper.z)},
            cell.fraction};
  }
  /// Prefetches what look_up reads.
  void prefetch(const Cell& cell) const;
  /// 1/sr, trilinear.
  glm::vec3 look_up(const Cell& cell) const;

 private:
  /// Mantissas of red and green; mantissa of blue and the exponent (as a float has it) of their unit. The first of each
  /// pair is in the low half.
  struct Entry {
    std::uint32_t red_green = 0, blue_exponent = 0;
  };
  struct alignas(64) Brick {
    std::array<Entry, 8> entries;
  };
  static Entry pack(const glm::vec3& f);
  static constexpr int kThetaDBricks = kThetaDCount / 2, kPhiDBricks = kPhiDCount / 2;
  // Contribution of an axis to an entry's index: the brick, and the entry within the brick.
  static constexpr int of_theta_h(int i) { return i / 2 * (kThetaDBricks * kPhiDBricks * 8) + i % 2 * 4; }
  static constexpr int of_theta_d(int i) { return i / 2 * (kPhiDBricks * 8) + i % 2 * 2; }
  static constexpr int of_phi_d(int i) { return i / 2 * 8 + i % 2; }
  std::vector<Brick> bricks_;
};

}  // namespace maquette
