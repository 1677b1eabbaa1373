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

/// A direction above the horizon whose entries of a measured table are on their way from memory.
struct BrdfQuery {
  glm::vec3 wi{0.0f};
  PackedBrdf::Place place{};
};
BrdfQuery prepare_brdf(const SurfacePoint& point, const glm::vec3& wi);
glm::vec3 evaluate_brdf(const SurfacePoint& point, const BrdfQuery& query);
/// With what the density reads.
struct ScatteringQuery : BrdfQuery {
  shared::BrdfSampler::HalfVectorPlace half{};
  int theta_cell = 0;
  const glm::vec2 *theta = nullptr, *phis = nullptr;  ///< borders of the cell, and of the phi cells in it
};
ScatteringQuery prepare_scattering(const SurfacePoint& point, const glm::vec3& wi);
Scattering evaluate_scattering(const SurfacePoint& point, const ScatteringQuery& query);

/// Prepares many queries, of any points, side by side: what prepare_brdf and prepare_scattering make of them.
class QueryBatch {
 public:
  /// Queries whose wi is set; they and the points have to last until the batch is complete.
  void add(const SurfacePoint& point, BrdfQuery* query) { add(point, query, nullptr); }
  void add(const SurfacePoint& point, ScatteringQuery* query) { add(point, query, query); }
  void complete();

 private:
  struct Waiting {
    const MeasuredMaterial* measured;
    BrdfQuery* query;
    ScatteringQuery* density;  ///< null: of the BRDF alone
  };
  void add(const SurfacePoint& point, BrdfQuery* query, ScatteringQuery* density);

  std::array<Waiting, BrdfLanes::kCount> waiting_{};
  std::size_t count_ = 0;
  BrdfLanes lanes_;
};
/// The density alone.
float scattering_pdf(const SurfacePoint& point, const glm::vec3& wi);
/// What two numbers in [0, 1) mean at a point, with what drawing and densities there read on its way from memory.
struct ScatteringChoice {
  glm::vec2 u{0.0f};
  shared::BrdfSampler::BrdfCellChoice cell{};
  glm::vec2 const *theta_cell = nullptr, *phi_cell = nullptr;  ///< of a measured table
};
ScatteringChoice choose_scattering(const SurfacePoint& point, const glm::vec2& u);

/// Which lobe of an analytic material u in [0, 1) picks (shared/analytic.glsl), and u stretched over that lobe's share,
/// in [0, 1): one number for the lobe and a place in it, so that points that are spread well in the square are so in
/// every lobe.
struct LobeChoice {
  int lobe = 0;
  float within = 0.0f;
};
LobeChoice choose_lobe(const glm::vec3& weights, float u);

struct DrawnDirection {
  glm::vec3 wi{0.0f};
  float pdf = 0.0f;  ///< 0: worth nothing, but it counts
};
DrawnDirection draw_scattering(const SurfacePoint& point, const ScatteringChoice& choice);
/// All at once, with the BRDF.
struct ScatteringSample {
  glm::vec3 wi{0.0f};
  glm::vec3 f{0.0f};
  float pdf = 0.0f;
};
ScatteringSample sample_scattering(const SurfacePoint& point, const glm::vec2& u);

}  // namespace maquette
