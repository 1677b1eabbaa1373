#include "render/shadow_rays/point_rays.h"

#include <algorithm>
#include <cmath>

#include "render/gl/bindings.h"
#include "render/math/shared_formulas.h"
#include "render/reference/path_scene.h"
#include "render/reference/traversal.h"
#include "render/shading/sampled_shading.h"

namespace maquette {

namespace {

/// Samples of the sun's light at a point that does not mirror it: of one, over which broad lobes hardly vary, and of
/// several, among which they choose.
constexpr int kSunSamples = 4, kSunsSamples = 16;
/// Rays to a lamp end before it.
constexpr float kBeforeLamp = 0.9999f;

ShaderVariant draw_variant(const DrawnPoints& points, bool measured) {
  const ShadingPlan& plan = points.plan;
  ShaderVariant variant{"shadow_rays/draw.comp",
                        "",
                        {{"MEASURED", flag(measured)},
                         {"SEPARATE_SUN", flag(plan.sun_apart)},
                         {"VISIBILITY", "0"},
                         {"LIGHTS", flag(plan.lights && points.lamps)},
                         {"SKY", flag(points.sky)},
                         {"MAPS", flag(plan.visibility == "baked")}}};
  if (points.reflected) variant.defines.emplace_back("REFLECTED", "1");
  return variant;
}

}  // namespace

glm::vec3 unpack_ray_direction(std::uint32_t packed) {
  return shared::direction_from_octahedral(glm::unpackUnorm2x16(packed));
}

glm::vec3 ray_origin(const SurfacePlace& place, const glm::vec3& direction) {
  const glm::vec3 side = glm::dot(place.normal, direction) < 0.0f ? -place.normal : place.normal;
  return offset_from_surface(place.position, place.error, side);
}

std::vector<ShaderVariant> point_rays_shader_variants() {
  std::vector<ShaderVariant> variants;
  const TileList none;
  for (int k = 0; k < 64; ++k) {
    ShadingPlan plan;
    plan.sun_apart = k & 1;
    plan.lights = k & 2;
    plan.visibility = k & 4 ? "baked" : "none";
    const DrawnPoints points{.plan = plan, .tiles = none, .sky = (k & 16) != 0, .reflected = (k & 32) != 0};
    variants.push_back(draw_variant(points, k & 8));
  }
  return variants;
}

std::vector<PointRays> draw_point_rays(const FrameContext& frame, const DrawnPoints& points, Buffer* buffer) {
  const SceneFacts& facts = frame.scene.facts();
  const SunBuffers* sun = points.plan.sun_apart ? frame.scene.environment().sun() : nullptr;
  if (sun) sun->bind();
  std::vector<PointRays> rays(64 * static_cast<std::size_t>(points.tiles.counts[points.band]));
  const auto bytes = static_cast<GLsizeiptr>(rays.size() * sizeof(PointRays));
  glClearNamedBufferSubData(buffer->get(), GL_R32UI, 0, bytes, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPointRays, buffer->get());
  for (const bool measured : {true, false}) {
    if ((measured ? facts.measured_count : facts.analytic_count) == 0) continue;
    const Program& program = frame.programs.get(draw_variant(points, measured));
    if (sun) set_sun(program, *sun);
    program.set("u_frame_number", points.number);
    program.set("u_facing_sun", !points.all && !points.sky && !points.lamps && sun && sun->compact ? 1 : 0);
    if (sun)
      glProgramUniform2i(program.get(), program.location("u_sun_list"), SunBuffers::kListLength,
                         sun->compact ? kSunSamples : kSunsSamples);
    dispatch_tiles(program, points.tiles, kPerPoint, points.band);
  }
  if (sun) frame.scene.environment().bind();
  buffer->read(0, rays.size() * sizeof(PointRays), rays.data());
  return rays;
}

SurfacePlace place_of(const FlatGeometry& geometry, std::uint32_t triangle, const glm::vec3& near) {
  const std::uint32_t* corners = &geometry.indices[3 * static_cast<std::size_t>(triangle)];
  const glm::dvec3 a(geometry.positions[corners[0]]), b(geometry.positions[corners[1]]),
      c(geometry.positions[corners[2]]);
  const glm::dvec3 e1 = b - a, e2 = c - a, d = glm::dvec3(near) - a, n = glm::cross(e1, e2);
  const double area2 = glm::dot(n, n);
  if (!(area2 > 0.0)) return {near, glm::vec3(0.0f), glm::vec3(0.0f)};
  double v = glm::clamp(glm::dot(glm::cross(d, e2), n) / area2, 0.0, 1.0),
         w = glm::clamp(glm::dot(glm::cross(e1, d), n) / area2, 0.0, 1.0);
  const double excess = std::max(v + w, 1.0);
  v /= excess;
  w /= excess;
  const double u = 1.0 - v - w;
  // Source: as kPositionError of render/reference/surface.cpp.
  constexpr double kError = 16.0 * 0x1p-24;
  const glm::dvec3 magnitude = u * glm::abs(a) + v * glm::abs(b) + w * glm::abs(c);
  return {glm::vec3(u * a + v * b + w * c),
          glm::vec3(static_cast<float>(kError * std::max({magnitude.x, magnitude.y, magnitude.z}))),
          glm::vec3(n / std::sqrt(area2))};
}

BroughtLight trace_point(const PathScene& scene, const PointRays& p, const SurfacePlace& place) {
  BroughtLight brought;
  const auto through = [&](std::uint32_t packed, float far) {
    const glm::vec3 direction = unpack_ray_direction(packed);
    ++brought.rays;
    return transmittance(scene, {ray_origin(place, direction), direction, 0.0f, far});
  };
  constexpr float kFar = 3.4e38f;
  if (p.sun != glm::vec3(0.0f)) brought.sun = p.sun * through(p.to_sun, kFar);
  if (p.lamp != glm::vec3(0.0f))
    brought.lamp = p.lamp * (through(p.to_lamp, std::min(p.lamp_m * kBeforeLamp, kFar)) - 1.0f);
  if (p.sky != glm::vec3(0.0f)) brought.sky = p.sky * (through(p.to_sky, kFar) - p.mapped);
  return brought;
}

}  // namespace maquette
