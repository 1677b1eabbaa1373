#include "render/shadow_rays/shadow_pass.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cmath>

#include "render/frame/constants.h"
#include "render/gl/bindings.h"
#include "render/math/shared_formulas.h"
#include "render/reference/path_scene.h"
#include "render/reference/traversal.h"
#include "render/shading/sampled_shading.h"

namespace maquette {

namespace {

/// As in shaders/shadow_rays/draw.comp.
struct PointRays {
  glm::vec3 position;
  std::uint32_t triangle;
  glm::vec3 sun;
  std::uint32_t to_sun;
  glm::vec3 lamp;
  std::uint32_t to_lamp;
  glm::vec3 sky;
  std::uint32_t to_sky;
  float lamp_m, mapped;
  std::uint32_t pixel, base_color;
};
static_assert(sizeof(PointRays) == 80);

/// Samples of the sun's light at a point that does not mirror it: of one, over which broad lobes hardly vary, and of
/// several, among which they choose.
constexpr int kSunSamples = 2, kSunsSamples = 16;
/// Rays to a lamp end before it.
constexpr float kBeforeLamp = 0.9999f;
/// Grid cells over which the sky's first ray of each point is smoothed; fewer as frames are added.
constexpr double kFilterRadius = 14.0;
constexpr int kBaseColorBias = 34;  ///< of shaders/shared/gbuffer.glsl
/// Base colours are not taken for darker.
constexpr float kLeastBase = 0.04f;

ShaderVariant draw_variant(const ShadingPlan& plan, bool measured) {
  return {"shadow_rays/draw.comp",
          "",
          {{"MEASURED", flag(measured)},
           {"SEPARATE_SUN", flag(plan.sun_apart)},
           {"VISIBILITY", "0"},
           {"LIGHTS", flag(plan.lights)},
           {"MAPS", flag(plan.visibility == "baked")}}};
}

glm::vec3 direction_of(std::uint32_t packed) { return shared::direction_from_octahedral(glm::unpackUnorm2x16(packed)); }

/// A point as its triangle has it, on either side of it.
struct SurfacePlace {
  glm::vec3 position{0.0f}, error{0.0f}, normal{0.0f};
};

/// The device's position lies off the triangle by rounding, far from the eye by more than rays bear.
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

/// What one point's rays bring beyond what shading has.
struct Brought {
  glm::vec3 bright{0.0f}, sky{0.0f};
  unsigned rays = 0;
};

Brought trace(const PathScene& scene, const PointRays& p, const SurfacePlace& place) {
  Brought brought;
  const auto through = [&](std::uint32_t packed, float far) {
    const glm::vec3 direction = direction_of(packed);
    const glm::vec3 side = glm::dot(place.normal, direction) < 0.0f ? -place.normal : place.normal;
    ++brought.rays;
    return transmittance(scene, {offset_from_surface(place.position, place.error, side), direction, 0.0f, far});
  };
  constexpr float kFar = 3.4e38f;
  if (p.sun != glm::vec3(0.0f)) brought.bright += p.sun * through(p.to_sun, kFar);
  if (p.lamp != glm::vec3(0.0f))
    brought.bright += p.lamp * (through(p.to_lamp, std::min(p.lamp_m * kBeforeLamp, kFar)) - 1.0f);
  if (p.sky != glm::vec3(0.0f)) brought.sky = p.sky * (through(p.to_sky, kFar) - p.mapped);
  return brought;
}

/// How much of a neighbour's light a point takes.
float likeness(const glm::vec3& offset, const glm::vec3& normal, const glm::vec3& other, float width_m) {
  const float facing = std::max(glm::dot(normal, other), 0.0f), facing2 = facing * facing, facing4 = facing2 * facing2;
  const float off = glm::dot(offset, normal) / (3.0f * width_m);
  return facing4 * facing4 * std::exp(-off * off);
}

}  // namespace

std::vector<ShaderVariant> ShadowPass::shader_variants() {
  std::vector<ShaderVariant> variants;
  for (int k = 0; k < 16; ++k) {
    ShadingPlan plan;
    plan.sun_apart = k & 1;
    plan.lights = k & 2;
    plan.visibility = k & 4 ? "baked" : "none";
    variants.push_back(draw_variant(plan, k & 8));
  }
  return variants;
}

void ShadowPass::run(const LayerContext& layer, bool averages) {
  const FrameContext& frame = layer.frame;
  const int w = frame.size().grid_width(), h = frame.size().grid_height();
  const auto count = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  if (!light_ || light_.width() != w || light_.height() != h)
    light_ = Texture::make_2d("light by shadow rays", GL_RGBA32F, w, h);
  frames_ = averages && frame.accumulated > 0 && bright_.size() == count ? frames_ + 1 : 1;
  if (frames_ == 1) {
    bright_.assign(count, glm::vec4(0.0f));
    raw_sky_.assign(count, glm::vec4(0.0f));
    points_.assign(count, Point());
    sky_frames_ = 0;
  }
  ray_count_ = 0;
  const TileList& tiles = layer.surfaces.tiles();
  const std::size_t bytes = static_cast<std::size_t>(tiles.band_tiles) * 64 * sizeof(PointRays);
  if (rays_.bytes() < bytes) rays_ = Buffer("shadow rays", bytes);
  frame.timer().end("draw_rays");  // also where nothing is seen
  for (std::size_t band = 0; band < tiles.counts.size(); ++band)
    if (tiles.counts[band] > 0) trace_band(layer, band, 64 * tiles.counts[band], 1.0f / static_cast<float>(frames_));
  sum_ = bright_;
  if (frame.accumulated > 0) {
    ++sky_frames_;
    filter_sky(w, h);
    for (std::size_t i = 0; i < count; ++i) sum_[i] += sky_[i] * glm::vec4(points_[i].base, 0.0f);
  }
  light_.upload(0, w, h, GL_RGBA, GL_FLOAT, sum_.data());
  frame.timer().end("trace_rays");
  frame.scene.environment().bind();
}

void ShadowPass::trace_band(const LayerContext& layer, std::size_t band, int points, float blend) {
  const FrameContext& frame = layer.frame;
  const SceneFacts& facts = frame.scene.facts();
  // The maps are good enough for a picture that moves.
  const bool sky = frame.accumulated > 0;
  const SunBuffers* sun = layer.plan.sun_apart ? frame.scene.environment().sun() : nullptr;
  if (sun) sun->bind();
  rays_.clear_to_zero();
  glBindTextureUnit(kUnitTriangle, layer.surfaces.triangle().get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPointRays, rays_.get());
  for (const bool measured : {true, false}) {
    if ((measured ? facts.measured_count : facts.analytic_count) == 0) continue;
    const Program& program = frame.programs.get(draw_variant(layer.plan, measured));
    if (sun) set_sun(program, *sun);
    program.set("u_frame_number", frame.accumulated);
    program.set("u_sky", sky ? 1 : 0);
    if (sun)
      glProgramUniform2i(program.get(), program.location("u_sun_list"), SunBuffers::kListLength,
                         sun->compact ? kSunSamples : kSunsSamples);
    dispatch_tiles(program, layer.surfaces.tiles(), kPerPoint, band);
  }
  frame.timer().end("draw_rays");
  std::vector<PointRays> rays(static_cast<std::size_t>(points));
  rays_.read(0, rays.size() * sizeof(PointRays), rays.data());
  const PathScene& scene = *frame.bakes.shadow_scene().scene();
  const FlatGeometry& geometry = frame.scene.geometry();
  const auto width = static_cast<std::size_t>(light_.width());
  const float sky_blend = 1.0f / static_cast<float>(sky_frames_ + 1);
  const glm::vec3 eye(layer.constants.eye);
  std::atomic<std::size_t> traced = 0;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), 256), [&](const auto& range) {
    std::size_t own = 0;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const PointRays& p = rays[i];
      if (p.triangle == 0) continue;
      const std::size_t at = (p.pixel >> 16u) * width + (p.pixel & 65535u);
      const SurfacePlace place = place_of(geometry, p.triangle - 1, p.position);
      Point& point = points_[at];
      const glm::vec3 root = shared::unpack_rgb9e5(p.base_color, kBaseColorBias);
      point.position = place.position;
      point.width_m = pixel_width(layer.constants, glm::length(place.position - eye));
      point.normal = place.normal;
      point.base = glm::max(root * root, glm::vec3(kLeastBase));
      const Brought brought = trace(scene, p, place);
      own += brought.rays;
      bright_[at] += (glm::vec4(brought.bright, 0.0f) - bright_[at]) * blend;
      if (sky) raw_sky_[at] += (glm::vec4(brought.sky / point.base, 0.0f) - raw_sky_[at]) * sky_blend;
    }
    traced += own;
  });
  ray_count_ += traced;
}

void ShadowPass::filter_sky(int width, int height) {
  // A ray's noise is about that of a path: as many are taken together, over neighbours and frames, as make a picture.
  const int radius = static_cast<int>(std::lround(kFilterRadius / std::sqrt(static_cast<double>(sky_frames_))));
  sky_ = raw_sky_;
  if (radius == 0) return;
  spare_.resize(sky_.size());
  for (const bool down : {false, true}) {
    tbb::parallel_for(0, height, [&](int y) {
      for (int x = 0; x < width; ++x) {
        const auto index = [&](int i, int j) {
          return static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i);
        };
        const std::size_t at = index(x, y);
        const Point& own = points_[at];
        spare_[at] = glm::vec4(0.0f);
        if (!(own.width_m > 0.0f)) continue;
        float weights = 0.0f;
        for (int k = -radius; k <= radius; ++k) {
          const int i = down ? x : x + k, j = down ? y + k : y;
          if (i < 0 || j < 0 || i >= width || j >= height) continue;
          const std::size_t to = index(i, j);
          const Point& other = points_[to];
          if (!(other.width_m > 0.0f)) continue;
          const float t = static_cast<float>(k) / static_cast<float>(radius);
          const float weight =
              std::exp(-2.0f * t * t) * likeness(other.position - own.position, own.normal, other.normal, own.width_m);
          spare_[at] += weight * sky_[to];
          weights += weight;
        }
        spare_[at] /= std::max(weights, 1e-6f);
      }
    });
    sky_.swap(spare_);
  }
}

}  // namespace maquette
