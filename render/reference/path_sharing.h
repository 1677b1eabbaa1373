#pragma once

#include <span>

#include "render/reference/mirror_guide.h"
#include "render/reference/surface.h"

namespace maquette {

/// The first step of a path from surface to surface, along which the paths of a tile share light: each first surface
/// is connected with each second one, as if its own path had gone there. Weights are the balance heuristic's over all
/// the paths that could have found the second surface, so what two surfaces close by exchange stays bounded.
/// Source: Bekaert, Sbert and Halton 2002, "Accelerating Path Tracing by Re-Using Paths". Differs: only the part of
/// the second surface's BRDF that is the same towards all first surfaces is shared, and only along clear lines;
/// panes, mirrors, emitters and the sky stay with their own path.
struct PathLink {
  /// First surface; null: takes no part.
  const SurfacePoint* from = nullptr;
  glm::vec3 origin{0.0f};  ///< of rays that leave there
  glm::vec3 weight{0.0f};  ///< what its radiance counts
  std::uint32_t mirror_cell = 0;
  float mirror_share = 0.0f;  ///< of scattered rays that the guide of mirrored lamps draws
  /// The ray that went on.
  glm::vec3 direction{0.0f};
  float pdf = 0.0f;         ///< 1/sr
  glm::vec3 carried{0.0f};  ///< what radiance counts that this ray brings
  /// Second surface.
  bool reached = false;  ///< and can be shared
  glm::vec3 to{0.0f};
  glm::vec3 normal{0.0f};          ///< geometric, unit, towards the first surface
  glm::vec3 shading_normal{0.0f};  ///< unit
  glm::vec3 end{0.0f};             ///< of rays that arrive there
  glm::vec3 light{0.0f};           ///< cd/m2 that it sends to all alike, one estimate
};

constexpr std::size_t kMostLinks = 8;  ///< of a tile

/// Whether paths that scatter at a first surface like this may share.
bool shares_first(const SurfacePoint& point);
/// Whether what a ray of unit `direction` met as second surface may be shared.
bool shares_second(const SurfacePoint& point, const glm::vec3& direction);
/// Part of a second surface's BRDF that does not depend on the view; near all of it where it is matt.
glm::vec3 steady_brdf(const SurfacePoint& point);

/// What a path gets.
struct SharedLight {
  glm::vec3 radiance{0.0f};  ///< cd/m2, weighted
  std::uint32_t rays = 0;    ///< that were traced for it
};
/// Shares the light of the links of one tile's paths out: one result for each. `mirrors`: may be null.
void share_links(const PathScene& scene, const MirrorGuide* mirrors, std::span<const PathLink> links,
                 std::span<SharedLight> results);

}  // namespace maquette
