#include "render/indirect/indirect_light.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>

#include "render/indirect/indirect_shared.h"
#include "render/visibility/visibility_shared.h"

namespace maquette {

namespace {

constexpr std::size_t kCells = std::size_t{kVisibilitySide} * kVisibilitySide;
constexpr int kMaxBounces = 16;
/// Bounces end when the last one changed no point's light by more than this share of the brightest mean.
constexpr float kEnough = 1e-3f;
constexpr int kSmoothingRounds = 2;

float largest(const glm::vec3& v) { return std::max({v.x, v.y, v.z}); }

glm::vec3 unpack_color(std::uint32_t c) {
  return glm::vec3(static_cast<float>(c & 1023u), static_cast<float>((c >> 10) & 1023u), static_cast<float>(c >> 20)) *
         (1.0f / 1023.0f);
}

struct CellSum {
  glm::dvec3 irradiance{0.0}, direction{0.0};
  double weight = 0.0;
};

void splat_rows(const IndirectSky& sky, int first, int last, std::array<CellSum, kCells>* sums) {
  const Environment& e = *sky.environment;
  const float cosine = std::cos(sky.rotation_rad), sine = std::sin(sky.rotation_rad);
  for (int y = first; y < last; ++y) {
    const double top = std::cos(std::numbers::pi * y / e.height),
                 bottom = std::cos(std::numbers::pi * (y + 1) / e.height);
    const double solid_angle = 2.0 * std::numbers::pi / e.width * (top - bottom) * static_cast<double>(sky.scale);
    for (int x = 0; x < e.width; ++x) {
      const glm::vec3& rgb =
          e.rgb[static_cast<std::size_t>(y) * static_cast<std::size_t>(e.width) + static_cast<std::size_t>(x)];
      const double light = static_cast<double>(0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z);
      if (!(light > 0.0)) continue;
      const glm::vec2 uv((static_cast<float>(x) + 0.5f) / static_cast<float>(e.width),
                         (static_cast<float>(y) + 0.5f) / static_cast<float>(e.height));
      const glm::vec3 d = shared::latlong_turn(shared::direction_from_latlong_uv(uv), cosine, sine);
      const shared::VisibilityCorner corner = shared::visibility_corner(d);
      for (int k = 0; k < 4; ++k) {
        const glm::ivec2 cell = shared::visibility_wrap(corner.lower + glm::ivec2(k & 1, k >> 1));
        const float w = (k & 1 ? corner.fraction.x : 1.0f - corner.fraction.x) *
                        (k & 2 ? corner.fraction.y : 1.0f - corner.fraction.y);
        CellSum& sum = (*sums)[static_cast<std::size_t>(cell.y * kVisibilitySide + cell.x)];
        const double weight = static_cast<double>(w) * solid_angle;
        sum.irradiance += weight * glm::dvec3(rgb);
        sum.direction += weight * light * glm::dvec3(d);
        sum.weight += weight * light;
      }
    }
  }
}

/// Direct irradiance of the sky on one side of a point.
glm::vec3 direct_irradiance(const VisibilityBits& bits, const glm::vec3& normal, const SkyCells& sky) {
  glm::vec3 sum(0.0f);
  for (std::size_t b = 0; b < kCells; ++b) {
    const float cosine = glm::dot(normal, sky.direction[b]);
    const bool open = (bits[b >> 5] >> (b & 31u)) & 1u;
    sum += sky.irradiance[b] * (open && cosine > 0.0f ? cosine : 0.0f);
  }
  return sum;
}

template <typename Body>
void for_slots(std::size_t count, const std::atomic<bool>& cancel, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 256), [&](const auto& range) {
    if (cancel) return;
    for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
  });
}

/// Mean with the neighbours on the same smooth surface: what one pattern of rays misses, the next one sees.
void smooth(const IndirectLinks& links, std::vector<IndirectRadiance>* values) {
  const std::size_t count = links.points.points.size();
  struct Sum {
    IndirectRadiance value;
    float weight = 0.0f;
  };
  for (int side = 0; side < links.sides; ++side) {
    IndirectRadiance* v = values->data() + static_cast<std::size_t>(side) * count;
    std::vector<Sum> sums(count);
    for (const auto& triangle : links.points.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
        const float c = std::max(glm::dot(links.points.points[a].normal, links.points.points[b].normal), 0.0f);
        const float w = c * c * c * c;
        for (const auto& [to, from] : {std::pair(a, b), std::pair(b, a)}) {
          sums[to].value.mean += w * v[from].mean;
          sums[to].value.gradient += w * v[from].gradient;
          sums[to].weight += w;
        }
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (!(sums[i].weight > 0.0f)) continue;
      v[i].mean = 0.5f * v[i].mean + (0.5f / sums[i].weight) * sums[i].value.mean;
      v[i].gradient = 0.5f * v[i].gradient + (0.5f / sums[i].weight) * sums[i].value.gradient;
    }
  }
}

}  // namespace

SkyCells splat_sky(const IndirectSky& sky) {
  std::array<CellSum, kCells> total{};
  const int height = sky.environment->height;
  // A fixed number of parts, added in order: the sum does not depend on how many threads there are.
  constexpr int kParts = 16;
  std::vector<std::array<CellSum, kCells>> parts(kParts);
  tbb::parallel_for(0, kParts, [&](int part) {
    splat_rows(sky, height * part / kParts, height * (part + 1) / kParts, &parts[static_cast<std::size_t>(part)]);
  });
  SkyCells cells;
  for (std::size_t b = 0; b < kCells; ++b) {
    for (const auto& part : parts) {
      total[b].irradiance += part[b].irradiance;
      total[b].direction += part[b].direction;
      total[b].weight += part[b].weight;
    }
    cells.irradiance.emplace_back(total[b].irradiance);
    cells.direction.emplace_back(total[b].weight > 0.0 ? total[b].direction / total[b].weight : glm::dvec3(0.0));
  }
  return cells;
}

std::optional<std::vector<IndirectRadiance>> solve_indirect(const IndirectLinks& links, const VisibilityBake& bits,
                                                            const IndirectSky& sky, const std::atomic<bool>& cancel) {
  const SkyCells cells = splat_sky(sky);
  const std::size_t count = links.points.points.size(), slots = count * static_cast<std::size_t>(links.sides);
  const auto rays = static_cast<std::size_t>(links.rays);
  std::vector<glm::vec3> direct(slots);
  for_slots(slots, cancel, [&](std::size_t i) {
    const VisibilityPoint& point = links.points.points[i % count];
    const std::uint32_t vertex = links.vertex_of_point[i % count];
    if (vertex == kNoPoint) return;
    const bool front = i < count;
    direct[i] = direct_irradiance(bits.vertices[vertex], front ? point.normal : -point.normal, cells) *
                bits.transmittance[vertex][front ? 0 : 1];
    if (!links.lamps.empty()) direct[i] += links.lamps[i];
  });
  const auto gather = [&](std::size_t slot, const std::vector<glm::vec3>& irradiance) {
    glm::vec3 sum(0.0f);
    for (std::size_t r = slot * rays; r < (slot + 1) * rays; ++r)
      if (links.links[r].target != kNoPoint)
        sum += unpack_color(links.links[r].color) * irradiance[links.links[r].target];
    return sum / static_cast<float>(links.rays);
  };
  std::vector<glm::vec3> irradiance = direct, next(slots);
  for (int bounce = 0; bounce < kMaxBounces && !cancel; ++bounce) {
    for_slots(slots, cancel, [&](std::size_t i) { next[i] = direct[i] + gather(i, irradiance); });
    double change = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < slots; ++i) {
      change += static_cast<double>(largest(glm::abs(next[i] - irradiance[i])));
      sum += static_cast<double>(largest(next[i]));
    }
    irradiance.swap(next);
    if (change <= static_cast<double>(kEnough) * sum) break;
  }
  std::vector<IndirectRadiance> radiance(slots);
  std::vector<glm::vec3> pattern;
  for (int r = 0; r < links.rays; ++r) pattern.push_back(indirect_ray_direction(r, links.rays));
  for_slots(slots, cancel, [&](std::size_t slot) {
    const std::size_t index = slot % count;
    const IndirectFrame frame = indirect_frame(links.points.points[index], index, slot < count ? 0 : 1);
    glm::vec3 mean(0.0f), along(0.0f), across(0.0f);
    for (std::size_t r = 0; r < rays; ++r) {
      const IndirectLink& link = links.links[slot * rays + r];
      if (link.target == kNoPoint) continue;
      const glm::vec3 l = unpack_color(link.color) * irradiance[link.target] * std::numbers::inv_pi_v<float>;
      mean += l;
      along += l * pattern[r].x;
      across += l * pattern[r].y;
    }
    // The cosine-weighted mean of x^2 is 1/4.
    const float scale = 1.0f / static_cast<float>(links.rays);
    radiance[slot].mean = mean * scale;
    for (int c = 0; c < 3; ++c) radiance[slot].gradient[c] = 4.0f * scale * (along[c] * frame.t + across[c] * frame.b);
  });
  for (int round = 0; round < kSmoothingRounds && !cancel; ++round) smooth(links, &radiance);
  if (cancel) return std::nullopt;
  return radiance;
}

IndirectBake pack_indirect(const IndirectLinks& links, const std::vector<IndirectRadiance>& radiance) {
  IndirectBake bake;
  bake.sides = links.sides;
  float peak = 0.0f;
  for (const IndirectRadiance& r : radiance) peak = std::max(peak, largest(r.mean));
  // The largest value just fits: 31 is the top exponent, of steps of 2^(31 - bias).
  bake.bias = peak > 0.0f ? std::clamp(31 + 8 - std::ilogb(peak), -80, 120) : 0;
  const std::size_t count = links.points.points.size(), vertices = links.points.point_of_vertex.size();
  bake.vertices.assign(vertices * static_cast<std::size_t>(links.sides), glm::uvec4(0u));
  for (std::size_t i = 0; i < bake.vertices.size(); ++i) {
    const std::uint32_t point = links.points.point_of_vertex[i % vertices];
    if (point == kNoPoint) continue;
    const IndirectRadiance& r = radiance[point + (i < vertices ? 0 : count)];
    bake.vertices[i] = shared::pack_indirect(r.mean, r.gradient[0], r.gradient[1], r.gradient[2], bake.bias);
  }
  return bake;
}

}  // namespace maquette
