#include "render/reference/mirror_guide.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "render/reference/light_sampling.h"
#include "render/reference/path_sampler.h"
#include "render/reference/surface.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Bins of equal solid angle: rows of equal height, columns of equal longitude. A bin is 0.0027 sr or 3 degrees wide,
/// half of the angle that a cell's width makes of the direction to a pane at arm's length. Within a bin a small lamp is
/// found by chance, so wider bins cause fireflies, and narrower ones need more light paths to fill.
constexpr std::uint32_t kRows = 48, kColumns = 96;
constexpr float kBinDensity = static_cast<float>(kRows * kColumns) * 0.0795774715f;  // bins / (4 pi)
/// Least share of the light paths that lamps and the sky each get, where the other is brighter. With equal shares the
/// guide learned lamps by day that no picture shows, and rays were wasted on them (1.12 of the variance).
constexpr float kLeastShare = 0.01f;
constexpr int kMostFluxPanes = 8;  ///< that reflected light passes through
enum FluxDimension : std::uint32_t { kFluxPane, kFluxPoint, kFluxLightChoice, kFluxLight, kFluxWhich, kFluxOffset };

std::uint32_t bin_of(const glm::vec3& d, const glm::vec2& offset = glm::vec2(0.0f)) {
  const float row = (0.5f - 0.5f * d.y) * static_cast<float>(kRows) + offset.x;
  const float column =
      (0.5f + shared::latlong_atan2(d.x, d.z) * 0.15915494309f) * static_cast<float>(kColumns) + offset.y;
  const int last = static_cast<int>(kRows) - 1, columns = static_cast<int>(kColumns);
  const int r = std::clamp(static_cast<int>(std::floor(row)), 0, last);
  const int c = (static_cast<int>(std::floor(column)) + columns) % columns;
  return static_cast<std::uint32_t>(r * columns + c);
}

}  // namespace

MirrorGuide::MirrorGuide(const PathScene& scene, const EnvironmentLight& environment, const HashGrid& grid,
                         std::uint32_t seed)
    : scene_(scene), environment_(environment), grid_(grid), seed_(mix_seed(seed, 0x6d697272u)) {
  double area = 0.0;
  for (std::uint32_t triangle = scene.mesh_begin[PathScene::kPanes]; triangle < scene.mesh_begin[PathScene::kHidden];
       ++triangle) {
    if (!(scene.material_of(triangle).clear() > 0.0f)) continue;
    const auto& [p0, p1, p2] = scene.triangles[triangle].positions;
    area += static_cast<double>(glm::length(glm::cross(p1 - p0, p2 - p0)));
    panes_.push_back(triangle);
    areas_.push_back(area);
  }
  starts_.assign(HashGrid::kCells + 1, 0);
}

void MirrorGuide::learn(std::size_t count) {
  if (panes_.empty()) return;
  std::vector<Arrival> arrivals(count * kCopies);
  parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    trace_light(traced_ + static_cast<std::uint32_t>(i), std::span(arrivals).subspan(i * kCopies).first<kCopies>());
  });
  traced_ += static_cast<std::uint32_t>(count);
  merge_arrivals(std::move(arrivals));
}

float MirrorGuide::share_of_lamps(std::size_t cell) const {
  if (scene_.lights.lights.empty()) return 0.0f;
  const float lux = scene_.lights.lux_of_triangles[cell], sky = environment_.mean_lux();
  return environment_.black() ? 1.0f : std::max(kLeastShare, std::min(lux / (lux + sky), 1.0f - kLeastShare));
}

void MirrorGuide::trace_light(std::uint32_t index, std::span<Arrival, kCopies> arrivals) const {
  const PathSampler sampler{seed_, index};
  const double along = static_cast<double>(sampler.single(kFluxPane)) * areas_.back();
  const auto pane =
      static_cast<std::size_t>(std::upper_bound(areas_.begin(), areas_.end() - 1, along) - areas_.begin());
  RayHit hit;
  hit.triangle = panes_[pane];
  hit.barycentric = shared::light_triangle_uv(sampler.pair(kFluxPoint));
  const auto& [p0, p1, p2] = scene_.triangles[hit.triangle].positions;
  const glm::vec3 at = p0 + (p1 - p0) * hit.barycentric.x + (p2 - p0) * hit.barycentric.y;
  LightDraw light;
  const std::size_t cell = light_cell(scene_.lights, at);
  const float lamps = share_of_lamps(cell);
  if (sampler.single(kFluxWhich) < lamps) {
    const LightPick pick =
        choose_light(scene_.lights, cell, sampler.single(kFluxLightChoice), sampler.word(kFluxLightChoice));
    light = draw_scene_light(scene_, at, pick, sampler.pair(kFluxLight), false);
    light.pdf *= lamps;
  } else if (!environment_.black()) {
    light = environment_.draw(sampler.pair(kFluxLight));
    environment_.fill(&light);
    light.pdf *= 1.0f - lamps;
  }
  if (!(light.pdf > 0.0f) || !light.has_extent) return;
  const Ray towards{at, -light.direction, 0.0f, 3.4e38f};
  const SurfacePoint p = resolve_surface(scene_, towards, hit, {});
  const PaneRays rays = rays_of_pane(p, towards);
  Ray shadow{offset_from_surface(p.position, p.error, p.normal), light.direction, 0.0f, light.distance};
  if (light.distance < 3e38f) shadow.far *= 1.0f - 1e-4f;
  float flux =
      luminance(light.radiance * rays.shares.reflected) / light.pdf * std::abs(glm::dot(p.normal, light.direction));
  if (!(flux > 0.0f)) return;
  flux *= luminance(transmittance(scene_, shadow));
  Ray ray = rays.mirrored;
  for (int passed = 0; passed < kMostFluxPanes && flux > 0.0f && std::isfinite(flux); ++passed) {
    if (!intersect(scene_, ray, RayKind::path, sampler.word(kFluxOffset + 2 * kCopies), &hit)) return;
    const SurfacePoint q = resolve_surface(scene_, ray, hit, {});
    if (q.material->refracts()) return;
    if (!(q.material->pane > 0.0f)) {
      // Spread over two cells and a bin, so that their borders do not show. Several copies of one path cost less than
      // several paths.
      for (std::uint32_t k = 0; k < kCopies; ++k) {
        const glm::vec2 o = 2.0f * sampler.pair(kFluxOffset + 2 * k) - 1.0f;
        const glm::vec3 shifted = q.position + (q.t * o.x + q.b * o.y) * grid_.side(q.position);
        arrivals[k] = {grid_.cell_of(shifted, q.n),
                       bin_of(-ray.direction, sampler.pair(kFluxOffset + 2 * k + 1) - 0.5f),
                       static_cast<double>(flux) / kCopies};
      }
      return;
    }
    const PaneRays next = rays_of_pane(q, ray);
    flux *= luminance(next.shares.transmitted);
    ray = next.passed;
  }
}

void MirrorGuide::merge_arrivals(std::vector<Arrival> arrivals) {
  std::erase_if(arrivals, [](const Arrival& a) { return a.cell == HashGrid::kNoCell; });
  arrivals_.insert(arrivals_.end(), arrivals.begin(), arrivals.end());
  const auto key = [](const Arrival& a) { return std::tie(a.cell, a.bin, a.flux); };
  tbb::parallel_sort(arrivals_.begin(), arrivals_.end(),
                     [&](const Arrival& a, const Arrival& b) { return key(a) < key(b); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < arrivals_.size(); ++i)
    if (kept > 0 && arrivals_[kept - 1].cell == arrivals_[i].cell && arrivals_[kept - 1].bin == arrivals_[i].bin)
      arrivals_[kept - 1].flux += arrivals_[i].flux;
    else
      arrivals_[kept++] = arrivals_[i];
  arrivals_.resize(kept);
  entries_.clear();
  std::size_t next = 0;
  for (std::uint32_t cell = 0; cell < HashGrid::kCells; ++cell) {
    starts_[cell] = static_cast<std::uint32_t>(entries_.size());
    const std::size_t begin = next;
    double sum = 0.0, running = 0.0;
    for (; next < arrivals_.size() && arrivals_[next].cell == cell; ++next) sum += arrivals_[next].flux;
    for (std::size_t i = begin; i < next; ++i) {
      running += arrivals_[i].flux;
      entries_.push_back({arrivals_[i].bin, i + 1 == next ? 1.0f : static_cast<float>(running / sum)});
    }
  }
  starts_[HashGrid::kCells] = static_cast<std::uint32_t>(entries_.size());
}

glm::vec3 MirrorGuide::sample(std::uint32_t cell, const glm::vec2& u) const {
  const Entry* begin = entries_.data() + starts_[cell];
  const Entry* end = entries_.data() + starts_[cell + 1];
  const Entry* found =
      std::upper_bound(begin, end - 1, u.x, [](float value, const Entry& entry) { return value < entry.cumulative; });
  const float before = found == begin ? 0.0f : found[-1].cumulative;
  const float within = std::min((u.x - before) / std::max(found->cumulative - before, 1e-20f), 0x1.fffffep-1f);
  const float y = 1.0f - 2.0f * (static_cast<float>(found->bin / kColumns) + within) / static_cast<float>(kRows);
  const float longitude =
      ((static_cast<float>(found->bin % kColumns) + u.y) / static_cast<float>(kColumns) - 0.5f) * 6.28318530718f;
  const float r = std::sqrt(std::max(1.0f - y * y, 0.0f));
  return {std::sin(longitude) * r, y, std::cos(longitude) * r};
}

float MirrorGuide::pdf(std::uint32_t cell, const glm::vec3& direction) const {
  const std::uint32_t bin = bin_of(direction);
  const Entry* begin = entries_.data() + starts_[cell];
  const Entry* end = entries_.data() + starts_[cell + 1];
  const Entry* found =
      std::lower_bound(begin, end, bin, [](const Entry& entry, std::uint32_t b) { return entry.bin < b; });
  if (found == end || found->bin != bin) return 0.0f;
  return (found->cumulative - (found == begin ? 0.0f : found[-1].cumulative)) * kBinDensity;
}

}  // namespace maquette
