#include "render/reflections/pane_tint.h"

#include <tbb/parallel_for.h>

#include <glm/gtc/packing.hpp>

#include "render/reference/traversal.h"
#include "render/views/read_texture.h"

namespace maquette {

namespace {

/// Rays end before what they hit.
constexpr float kBeforeHit = 0.9999f;
/// Surfaces count from here on, m, as for the rays themselves.
constexpr float kNear_m = 1e-4f;

glm::vec3 tint_of(const PathScene& scene, const Ray& ray, const TriangleRange& own) {
  RayPassage passage;
  if (!find_passage(scene, ray, &passage)) return glm::vec3(1.0f);
  std::uint32_t kept = 0;
  for (std::uint32_t k = 0; k < passage.pane_count; ++k) {
    const std::uint32_t source = scene.triangles[passage.panes[k].triangle].source;
    if (source < own.begin || source >= own.end) passage.panes[kept++] = passage.panes[k];
  }
  passage.pane_count = kept;
  return transmittance(scene, ray.direction, passage);
}

}  // namespace

void find_pane_tint(const PathScene& scene, const std::vector<TriangleRange>& own, ReflectionTargets* targets) {
  ReflectionTargets& t = *targets;
  const auto origins = read_texture<float>(t.ray_origin, GL_RGBA, GL_FLOAT, 4);
  const auto directions = read_texture<float>(t.ray_direction, GL_RGBA, GL_FLOAT, 4);
  const auto along_m = read_texture<float>(t.depth, GL_RED, GL_FLOAT, 1);
  std::vector<std::uint64_t> tint(along_m.size(), glm::packUnorm4x16(glm::vec4(1.0f)));
  const auto width = static_cast<std::size_t>(t.width);
  tbb::parallel_for(std::size_t{0}, tint.size() / width, [&](std::size_t y) {
    for (std::size_t i = y * width; i < (y + 1) * width; ++i) {
      if (!(directions[4 * i + 3] > 0.0f)) continue;
      const auto reflector = static_cast<std::size_t>(directions[4 * i + 3] - 0.5f);
      const Ray ray{{origins[4 * i], origins[4 * i + 1], origins[4 * i + 2]},
                    {directions[4 * i], directions[4 * i + 1], directions[4 * i + 2]},
                    kNear_m,
                    along_m[i] > 0.0f ? along_m[i] * kBeforeHit : Ray().far};
      const glm::vec3 share = tint_of(scene, ray, reflector < own.size() ? own[reflector] : TriangleRange());
      tint[i] = glm::packUnorm4x16(glm::vec4(share, 1.0f));
    }
  });
  t.tint.upload(0, t.width, t.height, GL_RGBA, GL_UNSIGNED_SHORT, tint.data());
}

}  // namespace maquette
