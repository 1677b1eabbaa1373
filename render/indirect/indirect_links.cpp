#include "render/indirect/indirect_links.h"

#include <algorithm>
#include <cmath>

#include "render/materials/analytic_albedo.h"
#include "render/reference/path_scene.h"
#include "render/reference/surface.h"
#include "render/reference/traversal.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kMinRays = 16, kMaxRays = 256;
/// Of a point, for a first result: blotchy, and soon there.
constexpr int kFirstRays = 4;
constexpr std::size_t kPointsPerTask = 64;
/// A ray that passes more panes than this is terminated.
constexpr int kMaxPanes = 6;
/// Shadowed samples of the scene's own lights, per point and side.
constexpr int kLampSamples = 16;
/// Rays that find out whether surfaces are met from behind; of more backs than kFewBacks their light is baked, too.
constexpr std::size_t kProbedPoints = 4096;
constexpr int kProbingRays = 16;
constexpr double kFewBacks = 0.005, kInside = 0.9;
/// 16 ulp of a coordinate.
constexpr float kRelativeLift = 1.0f / 1048576.0f;

std::uint32_t hash(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ (x >> 16);
}

float unit_float(std::uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

std::uint32_t pack_color(const glm::vec3& c) {
  const glm::uvec3 q(glm::clamp(c, 0.0f, 1.0f) * 1023.0f + 0.5f);
  return q.x | (q.y << 10) | (q.z << 20);
}

glm::vec3 albedo_at(const std::vector<glm::vec3>& table, float cosine) {
  const float e = std::acos(std::clamp(cosine, 0.0f, 1.0f)) * 0.63661977f * static_cast<float>(table.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(e), table.size() - 2);
  return glm::mix(table[i], table[i + 1], e - static_cast<float>(i));
}

class Tracer {
 public:
  Tracer(const IndirectInput& input, IndirectLinks* links) : input_(input), links_(*links) {
    PathSceneInput traced{.scene = unmeasured_, .environment = black(), .variant = input.variant};
    unmeasured_ = input.scene;
    for (Material& material : unmeasured_.materials) {
      // Their albedo is given, so the tables themselves (17 MB each) are not needed.
      if (material.measured.empty()) continue;
      material.measured.clear();
      if (!material.tint_measured) {
        material.base_color = glm::vec4(1.0f, 1.0f, 1.0f, material.base_color.a);
        material.base_color_texture.image =
            material.alpha_mode == AlphaMode::opaque ? -1 : material.base_color_texture.image;
      }
    }
    traced.geometry = input.geometry.get();
    scene_ = build_path_scene(traced);
  }

  /// Every material is replaced by a diffuse one of the same albedo: indirect light varies slowly.
  glm::vec3 reflectance(const SurfacePoint& p) const {
    const auto material = static_cast<std::size_t>(p.material - scene_->materials.data());
    if (material < input_.measured_albedo.size() && !input_.measured_albedo[material].empty()) {
      const glm::vec3 tint = input_.scene.materials[material].tint_measured ? p.base_color : glm::vec3(1.0f);
      return albedo_at(input_.measured_albedo[material], p.wo.z) * tint;
    }
    const shared::AnalyticAlbedo albedo = shared::analytic_albedo(p.analytic, p.wo.z);
    return albedo.diffuse + albedo.mirror + albedo.coat;
  }

  /// What a ray meets behind panes.
  struct Met {
    std::uint32_t point = kNoPoint;
    bool back = false;
    glm::vec3 color{0.0f};  ///< share of the light there that comes back along the ray
  };
  Met meet(const glm::vec3& origin, const glm::vec3& direction, std::uint32_t chance) const {
    glm::vec3 share(1.0f);
    Ray ray{origin, direction};
    for (int pane = 0; pane <= kMaxPanes; ++pane) {
      RayHit hit;
      if (!intersect(*scene_, ray, RayKind::path, chance, &hit)) return {};
      const TracedMaterial& material = scene_->material_of(hit.triangle);
      if (material.pane > 0.0f) {
        share *= pane_transmittance(*scene_, hit.triangle, hit.barycentric, -direction);
        ray.near = hit.distance * (1.0f + 1e-5f) + 1e-6f * static_cast<float>(links_.points.scale_m);
        continue;
      }
      const SurfacePoint surface = resolve_surface(*scene_, ray, hit, {});
      // Selects one corner by its barycentric weight: the expectation over rays is the interpolated value.
      const float u = unit_float(hash(chance));
      const int corner = u < hit.barycentric.x ? 1 : u < hit.barycentric.x + hit.barycentric.y ? 2 : 0;
      const std::uint32_t point = links_.points.point_of_vertex[scene_->corners(hit.triangle)[corner]];
      if (point == kNoPoint) return {};
      return {point, glm::dot(links_.points.points[point].normal, surface.normal) < 0.0f, share * reflectance(surface)};
    }
    return {};
  }

  IndirectLink link(const glm::vec3& origin, const glm::vec3& direction, std::uint32_t chance) const {
    const Met met = meet(origin, direction, chance);
    if (met.point == kNoPoint || (met.back && links_.sides == 1)) return {};
    const auto count = static_cast<std::uint32_t>(links_.points.points.size());
    return {met.point + (met.back ? count : 0u), pack_color(met.color)};
  }

  /// Of the surfaces that rays of a sample of points meet, from both sides, the share that they meet from behind.
  /// Points that see hardly anything else lie inside a body, where nobody looks, and do not count.
  double share_of_backs() const {
    const std::size_t count = links_.points.points.size(), step = std::max<std::size_t>(count / kProbedPoints, 1);
    std::atomic<std::uint32_t> backs{0}, all{0};
    parallel_for(std::size_t{0}, 2 * (count / step), [&](std::size_t k) {
      const IndirectStart start = indirect_start(links_, k / 2 * step, k % 2 == 0 ? 0 : 1);
      std::uint32_t met = 0, behind = 0;
      for (int r = 0; r < kProbingRays; ++r) {
        const glm::vec3 direction = start.frame.to_world(indirect_ray_direction(r, kProbingRays));
        const Met m = meet(start.origin, direction,
                           hash(static_cast<std::uint32_t>(k * kProbingRays + static_cast<std::size_t>(r))));
        met += m.point != kNoPoint ? 1 : 0;
        behind += m.point != kNoPoint && m.back ? 1 : 0;
      }
      if (static_cast<double>(behind) > kInside * kProbingRays) return;
      backs += behind;
      all += met;
    });
    return all > 0 ? static_cast<double>(backs) / static_cast<double>(all) : 0.0;
  }

  glm::vec3 lamps(const glm::vec3& origin, const glm::vec3& normal, std::uint32_t seed) const {
    const LightGrid& lights = scene_->lights;
    if (lights.lights.empty()) return glm::vec3(0.0f);
    const std::size_t cell = light_cell(lights, origin);
    glm::vec3 sum(0.0f);
    for (std::uint32_t i = 0; i < kLampSamples; ++i) {
      const std::uint32_t h = hash(seed + i * 0x9e3779b9u);
      // Stratified selection of the light.
      const float u = (static_cast<float>(i) + unit_float(h)) / static_cast<float>(kLampSamples);
      const LightPick pick = choose_light(lights, cell, u, hash(h ^ 0x1f83d9abu));
      const LightRecord& light = lights.lights[pick.index];
      const shared::LightSample s =
          shared::light_sample(light, origin, {unit_float(hash(h ^ 0x68bc21ebu)), unit_float(hash(h ^ 0x02e5be93u))});
      const float cosine = glm::dot(normal, s.wi);
      if (!(cosine > 0.0f)) continue;
      // Clamps each sample to the irradiance of a lamp that fills the hemisphere: close to a small lamp energy is lost
      // instead of noise added.
      glm::vec3 irradiance = s.radiance * (cosine / std::max(pick.probability, 1e-20f));
      if (light.kind == shared::kLightTriangle) irradiance = glm::min(irradiance, light.color * 3.14159265f);
      const Ray ray{origin, s.wi, 0.0f, s.distance_m * (1.0f - 1e-4f)};
      sum += irradiance * transmittance(*scene_, ray);
    }
    return sum / static_cast<float>(kLampSamples);
  }
  bool has_lamps() const { return !scene_->lights.lights.empty(); }

  void trace_point(std::size_t index, int side) {
    const auto [frame, origin] = indirect_start(links_, index, side);
    const std::size_t slot = static_cast<std::size_t>(side) * links_.points.points.size() + index;
    const auto rays = static_cast<std::size_t>(links_.rays);
    for (std::size_t r = 0; r < rays; ++r) {
      const glm::vec3 direction = frame.to_world(pattern_[r]);
      links_.links[slot * rays + r] = link(origin, direction, hash(static_cast<std::uint32_t>(slot * rays + r)));
    }
    if (!links_.lamps.empty())
      links_.lamps[slot] = lamps(origin, frame.n, hash(static_cast<std::uint32_t>(slot) ^ 0x5bd1e995u));
  }

  /// From all points.
  void trace(int rays, const std::atomic<bool>& cancel, const std::function<void(double)>& progress) {
    prepare(rays);
    const std::size_t count = links_.points.points.size();
    std::atomic<std::size_t> done{0};
    parallel_ranges<std::size_t>(0, count, kPointsPerTask, [&](const auto& range) {
      if (cancel) return;
      for (std::size_t i = range.begin(); i != range.end(); ++i)
        for (int side = 0; side < links_.sides; ++side) trace_point(i, side);
      const std::size_t now = done += range.size();
      if (progress) progress(static_cast<double>(now) / static_cast<double>(count));
    });
  }

  const std::shared_ptr<const PathScene>& scene() const { return scene_; }

 private:
  void prepare(int rays) {
    links_.rays = rays;
    pattern_.clear();
    for (int r = 0; r < rays; ++r) pattern_.push_back(indirect_ray_direction(r, rays));
    const std::size_t slots = links_.points.points.size() * static_cast<std::size_t>(links_.sides);
    links_.links.resize(slots * static_cast<std::size_t>(links_.rays));
    if (has_lamps()) links_.lamps.resize(slots);
  }

  static std::shared_ptr<const Environment> black() {
    auto environment = std::make_shared<Environment>();
    environment->width = environment->height = 1;
    environment->rgb.assign(1, glm::vec3(0.0f));
    return environment;
  }

  const IndirectInput& input_;
  IndirectLinks& links_;
  Scene unmeasured_;
  std::shared_ptr<const PathScene> scene_;
  std::vector<glm::vec3> pattern_;
};

bool shows_backs(const IndirectInput& input) {
  for (std::size_t i = 0; i < input.geometry->items.size(); ++i) {
    const DrawItem& item = input.geometry->items[i];
    if (input.transmits[i]) continue;
    if (item.patch >= 0) return true;
    const auto& primitive =
        input.scene.meshes[static_cast<std::size_t>(item.mesh)].primitives[static_cast<std::size_t>(item.primitive)];
    const int material = material_of(primitive, input.variant);
    if (material >= 0 && input.scene.materials[static_cast<std::size_t>(material)].double_sided) return true;
  }
  return false;
}

/// Neighbours are weighted by how well they lie on the same smooth surface; together they weigh as much as the point
/// itself.
void find_neighbours(IndirectLinks* links) {
  const std::vector<VisibilityPoint>& points = links->points.points;
  std::vector<std::uint32_t>& first = links->first_neighbour;
  first.assign(points.size() + 1, 0);
  for (const auto& triangle : links->points.triangles)
    for (const std::uint32_t corner : triangle) first[corner + 1] += 2;
  for (std::size_t i = 0; i < points.size(); ++i) first[i + 1] += first[i];
  links->neighbours.resize(first.back());
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  std::vector<float> sums(points.size(), 0.0f);
  for (const auto& triangle : links->points.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
      const float c = std::max(glm::dot(points[a].normal, points[b].normal), 0.0f), w = c * c * c * c;
      links->neighbours[next[a]++] = {b, w};
      links->neighbours[next[b]++] = {a, w};
      sums[a] += w;
      sums[b] += w;
    }
  }
  links->own_weight.assign(points.size(), 1.0f);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (sums[i] > 0.0f) links->own_weight[i] = 0.5f;
    const float share = sums[i] > 0.0f ? 0.5f / sums[i] : 0.0f;
    for (std::uint32_t k = first[i]; k < first[i + 1]; ++k) links->neighbours[k].weight *= share;
  }
}

}  // namespace

glm::vec3 indirect_ray_direction(int r, int rays) {
  // Fibonacci points on the disc, lifted to the hemisphere (Malley's method).
  const float u = (static_cast<float>(r) + 0.5f) / static_cast<float>(rays);
  const float phi = 2.39996323f * static_cast<float>(r), radius = std::sqrt(u);
  return {radius * std::cos(phi), radius * std::sin(phi), std::sqrt(1.0f - u)};
}

IndirectFrame indirect_frame(const VisibilityPoint& point, std::size_t index, int side) {
  const glm::vec3 n = side == 0 ? point.normal : -point.normal;
  // Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
  const float s = n.z >= 0.0f ? 1.0f : -1.0f, a = -1.0f / (s + n.z), c = n.x * n.y * a;
  const glm::vec3 t(1.0f + s * n.x * n.x * a, s * c, -s * n.x), b(c, s + n.y * n.y * a, -n.y);
  const float phi =
      6.28318531f * unit_float(hash(static_cast<std::uint32_t>(index) * 2u + static_cast<std::uint32_t>(side)));
  const float cosine = std::cos(phi), sine = std::sin(phi);
  return {cosine * t + sine * b, cosine * b - sine * t, n};
}

IndirectStart indirect_start(const IndirectLinks& links, std::size_t index, int side) {
  const VisibilityPoint& point = links.points.points[index];
  const IndirectFrame frame = indirect_frame(point, index, side);
  const glm::vec3 at(links.points.center + links.points.scale_m * glm::dvec3(point.position + point.inset));
  const float largest = std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)});
  const float lift = point.lift * static_cast<float>(links.points.scale_m) + kRelativeLift * largest;
  return {frame, at + frame.n * lift};
}

std::shared_ptr<const IndirectLinks> trace_indirect_links(const IndirectInput& input, std::size_t budget,
                                                          const std::atomic<bool>& cancel,
                                                          const std::function<void(double)>& progress,
                                                          const std::function<void(const IndirectLinks&)>& first) {
  auto links = std::make_shared<IndirectLinks>();
  links->points = build_visibility_points(*input.geometry, input.transmits, cancel);
  if (cancel) return nullptr;
  const std::size_t count = links->points.points.size();
  links->vertex_of_point.assign(count, kNoPoint);
  for (std::size_t v = 0; v < links->points.point_of_vertex.size(); ++v) {
    const std::uint32_t point = links->points.point_of_vertex[v];
    if (point != kNoPoint) links->vertex_of_point[point] = static_cast<std::uint32_t>(v);
  }
  Tracer tracer(input, links.get());
  if (cancel) return nullptr;
  links->sides = shows_backs(input) || tracer.share_of_backs() > kFewBacks ? 2 : 1;
  const std::size_t slots = std::max<std::size_t>(count * static_cast<std::size_t>(links->sides), 1);
  const int rays = std::clamp(static_cast<int>(budget / slots), kMinRays, kMaxRays);
  links->scene = tracer.scene();
  find_neighbours(links.get());
  if (first) {
    tracer.trace(kFirstRays, cancel, {});
    if (cancel) return nullptr;
    first(*links);
  }
  tracer.trace(rays, cancel, progress);
  return cancel ? nullptr : links;
}

}  // namespace maquette
