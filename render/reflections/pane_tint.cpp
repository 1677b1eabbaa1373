#include "render/reflections/pane_tint.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <glm/gtc/packing.hpp>

#include "render/reference/surface.h"
#include "render/reference/traversal.h"
#include "render/views/read_texture.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Rays end before what they hit.
constexpr float kBeforeHit = 0.9999f;
/// Surfaces count from here on, m, as for the rays themselves.
constexpr float kPaneNear_m = 1e-4f;
/// What covers less is not shaded.
constexpr float kLeastShare = 1e-3f;

/// Light that comes through one surface, and the share of it that is seen of the surface itself: nothing of panes.
struct Crossing {
  glm::vec3 passes{1.0f};
  float alpha = 0.0f;
};

Crossing crossing_of(const PathScene& scene, const glm::vec3& direction, const RayHit& hit) {
  const TracedMaterial& m = scene.material_of(hit.triangle);
  const float alpha = m.blended ? alpha_at(scene, hit.triangle, hit.barycentric) : 1.0f;
  Crossing out{glm::vec3(1.0f - alpha), alpha};
  if (!m.values.glass) return out;
  out.passes += alpha * pane_transmittance(scene, hit.triangle, hit.barycentric, direction);
  out.alpha = 0.0f;
  return out;
}

/// What remains of the hit's light. Adds the blended surfaces on the way to `layers`; null: they are passed over.
glm::vec3 cross_all(const PathScene& scene, const glm::vec3& direction, const std::vector<RayHit>& hits,
                    const TriangleRange& own, std::vector<MirroredLayer>* layers) {
  glm::vec3 through(1.0f);
  for (const RayHit& hit : hits) {
    const std::uint32_t source = scene.triangles[hit.triangle].source;
    if (source >= own.begin && source < own.end) continue;
    if (!layers && !scene.material_of(hit.triangle).values.glass) continue;
    const Crossing crossing = crossing_of(scene, direction, hit);
    if (layers && crossing.alpha > kLeastShare) {
      if (layers->size() < static_cast<std::size_t>(kMostMirroredLayers))
        layers->push_back({0, source, through * crossing.alpha});
      else
        layers->back().share += through * crossing.alpha;
    }
    through *= crossing.passes;
  }
  return through;
}

}  // namespace

void find_pane_tint(const PathScene& scene, const std::vector<TriangleRange>& own, ReflectionTargets* targets,
                    MirroredLayers* layers) {
  ReflectionTargets& t = *targets;
  const auto origins = read_texture<float>(t.ray_origin, GL_RGBA, GL_FLOAT, 4);
  const auto directions = read_texture<float>(t.ray_direction, GL_RGBA, GL_FLOAT, 4);
  const auto along_m = read_texture<float>(t.depth, GL_RED, GL_FLOAT, 1);
  std::vector<std::uint64_t> tint(along_m.size(), glm::packUnorm4x16(glm::vec4(1.0f)));
  const auto width = static_cast<std::size_t>(t.width), height = tint.size() / width;
  std::vector<MirroredLayers> rows(layers ? height : 0);
  struct Scratch {
    std::vector<RayHit> hits;
    std::vector<MirroredLayer> along;
  };
  tbb::enumerable_thread_specific<Scratch> scratch;
  parallel_for(std::size_t{0}, height, [&](std::size_t y) {
    Scratch& s = scratch.local();
    for (std::size_t i = y * width; i < (y + 1) * width; ++i) {
      if (!(directions[4 * i + 3] > 0.0f)) continue;
      const auto reflector = static_cast<std::size_t>(directions[4 * i + 3] - 0.5f);
      const Ray ray{{origins[4 * i], origins[4 * i + 1], origins[4 * i + 2]},
                    {directions[4 * i], directions[4 * i + 1], directions[4 * i + 2]},
                    kPaneNear_m,
                    along_m[i] > 0.0f ? along_m[i] * kBeforeHit : Ray().far};
      find_transparent(scene, ray, &s.hits);
      s.along.clear();
      const glm::vec3 share =
          cross_all(scene, ray.direction, s.hits, reflector < own.size() ? own[reflector] : TriangleRange(),
                    layers ? &s.along : nullptr);
      tint[i] = glm::packUnorm4x16(glm::vec4(share, 1.0f));
      for (std::size_t k = 0; k < s.along.size(); ++k) {
        s.along[k].pixel = static_cast<std::uint32_t>(i);
        rows[y][k].push_back(s.along[k]);
      }
    }
  });
  t.tint.upload(0, t.width, t.height, GL_RGBA, GL_UNSIGNED_SHORT, tint.data());
  if (!layers) return;
  *layers = {};
  for (const MirroredLayers& row : rows)
    for (std::size_t k = 0; k < row.size(); ++k) (*layers)[k].insert((*layers)[k].end(), row[k].begin(), row[k].end());
}

}  // namespace maquette
