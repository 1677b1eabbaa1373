#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "render/reference/packed_brdf.h"

namespace maquette {

/// Where pairs of directions lie in measured tables, several side by side: each is a chain of roots, quotients and arc
/// tangents that wait for each other, and one chain takes as long as eight.
struct BrdfLanes {
  static constexpr std::size_t kCount = 8;
  template <typename T>
  using Lanes = std::array<T, kCount>;

  /// Local, unit.
  struct alignas(32) Directions {
    Lanes<float> x{}, y{}, z{};
    void set(std::size_t lane, const glm::vec3& d) {
      x[lane] = d.x;
      y[lane] = d.y;
      z[lane] = d.z;
    }
  };
  Directions wi, wo;

  struct alignas(32) Places {
    /// PackedBrdf::place_of(merl_cell(merl_coordinates(wi, wo))).
    std::array<Lanes<std::int32_t>, 2> theta_h, theta_d, phi_d;
    std::array<Lanes<float>, 3> fraction;
    /// half_vector_place(wo, wi), brdf_elevation(wo) (shared/brdf_sampling.glsl).
    Lanes<float> t, phi, length_sum;
    Lanes<std::int32_t> elevation;
  };
  Places places;

  /// Fills `places`.
  void compute();
  PackedBrdf::Place place(std::size_t lane) const {
    const Places& p = places;
    return {{p.theta_h[0][lane], p.theta_h[1][lane]},
            {p.theta_d[0][lane], p.theta_d[1][lane]},
            {p.phi_d[0][lane], p.phi_d[1][lane]},
            {p.fraction[0][lane], p.fraction[1][lane], p.fraction[2][lane]}};
  }
};

}  // namespace maquette
