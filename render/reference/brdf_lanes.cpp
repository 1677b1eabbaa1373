#include "render/reference/brdf_lanes.h"

#include "render/materials/brdf_sampler.h"
#include "render/math/wide.h"

namespace maquette {

MAQUETTE_WIDE void BrdfLanes::compute() {
  static const BrdfTables kNoTables;
  shared::BrdfSampler sampler(kNoTables);  // only its formulas are used
  Coordinates out;  // local, so that the compiler knows that the loop does not write to what it reads
  for (std::size_t i = 0; i < kCount; ++i) {
    const glm::vec3 in(wi.x[i], wi.y[i], wi.z[i]), view(wo.x[i], wo.y[i], wo.z[i]);
    const PackedBrdf::Cell cell = PackedBrdf::cell_of(shared::merl_cell(shared::merl_coordinates(in, view)));
    for (std::size_t k = 0; k < 2; ++k) {
      out.theta_h[k][i] = cell.theta_h[k];
      out.theta_d[k][i] = cell.theta_d[k];
      out.phi_d[k][i] = cell.phi_d[k];
    }
    out.fraction[0][i] = cell.fraction.x;
    out.fraction[1][i] = cell.fraction.y;
    out.fraction[2][i] = cell.fraction.z;
    const auto half = sampler.half_vector_position(view, in);
    out.t[i] = half.t;
    out.phi[i] = half.phi;
    out.length_sum[i] = half.length_sum;
    out.elevation[i] = sampler.brdf_elevation(view);
  }
  coordinates = out;
}

}  // namespace maquette
