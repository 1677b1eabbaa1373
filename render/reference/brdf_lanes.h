#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "render/reference/packed_brdf.h"

namespace maquette {

/// Coordinates of several pairs of directions in measured tables, computed in SIMD lanes. Each is a chain of dependent
/// roots, divisions and arc tangents, so eight chains side by side take as long as one.
struct BrdfLanes {
  static constexpr std::size_t kCount = 8;
  template <typename T>
  using Lanes = std::array<T, kCount>;

  /// Local frame, unit length.
  struct alignas(32) Directions {
    Lanes<float> x{}, y{}, z{};
    void set(std::size_t lane, const glm::vec3& d) {
      x[lane] = d.x;
      y[lane] = d.y;
      z[lane] = d.z;
    }
  };
  Directions wi, wo;

  struct alignas(32) Coordinates {
    /// PackedBrdf::cell_of(merl_cell(merl_coordinates(wi, wo))).
    std::array<Lanes<std::int32_t>, 2> theta_h, theta_d, phi_d;
    std::array<Lanes<float>, 3> fraction;
    /// half_vector_position(wo, wi), brdf_elevation(wo) (shared/brdf_sampling.glsl).
    Lanes<float> t, phi, length_sum;
    Lanes<std::int32_t> elevation;
  };
  Coordinates coordinates;

  /// Fills `coordinates`.
  void compute();
  PackedBrdf::Cell cell(std::size_t lane) const {
    const Coordinates& p = coordinates;
    return {{p.theta_h[0][lane], p.theta_h[1][lane]},
            {p.theta_d[0][lane], p.theta_d[1][lane]},
            {p.phi_d[0][lane], p.phi_d[1][lane]},
            {p.fraction[0][lane], p.fraction[1][lane], p.fraction[2][lane]}};
  }
};

}  // namespace maquette
