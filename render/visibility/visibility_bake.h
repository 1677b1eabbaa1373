#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "render/scene_state/geometry.h"

namespace maquette {

inline constexpr int kVisibilitySide = 16;  ///< octahedral map of the world's sphere, 16 x 16 directions, one bit each

/// Directional visibility of the distant environment per vertex of a FlatGeometry: bit b of vertex v is 1 when
/// direction b is unoccluded; bit index = y * 16 + x of the octahedral map (shaders/shared/octahedral.glsl), word = b /
/// 32. Read through shaders/shared/visibility.glsl.
///
/// The map covers the whole sphere, so that a sheet may be seen from both sides: cells above the tangent plane of the
/// vertex normal hold the visibility of the side of +n, the others that of the side of -n (nothing visible inside a
/// closed body).
///
/// Panes do not occlude; their mean transmittance is stored per side.
struct VisibilityBake {
  std::vector<std::array<std::uint32_t, 8>> vertices;
  /// Per vertex: mean transmittance of the open directions, weighted by the cosine, on the side of +n (x) and of -n
  /// (y).
  std::vector<glm::vec2> transmittance;
  /// Per vertex: variation of visibility over the surface, cycles per metre; adds to nu_x. See
  /// compute_visibility_bandwidth.
  std::vector<float> bandwidth;
};

/// Transmittance of an item for a straight ray: `share` times that of a pane of refractive index `ior` (1: no
/// interfaces) and internal transmittance `inside`, the mean over R, G and B.
struct Passage {
  float share = 1.0f, ior = 1.0f, inside = 1.0f;
  bool operator==(const Passage&) const = default;
};

/// Traces with Embree on all cores (TBB). Items of glass or of a blended material do not occlude, but have visibility
/// themselves (for reflections in a pane). Alpha-masked items occlude. `transmits[i]`: item i does not occlude;
/// `passages[i]`: its transmittance (empty: 1). Progress in [0, 1]; returns nullopt once `cancel` is set.
std::optional<VisibilityBake> bake_visibility(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                                              const std::vector<Passage>& passages, const std::atomic<bool>& cancel,
                                              const std::function<void(double)>& progress = {});

}  // namespace maquette
