#pragma once

#include <array>

#include "render/reference/brdf_lanes.h"
#include "render/reference/surface.h"

namespace maquette {

/// BRDF (1/sr) and the density (1/sr) with which sample_scattering gives wi. Both directions local, above the horizon.
struct Scattering {
  glm::vec3 f{0.0f};
  float pdf = 0.0f;
};
Scattering evaluate_scattering(const SurfacePoint& point, const glm::vec3& wi);

/// A direction above the horizon, with the entries of a measured table prefetched.
struct BrdfQuery {
  glm::vec3 wi{0.0f};
  PackedBrdf::Cell cell{};
};
BrdfQuery prepare_brdf(const SurfacePoint& point, const glm::vec3& wi);
glm::vec3 evaluate_brdf(const SurfacePoint& point, const BrdfQuery& query);
/// With the data for the density.
struct ScatteringQuery : BrdfQuery {
  shared::BrdfSampler::HalfVectorPosition half{};
  int theta_cell = 0;
  const glm::vec2 *theta = nullptr, *phis = nullptr;  ///< bounds of the theta cell, and of the phi cells in it
};
ScatteringQuery prepare_scattering(const SurfacePoint& point, const glm::vec3& wi);
Scattering evaluate_scattering(const SurfacePoint& point, const ScatteringQuery& query);

/// Prepares many queries, of any points, in SIMD lanes: the same result as prepare_brdf and prepare_scattering.
class QueryBatch {
 public:
  /// Adds a query whose wi is set. Queries and points have to live until the batch is complete.
  void add(const SurfacePoint& point, BrdfQuery* query) { add(point, query, nullptr); }
  void add(const SurfacePoint& point, ScatteringQuery* query) { add(point, query, query); }
  void complete();

 private:
  struct Waiting {
    const MeasuredMaterial* measured;
    BrdfQuery* query;
    ScatteringQuery* density;  ///< null: the BRDF only
  };
  void add(const SurfacePoint& point, BrdfQuery* query, ScatteringQuery* density);

  std::array<Waiting, BrdfLanes::kCount> waiting_{};
  std::size_t count_ = 0;
  BrdfLanes lanes_;
};
/// The density only.
float scattering_pdf(const SurfacePoint& point, const glm::vec3& wi);
/// The cells of a measured table that two numbers in [0, 1) select, prefetched for sampling.
struct ScatteringChoice {
  glm::vec2 u{0.0f};
  shared::BrdfSampler::BrdfCellChoice cell{};
  glm::vec2 const *theta_cell = nullptr, *phi_cell = nullptr;
};
ScatteringChoice choose_scattering(const SurfacePoint& point, const glm::vec2& u);

/// Selects a lobe of an analytic material by u in [0, 1) (shared/analytic.glsl). `within` is u rescaled to [0, 1) over
/// that lobe's share: one number selects the lobe and samples it, so that points that are well distributed in the
/// square are so in every lobe.
struct LobeChoice {
  int lobe = 0;
  float within = 0.0f;
};
LobeChoice choose_lobe(const glm::vec3& weights, float u);

struct DrawnDirection {
  glm::vec3 wi{0.0f};
  float pdf = 0.0f;  ///< 0: contributes nothing, but counts as a sample
};
DrawnDirection draw_scattering(const SurfacePoint& point, const ScatteringChoice& choice);
/// Direction and BRDF in one step.
struct ScatteringSample {
  glm::vec3 wi{0.0f};
  glm::vec3 f{0.0f};
  float pdf = 0.0f;
};
ScatteringSample sample_scattering(const SurfacePoint& point, const glm::vec2& u);

}  // namespace maquette
