#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "render/geometry.h"

namespace maquette {

inline constexpr int kVisibilitySide = 16;  ///< octahedral map of the world's sphere, 16 x 16 directions, one bit each

/// Directional visibility of the distant environment per vertex of a FlatGeometry: bit b of vertex v is 1 when
/// direction b is unoccluded; bit index = y * 16 + x of the octahedral map (shaders/shared/octahedral.glsl),
/// word = b / 32. Read through shaders/shared/visibility.glsl.
///
/// The map covers the whole sphere, so that a sheet may be seen from both sides: cells above the tangent plane of the
/// vertex normal hold what the side of +n sees, the others what the side of -n sees (nothing, inside a closed body).
///
/// Panes do not occlude; what of the light they let through is kept as one mean per side.
struct VisibilityBake {
  std::vector<std::array<std::uint32_t, 8>> vertices;
  /// Per vertex: mean transmittance of what is open, weighted by the cosine, on the side of +n (x) and of -n (y).
  std::vector<glm::vec2> transmittance;
  /// Per vertex: variation of visibility over the surface, cycles per metre; adds to nu_x. See
  /// compute_visibility_bandwidth.
  std::vector<float> bandwidth;
};

/// What an item lets through of a straight ray: `share` times the transmittance of a pane of refractive index `ior`
/// (1: no faces) and internal transmittance `inside`, the mean over R, G and B.
struct Passage {
  float share = 1.0f, ior = 1.0f, inside = 1.0f;
  bool operator==(const Passage&) const = default;
};

/// Rays by Embree on all cores (TBB). Items whose material is glass or blended do not occlude; they see (what mirrors
/// in a pane). Alpha-masked ones occlude. `transmits[i]` says so for item i, `passages[i]` how much passes (empty:
/// all). Progress in [0, 1]; returns nullopt once `cancel` is set.
std::optional<VisibilityBake> bake_visibility(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                                              const std::vector<Passage>& passages, const std::atomic<bool>& cancel,
                                              const std::function<void(double)>& progress = {});

}  // namespace maquette
