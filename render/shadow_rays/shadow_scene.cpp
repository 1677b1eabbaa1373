#include "render/shadow_rays/shadow_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "render/math/shared_formulas.h"
#include "render/reference/path_scene.h"
#include "render/reference/traversal.h"

namespace maquette {

namespace {

constexpr std::size_t kHiddenRays = 4096;

/// Uniform in [0, 1).
float unit(std::mt19937* random) { return static_cast<float>((*random)() >> 8) * 0x1p-24f; }

/// From a random point of a triangle, on its front, in a direction that is distributed as the cosine.
Ray ray_from(const FlatGeometry& geometry, std::uint32_t triangle, std::mt19937* random) {
  const std::uint32_t* corners = &geometry.indices[3 * static_cast<std::size_t>(triangle)];
  const glm::vec3 a = geometry.positions[corners[0]], e1 = geometry.positions[corners[1]] - a,
                  e2 = geometry.positions[corners[2]] - a, across = glm::cross(e1, e2);
  const float root = std::sqrt(unit(random)), share = unit(random), height = std::sqrt(unit(random)),
              angle = 2.0f * std::numbers::pi_v<float> * unit(random), area2 = glm::length(across);
  const glm::vec3 n = area2 > 0.0f ? across / area2 : glm::vec3(0.0f, 1.0f, 0.0f);
  const shared::TangentBasis basis = shared::tangent_basis(n);
  const float flat = std::sqrt(1.0f - height * height), near_m = 1e-4f * std::sqrt(area2);
  return {a + e1 * (root * (1.0f - share)) + e2 * (root * share) + n * near_m,
          n * height + flat * (basis.t * std::cos(angle) + basis.b * std::sin(angle)), near_m};
}

double hidden_share_of(const PathScene& scene, const FlatGeometry& geometry) {
  const std::size_t items = geometry.items.size();
  const std::size_t rays = kHiddenRays / std::max<std::size_t>(items, 1) + 1, stride = items / kHiddenRays + 1;
  std::mt19937 random(1);
  double hidden = 0.0, parts = 0.0;
  for (std::size_t i = 0; i < items; i += stride) {
    const DrawItem& item = geometry.items[i];
    if (item.index_count == 0) continue;
    std::size_t blocked = 0;
    for (std::size_t k = 0; k < rays; ++k) {
      const auto triangle = static_cast<std::uint32_t>(random() % (item.index_count / 3));
      blocked += transmittance(scene, ray_from(geometry, item.first_index / 3 + triangle, &random)) == glm::vec3(0.0f);
    }
    hidden += static_cast<double>(blocked) / static_cast<double>(rays);
    parts += 1.0;
  }
  return hidden / std::max(parts, 1.0);
}

class ShadowSceneKind final : public BakeKind<ShadowSceneJob, ShadowGeometry> {
 public:
  Baked<ShadowGeometry> run(const ShadowSceneJob& job, const Baked<ShadowGeometry>&,
                            const BakeTask<ShadowGeometry>& task) override {
    auto black = std::make_shared<Environment>();
    black->name = "black";
    black->width = 2;
    black->height = 1;
    black->rgb.assign(2, glm::vec3(0.0f));
    const auto built = build_path_scene(
        {.scene = job.scene, .environment = std::move(black), .variant = job.variant, .geometry = &job.geometry});
    if (task.cancel) return {};
    return {std::make_shared<const ShadowGeometry>(ShadowGeometry{built, hidden_share_of(*built, job.geometry)}), true};
  }
};

}  // namespace

ShadowScene::ShadowScene() : KeyedBake(std::make_shared<ShadowSceneKind>()) {}

bool ShadowScene::update(const SceneState& scene, int variant) {
  require(Key::of(scene.revisions().surfaces, variant), [&] {
    ShadowSceneJob job{scene.edited_scene(), scene.geometry(), variant};
    for (Material& material : job.scene.materials) material.measured.clear();
    return job;
  });
  const auto built = take();
  if (!built) return false;
  built_ = *built;
  return true;
}

void ShadowScene::clear() {
  cancel();
  built_ = {};
}

std::size_t ShadowScene::bytes() const {
  // The hierarchy takes about as much again as the triangles.
  return ready() ? 2 * built_.scene->triangles.size() * sizeof(TracedTriangle) : 0;
}

}  // namespace maquette
