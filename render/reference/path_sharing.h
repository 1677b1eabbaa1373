#pragma once

#include <span>

#include "render/reference/mirror_guide.h"
#include "render/reference/surface.h"

namespace maquette {

/// The first path segment between two surfaces, along which the paths of a tile share light: each first surface is
/// reconnected to each second surface, as if its own path had gone there. The weights are those of the balance
/// heuristic over all paths that could have found the second surface, so the light between two close surfaces stays
/// bounded. Source: Bekaert, Sbert and Halton 2002, "Accelerating Path Tracing by Re-Using Paths". Differs: only the
/// part of the second surface's BRDF that does not depend on the view is shared, and only along unoccluded lines;
/// panes, mirrors, emitters and the sky stay with their own path.
struct Reconnection {
  /// First surface; null: the path does not share.
  const SurfacePoint* from = nullptr;
  glm::vec3 origin{0.0f};  ///< origin of rays that leave it
  glm::vec3 weight{0.0f};  ///< factor of its radiance in the pixel
  std::uint32_t mirror_cell = 0;
  float mirror_share = 0.0f;  ///< share of scattered rays that the guide of mirrored lamps draws
  /// The path's own ray to the second surface.
  glm::vec3 direction{0.0f};
  float pdf = 0.0f;         ///< 1/sr
  glm::vec3 carried{0.0f};  ///< factor of the radiance that this ray brings
  /// Second surface.
  bool reached = false;  ///< found, and can be shared
  glm::vec3 to{0.0f};
  glm::vec3 normal{0.0f};          ///< geometric, unit, towards the first surface
  glm::vec3 shading_normal{0.0f};  ///< unit
  glm::vec3 end{0.0f};             ///< end point of rays to it
  glm::vec3 light{0.0f};           ///< cd/m2 that it sends in all directions alike, one estimate
};

constexpr std::size_t kMaxReconnections = 8;  ///< in a tile

/// Whether paths with this first surface may share.
bool shares_first(const SurfacePoint& point);
/// Whether this second surface, hit by a ray of unit `direction`, may be shared.
bool shares_second(const SurfacePoint& point, const glm::vec3& direction);
/// Part of a second surface's BRDF that does not depend on the view; nearly all of it for matte surfaces.
glm::vec3 view_independent_brdf(const SurfacePoint& point);

/// The light that a path receives.
struct SharedLight {
  glm::vec3 radiance{0.0f};  ///< cd/m2, weighted
  std::uint32_t rays = 0;
};
/// Distributes the light of all reconnections of one tile: one result for each path. `mirrors`: may be null.
void share_light(const PathScene& scene, const MirrorGuide* mirrors, std::span<const Reconnection> reconnections,
                 std::span<SharedLight> results);

}  // namespace maquette
