#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/frame/context.h"
#include "render/gbuffer/tiles.h"

namespace maquette {

struct PathScene;

/// The rays of a point towards what lights it, with the light that each brings if nothing is in between: as in
/// shaders/shadow_rays/draw.comp.
struct PointRays {
  glm::vec3 position{};
  std::uint32_t triangle;  ///< + 1; 0: no point
  glm::vec3 sun{};
  std::uint32_t to_sun;
  glm::vec3 lamp{};
  std::uint32_t to_lamp;
  glm::vec3 sky{};
  std::uint32_t to_sky;
  float lamp_m, mapped;
  std::uint32_t pixel, base_color;
};
static_assert(sizeof(PointRays) == 80);

/// Points whose rays are drawn: those of the tiles of one band.
struct DrawnPoints {
  const ShadingPlan& plan;
  const TileList& tiles;
  std::size_t band = 0;
  bool sky = false;        ///< rays to the sky too
  bool lamps = true;       ///< rays to the scene's lights
  bool reflected = false;  ///< hits of mirrored rays
  bool all = true;         ///< also points without rays, which are then told from no point
  int number = 0;          ///< of the rays of a point
};
/// Draws them on the device into `buffer`, which has room for them, and reads them.
std::vector<PointRays> draw_point_rays(const FrameContext& frame, const DrawnPoints& points, Buffer* buffer);
/// Shader variants of these two.
std::vector<ShaderVariant> point_rays_shader_variants();

/// A direction as `PointRays` holds it.
glm::vec3 unpack_ray_direction(std::uint32_t packed);
/// Where the sun's ray leaves a point, or another's of this direction.
glm::vec3 ray_origin(const struct SurfacePlace& place, const glm::vec3& direction);

/// A point as its triangle has it, on either side of it.
struct SurfacePlace {
  glm::vec3 position{0.0f}, error{0.0f}, normal{0.0f};
};
/// The device's position lies off the triangle by rounding, far from the eye by more than rays bear.
SurfacePlace place_of(const FlatGeometry& geometry, std::uint32_t triangle, const glm::vec3& near);

/// What one point's rays bring beyond what shading has, cd/m2.
struct BroughtLight {
  glm::vec3 sun{0.0f}, lamp{0.0f}, sky{0.0f};
  unsigned rays = 0;
};
BroughtLight trace_point(const PathScene& scene, const PointRays& rays, const SurfacePlace& place);

}  // namespace maquette
