#include "render/reference/path_sharing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/reference/scattering.h"

namespace maquette {

namespace {

/// Least weight of the diffuse lobe of a first surface that shares: glossier ones reflect other directions than their
/// neighbours.
constexpr float kLeastDiffuse = 0.2f;
/// Above this cosine (with its rounding) face_viewer leaves the shading normal as it is.
constexpr float kLeastFacing = 0.005f;

Ray ray_between(const Reconnection& first, const Reconnection& second) {
  return {first.origin, second.end - first.origin, 0.0f, 1.0f};
}

/// Connection of a first surface with a second one, as a density over the second's area.
struct Connection {
  glm::vec3 throughput{0.0f};  ///< 1/m2, factor of the second surface's light
  float density = 0.0f;        ///< 1/m2, with which the first surface's path finds the second; 0: it cannot
};

/// `own`: connects a path with its own second surface. Zero wherever FullPath::extend would have ended the path.
Connection connect(const Reconnection& first, const Reconnection& second, const MirrorGuide* mirrors, bool own) {
  const glm::vec3 way = second.to - first.origin;
  const float square = glm::dot(way, way);
  const glm::vec3 direction = own ? second.direction : way / std::sqrt(square);
  Connection c;
  const SurfacePoint& p = *first.from;
  const float arriving = -glm::dot(direction, second.normal);
  if (!(square > 0.0f && arriving > 0.0f && -glm::dot(direction, second.shading_normal) > kLeastFacing)) return c;
  const glm::vec3 wi = p.to_local(direction);
  if (glm::dot(direction, p.normal) <= 0.0f || wi.z <= 0.0f) return c;
  const Scattering s = evaluate_scattering(p, wi);
  c.throughput = first.weight * s.f * (wi.z * arriving / square);
  if (!(largest(c.throughput) > 0.0f)) return c;
  const float pdf = own       ? second.pdf
                    : mirrors ? mirrors->mixed_pdf(s.pdf, first.mirror_cell, first.mirror_share, direction)
                              : s.pdf;
  c.density = pdf * arriving / square;
  return c;
}

}  // namespace

bool shares_first(const SurfacePoint& p) { return p.material->measured || p.lobe_weights.x >= kLeastDiffuse; }

bool shares_second(const SurfacePoint& p, const glm::vec3& direction) {
  const TracedMaterial& m = *p.material;
  if (m.pane > 0.0f || m.blended || m.values.unlit || p.normal_adjusted) return false;
  return -glm::dot(direction, p.n) > kLeastFacing && largest(view_independent_brdf(p)) > 0.0f;
}

glm::vec3 view_independent_brdf(const SurfacePoint& p) {
  if (p.material->tabulated()) return glm::vec3(0.0f);
  // As evaluate_analytic with a Fresnel weight of 0.
  const shared::AnalyticMaterial& m = p.analytic;
  return m.diffuse * (shared::kInvPi * std::max(1.0f - largest(m.f0), 0.0f) * (1.0f - 0.04f * m.coat));
}

void share_light(const PathScene& scene, const MirrorGuide* mirrors, std::span<const Reconnection> reconnections,
                 std::span<SharedLight> results) {
  // A path may have passed blended surfaces at random.
  const bool has_alpha = scene.mesh_begin[PathScene::kAlpha] != scene.mesh_begin[PathScene::kHidden];
  std::array<Connection, kMaxReconnections> connections;
  for (std::size_t j = 0; j < reconnections.size(); ++j) {
    const Reconnection& second = reconnections[j];
    if (!second.reached || second.light == glm::vec3(0.0f)) continue;
    float density = 0.0f;
    results[j].rays += has_alpha ? 1 : 0;
    if (is_finite(second.light) && (!has_alpha || is_unoccluded(scene, ray_between(second, second)))) {
      for (std::size_t i = 0; i < reconnections.size(); ++i) {
        connections[i] = reconnections[i].from ? connect(reconnections[i], second, mirrors, i == j) : Connection();
        if (i != j && connections[i].density > 0.0f) {
          ++results[i].rays;
          if (!is_unoccluded(scene, ray_between(reconnections[i], second))) connections[i] = {};
        }
        density += connections[i].density;
      }
    }
    if (!(connections[j].density > 0.0f && density > 0.0f && std::isfinite(density))) {
      results[j].radiance += second.carried * second.light;
      continue;
    }
    for (std::size_t i = 0; i < reconnections.size(); ++i)
      if (connections[i].density > 0.0f) results[i].radiance += connections[i].throughput * second.light / density;
  }
}

}  // namespace maquette
