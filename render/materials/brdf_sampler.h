#pragma once

#include "render/materials/brdf_tables.h"
#include "render/math/shared_formulas.h"

namespace maquette::shared {

/// The cell that brdf_sample_pdf finds, in three steps of independent comparisons instead of seven dependent ones: the
/// last cell that begins at or before `t`, or the first.
inline int find_theta_cell(const vec2* cells, float t) {
  static_assert(kThetaCellCount == 4 * 24);
  const auto begun = [&](int k) { return cells[k].x <= t ? 1 : 0; };
  int k = 24 * (begun(24) + begun(48) + begun(72));
  k += 6 * (begun(k + 6) + begun(k + 12) + begun(k + 18));
  return k + begun(k + 1) + begun(k + 2) + begun(k + 3) + begun(k + 4) + begun(k + 5);
}
inline int find_phi_cell(const vec2* cells, float phi) {
  static_assert(kPhiCellCount == 16);
  const auto begun = [&](int p) { return cells[p].x <= phi ? 1 : 0; };
  const int p = 4 * (begun(4) + begun(8) + begun(12));
  return p + begun(p + 1) + begun(p + 2) + begun(p + 3);
}

/// The shader's sampler on the CPU: the functions of shaders/shared/brdf_sampling.glsl as members (sample_brdf,
/// brdf_sample_pdf, theta_cell_mass, ...). They read the cells of `tables`, which must outlive it.
struct BrdfSampler {
  explicit BrdfSampler(const BrdfTables& source) : tables(source) {}
  const BrdfTables& tables;

  vec2 fetch_theta_cell(int elevation, int k) const {
    return tables.theta_cells.data()[elevation * kThetaCellCount + k];
  }
  vec2 fetch_phi_cell(int elevation, int k, int p) const {
    return tables.phi_cells.data()[(elevation * kThetaCellCount + k) * kPhiCellCount + p];
  }
#include "shared/brdf_sampling.glsl"
};

}  // namespace maquette::shared
