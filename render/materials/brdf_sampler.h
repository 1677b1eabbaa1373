#pragma once

#include "render/materials/brdf_tables.h"
#include "render/materials/merl_shared.h"

namespace maquette::shared {

/// The shader's sampler on the CPU: the functions of shaders/shared/brdf_sampling.glsl as members (sample_brdf,
/// brdf_sample_pdf, theta_cell_mass, ...), reading the cells of `tables`, which must outlive it.
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
