#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "render/scene_state/geometry.h"

namespace maquette {

/// One item of the geometry that gets texels.
struct AtlasPart {
  std::size_t item = 0;
  bool both_sides = false;  ///< its back is seen too, and has texels of its own
};

struct AtlasOptions {
  int side = 256;             ///< texels; the density follows
  double texels_per_m = 0.0;  ///< above 0: the density, and the side follows
};
inline constexpr int kLargestAtlas = 8192;

/// One side of a triangle in the atlas.
struct AtlasSide {
  std::uint32_t triangle = 0;
  bool back = false;
  std::uint32_t chart = 0;
  std::array<glm::vec2, 3> at{};  ///< of its corners, in texels; texel (x, y) has its centre at (x + 0.5, y + 0.5)
  /// Of its corners, in the order that barycentrics count in: a PathScene turns the corners of triangles round.
  std::array<std::uint32_t, 3> vertices{};
};

struct AtlasTexel {
  std::uint32_t side = 0;  ///< index in LightFieldAtlas::sides
  glm::vec2 barycentric{0.0f};
  std::uint16_t x = 0, y = 0;
};

/// A square of texels over surfaces, cut into charts: a bilinear read anywhere on a side of the atlas touches texels of
/// its own chart only. Values; no OpenGL.
struct LightFieldAtlas {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  int side = 0;
  double texels_per_m = 0.0;
  std::vector<AtlasSide> sides;
  /// [chart] direction in which its local frames are rooted (shaders/shared/parabolic.glsl, carried_frame): its mean
  /// normal, unit.
  std::vector<glm::vec3> axes;
  std::vector<AtlasTexel> texels;  ///< whose centres lie on a surface; a chart has at least one
  /// [y * side + x] index in `texels` of what is read there: its own, or in gutters the nearest of the chart; kNone
  /// where no chart is.
  std::vector<std::uint32_t> texel_of_cell;
  /// Parts whose second UV set is not used, by item, and why.
  std::vector<std::pair<std::size_t, std::string>> own_charts;
};

inline constexpr const char* kNoSecondUvs = "there is none";
/// Why a part's second UV set cannot be used, or an empty text: there is none (kNoSecondUvs), it is not finite, out of
/// range, without area, or overlaps itself.
std::string check_second_uvs(const FlatGeometry& geometry, std::size_t item);

/// Makes the atlas: of the second UV set of each part where it is valid, else of charts made here (cones of normals,
/// projected to a plane), packed by skyline. Triangles without area or with corners that are not finite get no side.
/// Throws Error where the charts do not fit. Deterministic. Cost: about a second for a million triangles.
LightFieldAtlas make_atlas(const FlatGeometry& geometry, const std::vector<AtlasPart>& parts,
                           const AtlasOptions& options);

/// Replaces what is read at `masked` texels (surfaces inside other bodies) and in their gutters by the nearest texel
/// of the same chart that is not; charts without one keep theirs. [texel]
void fill_masked_texels(const std::vector<bool>& masked, LightFieldAtlas* atlas);

}  // namespace maquette
