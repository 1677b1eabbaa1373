#include "render/slf/incident.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/environment/importance.h"
#include "render/reference/path.h"
#include "render/reference/traced_environment.h"
#include "render/reference/traversal.h"
#include "render/slf/parabolic.h"

namespace maquette {

namespace {

/// Light samples of a texel: enough for a sun's irradiance within a percent beside a sky of the same power.
constexpr int kSkySamples = 512, kLampSamples = 64;
/// Rays that decide whether a texel is inside a body, and the share of back faces among them from which it is.
constexpr int kInsideRays = 32;
constexpr float kInsideShare = 0.5f;
/// Dimensions of the sampler that no path uses (render/reference/path_constants.h).
constexpr std::uint32_t kBinDimension = 0x7fff0000u, kSkyDimension = 0x7fff0001u, kLampDimension = 0x7fff0002u,
                        kInsideDimension = 0x7fff0003u;
/// Rounding of a position: as in render/reference/surface.cpp.
constexpr float kPositionError = 16.0f * 0x1p-24f;

void add(std::span<float> out, int bin, const glm::vec3& value) {
  for (std::size_t c = 0; c < 3; ++c) out[3 * static_cast<std::size_t>(bin) + c] += value[static_cast<int>(c)];
}

/// What of a sky its light samples are drawn by: what is above its mean. The rest is even enough for the bins' own
/// rays, and light samples of it would only add their noise; under a constant sky there are none. The estimate stays
/// unbiased, because the bins' rays reach every direction. Source: Karlik et al. 2019, "MIS Compensation: Optimizing
/// Sampling Techniques in Multiple Importance Sampling", Sec. 5.
TracedEnvironment peaks_of(const Environment& sky) {
  glm::dvec3 sum(0.0);
  double weights = 0.0;
  for (int y = 0; y < sky.height; ++y) {
    const double weight = row_weights(y, sky.width, sky.height).solid_angle();
    for (int x = 0; x < sky.width; ++x)
      sum +=
          weight *
          glm::dvec3(
              sky.rgb[static_cast<std::size_t>(y) * static_cast<std::size_t>(sky.width) + static_cast<std::size_t>(x)]);
    weights += weight * sky.width;
  }
  const double mean = (sum.x + sum.y + sum.z) / (3.0 * weights);
  auto peaks = std::make_shared<Environment>();
  peaks->width = sky.width;
  peaks->height = sky.height;
  peaks->rgb.reserve(sky.rgb.size());
  for (const glm::vec3& rgb : sky.rgb) {
    const double light = (static_cast<double>(rgb.x) + static_cast<double>(rgb.y) + static_cast<double>(rgb.z)) / 3.0;
    // Rounding of the mean is no peak.
    peaks->rgb.emplace_back(static_cast<float>(light > 1.0001 * mean ? light - mean : 0.0));
  }
  EnvironmentTables tables;
  compute_importance(*peaks, tables);
  return trace_environment(std::move(peaks), std::move(tables));
}

}  // namespace

TexelFrame frame_of_texel(const FlatGeometry& g, const LightFieldAtlas& atlas, std::size_t index) {
  const AtlasTexel& texel = atlas.texels[index];
  const AtlasSide& side = atlas.sides[texel.side];
  const std::array<std::uint32_t, 3>& corner = side.vertices;
  const float b[3] = {1.0f - texel.barycentric.x - texel.barycentric.y, texel.barycentric.x, texel.barycentric.y};
  TexelFrame f;
  glm::vec3 magnitude(0.0f), normal(0.0f);
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::vec3 p = g.positions[corner[k]] * b[k];
    f.position += p;
    magnitude += glm::abs(p);
    normal += g.normals[corner[k]] * b[k];
  }
  const glm::dvec3 p0(g.positions[corner[0]]), e1 = glm::dvec3(g.positions[corner[1]]) - p0,
                                               e2 = glm::dvec3(g.positions[corner[2]]) - p0;
  const float sign = side.back ? -1.0f : 1.0f;
  f.geometric = glm::vec3(glm::normalize(glm::cross(e1, e2))) * sign;
  f.n = shared::interpolated_normal(normal, f.geometric);
  if (glm::dot(f.n, f.geometric) < 0.0f) f.n = -f.n;
  const shared::CarriedFrame frame = shared::carried_frame(atlas.axes[side.chart], f.n);
  f.t = frame.t;
  f.b = frame.b;
  const float error = std::max({magnitude.x, magnitude.y, magnitude.z}) * kPositionError;
  f.origin = offset_from_surface(f.position, glm::vec3(error), f.geometric);
  return f;
}

struct IncidentTracer::Lights {
  Lights(const PathScene& scene, const PathOptions& paths)
      : peaks(peaks_of(*scene.environment.source)),
        environment(scene.environment, paths),
        sampled(peaks, paths),
        options(paths),
        lamps(!scene.lights.lights.empty()) {}
  TracedEnvironment peaks;
  EnvironmentLight environment;
  EnvironmentLight sampled;  ///< by whose density the sky's light samples are drawn
  PathOptions options;
  bool lamps;
};

IncidentTracer::IncidentTracer(std::shared_ptr<const PathScene> scene, std::shared_ptr<const LightFieldAtlas> atlas,
                               const IncidentOptions& options)
    : scene_(std::move(scene)), atlas_(std::move(atlas)), options_(options), lumisphere_(options.side) {
  PathOptions paths;
  paths.env_rotation_rad = options.env_rotation_rad;
  paths.env_scale = options.env_scale;
  lights_ = std::make_unique<const Lights>(*scene_, paths);
}
IncidentTracer::~IncidentTracer() = default;

bool IncidentTracer::trace(std::size_t texel, std::span<float> out) const {
  std::fill(out.begin(), out.end(), 0.0f);
  const TexelFrame frame = frame_of_texel(scene_->geometry, *atlas_, texel);
  const std::uint32_t seed = mix_seed(options_.seed, static_cast<std::uint32_t>(texel));
  if (is_inside(frame, seed)) return true;
  add_paths(frame, seed, out);
  add_light_samples(frame, seed, out);
  // A bake never holds NaN or infinity, whatever a table holds.
  for (float& v : out)
    if (!std::isfinite(v)) v = 0.0f;
  return false;
}

bool IncidentTracer::is_inside(const TexelFrame& frame, std::uint32_t seed) const {
  int backs = 0;
  for (std::uint32_t i = 0; i < kInsideRays; ++i) {
    const glm::vec2 u = PathSampler{seed, i}.pair(kInsideDimension);
    const float r = std::sqrt(u.x), phi = 6.2831853f * u.y;
    const glm::vec3 d = frame.to_world({r * std::cos(phi), r * std::sin(phi), std::sqrt(1.0f - u.x)});
    RayHit hit;
    if (glm::dot(d, frame.geometric) <= 0.0f || !intersect(*scene_, {frame.origin, d}, RayKind::path, 0u, &hit))
      continue;
    const TracedTriangle& triangle = scene_->triangles[hit.triangle];
    const TracedMaterial& material = scene_->material_of(hit.triangle);
    const bool body = (triangle.material & kBothSides) == 0u && material.pane <= 0.0f && !material.blended;
    backs += body && glm::dot(triangle.geometric, d) > 0.0f ? 1 : 0;
  }
  return static_cast<float>(backs) > kInsideShare * kInsideRays;
}

void IncidentTracer::add_paths(const TexelFrame& frame, std::uint32_t seed, std::span<float> out) const {
  const auto paths = static_cast<std::uint32_t>(options_.paths);
  const float each = 1.0f / static_cast<float>(paths);
  PathGroup group(*scene_, lights_->environment, lights_->options.max_bounces);
  std::vector<CameraRay> rays;
  rays.reserve(PathGroup::kMost);
  std::vector<PathTask> tasks;
  std::array<std::pair<int, float>, PathGroup::kMost> targets;
  const auto follow = [&] {
    for (std::size_t i = 0; i < tasks.size(); ++i) tasks[i].ray = &rays[i];
    if (!tasks.empty()) group.follow(tasks);
    for (std::size_t i = 0; i < tasks.size(); ++i)
      add(out, targets[i].first, tasks[i].estimate.radiance * targets[i].second);
    tasks.clear();
    rays.clear();
  };
  float density = 0.0f;  // of the bin's rays, 1/sr
  glm::vec3 direction(0.0f);
  const auto sky_density = [&] {
    return lights_->sampled.black() ? 0.0f : lights_->sampled.radiance_and_density(direction).w;
  };
  const SeenShare share = [&](std::uint32_t triangle, float) {
    const float other = triangle == kNoTriangle ? sky_density() * kSkySamples
                                                : scene_light_pdf(*scene_, triangle, frame.position) * kLampSamples;
    return density / (density + other);
  };
  for (int bin = 0; bin < lumisphere_.count(); ++bin)
    for (std::uint32_t i = 0; i < paths; ++i) {
      const PathSampler sampler{mix_seed(seed, static_cast<std::uint32_t>(bin)), i};
      const Lumisphere::Sample s = lumisphere_.draw(bin, sampler.pair(kBinDimension));
      const glm::vec3 d = direction = frame.to_world(s.direction);
      if (s.weight == 0.0f || glm::dot(d, frame.geometric) <= 0.0f) continue;
      density = s.density * static_cast<float>(paths);
      targets[tasks.size()] = {bin, s.weight * each};
      rays.emplace_back(*scene_, lights_->environment, Ray{frame.origin, d}, nullptr, sampler.word(0), &share);
      tasks.push_back({nullptr, sampler, 0, {}});
      if (tasks.size() == PathGroup::kMost) follow();
    }
  follow();
}

void IncidentTracer::add_light_samples(const TexelFrame& frame, std::uint32_t seed, std::span<float> out) const {
  const auto add_draw = [&](const LightDraw& draw, int samples) {
    const glm::vec3 wi = frame.to_local(draw.direction);
    if (!(draw.pdf > 0.0f) || wi.z <= 0.0f || glm::dot(draw.direction, frame.geometric) <= 0.0f) return;
    Ray ray{frame.origin, draw.direction, 0.0f, draw.distance};
    if (draw.distance < 3e38f) ray.far *= 1.0f - 1e-4f;
    const glm::vec3 through = transmittance(*scene_, ray);
    if (through == glm::vec3(0.0f)) return;
    const int bin = lumisphere_.bin_of(wi);
    float density = draw.pdf * static_cast<float>(samples);
    if (draw.has_extent) density += lumisphere_.density(bin, wi) * static_cast<float>(options_.paths);
    add(out, bin, draw.radiance * through * (wi.z / (density * static_cast<float>(lumisphere_.projected(bin)))));
  };
  if (!lights_->sampled.black())
    for (std::uint32_t i = 0; i < kSkySamples; ++i) {
      LightDraw draw = lights_->sampled.draw(PathSampler{seed, i}.pair(kSkyDimension));
      lights_->sampled.fill(&draw);
      draw.radiance = glm::vec3(lights_->environment.radiance_and_density(draw.direction));
      draw.has_extent = true;
      add_draw(draw, kSkySamples);
    }
  if (!lights_->lamps) return;
  const std::size_t cell = light_cell(scene_->lights, frame.position);
  for (std::uint32_t i = 0; i < kLampSamples; ++i) {
    const PathSampler sampler{seed, i};
    const LightPick pick =
        choose_light(scene_->lights, cell, sampler.single(kLampDimension), sampler.word(kLampDimension));
    if (!(pick.probability > 0.0f)) continue;
    add_draw(draw_scene_light(*scene_, frame.position, pick, sampler.pair(kLampDimension), false), kLampSamples);
  }
}

}  // namespace maquette
