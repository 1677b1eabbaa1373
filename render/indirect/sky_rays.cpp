#include "render/indirect/sky_rays.h"

#include <algorithm>
#include <cmath>

#include "render/environment/environment_tables.h"
#include "render/math/shared_formulas.h"
#include "render/reference/path_scene.h"
#include "render/reference/traversal.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr std::size_t kSkyRayBudget = std::size_t{1} << 22;
constexpr std::size_t kLeastRays = 4, kMostRays = 64;
/// Samples of the sky; each point takes a run of them.
constexpr std::size_t kSamples = std::size_t{1} << 14;

/// What the maps' sums count a direction with on either side of a point: in place of visibility times cosine.
glm::vec2 mapped(const std::array<std::uint32_t, 8>& bits, const SkyCells& cells, const glm::vec3& normal,
                 const glm::vec3& direction) {
  const shared::VisibilityCorner corner = shared::visibility_corner(direction);
  const glm::vec4 shares = shared::visibility_shares(corner.fraction);
  glm::vec2 sum(0.0f);
  for (int k = 0; k < 4; ++k) {
    const glm::ivec2 cell = shared::visibility_wrap(corner.lower + glm::ivec2(k & 1, k >> 1));
    const auto bit = static_cast<std::size_t>(cell.y * kVisibilitySide + cell.x);
    if (((bits[bit / 32] >> (bit % 32)) & 1u) == 0) continue;
    const float cosine = glm::dot(normal, cells.direction[bit]);
    sum += shares[k] * glm::vec2(std::max(cosine, 0.0f), std::max(-cosine, 0.0f));
  }
  return sum;
}

/// A direction in the world, and the light that comes from there over its density.
struct SkySample {
  glm::vec3 direction{0.0f}, weight{0.0f};
};

std::vector<SkySample> sample_sky(const IndirectSky& sky) {
  const Environment& e = *sky.environment;
  const EnvironmentTables tables = load_environment_tables(e);
  const PackedSky nodes = pack_sky(e, packing_bias(e), 1);
  const float cosine = std::cos(sky.rotation_rad), sine = std::sin(sky.rotation_rad);
  std::vector<SkySample> samples;
  for (const EnvironmentSample& s : sample_environment(e, tables, nodes, 0, kSamples))
    samples.push_back({shared::latlong_rotate(s.direction, cosine, sine),
                       s.pdf > 0.0f ? sky.scale / s.pdf * s.radiance : glm::vec3(0.0f)});
  return samples;
}

}  // namespace

std::vector<glm::vec3> error_of_maps(const IndirectLinks& links, const VisibilityBake& bits, const IndirectSky& sky,
                                     const SkyCells& cells, const std::atomic<bool>& cancel) {
  const std::size_t count = links.points.points.size(), sides = static_cast<std::size_t>(links.sides);
  std::vector<glm::vec3> error(count * sides, glm::vec3(0.0f));
  if (!links.scene || count == 0) return error;
  const std::vector<SkySample> samples = sample_sky(sky);
  if (samples.empty()) return error;
  const std::size_t rays = std::clamp(kSkyRayBudget / (count * sides), kLeastRays, kMostRays);
  parallel_ranges<std::size_t>(0, count, 64, [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end() && !cancel; ++i) {
      const std::uint32_t vertex = links.vertex_of_point[i];
      if (vertex == kNoPoint) continue;
      const glm::vec3& normal = links.points.points[i].normal;
      const glm::vec3 origins[2] = {indirect_start(links, i, 0).origin, indirect_start(links, i, 1).origin};
      for (std::size_t r = 0; r < rays; ++r) {
        const SkySample& sample = samples[(i * rays + r) % kSamples];
        const float cosine = glm::dot(normal, sample.direction);
        const glm::vec2 by_map =
            mapped(bits.vertices[vertex], cells, normal, sample.direction) * bits.transmittance[vertex];
        for (std::size_t side = 0; side < sides; ++side) {
          glm::vec3 arrives(-by_map[static_cast<glm::length_t>(side)]);
          if (side == (cosine > 0.0f ? 0u : 1u))
            arrives += std::abs(cosine) * transmittance(*links.scene, {origins[side], sample.direction});
          error[side * count + i] += sample.weight * arrives / static_cast<float>(rays);
        }
      }
    }
  });
  return error;
}

}  // namespace maquette
