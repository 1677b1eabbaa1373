#include "render/shadow_rays/shadow_scene.h"

#include "render/reference/path_scene.h"

namespace maquette {

namespace {

class ShadowSceneKind final : public BakeKind<ShadowSceneJob, std::shared_ptr<const PathScene>> {
 public:
  Baked<std::shared_ptr<const PathScene>> run(const ShadowSceneJob& job, const Baked<std::shared_ptr<const PathScene>>&,
                                              const BakeTask<std::shared_ptr<const PathScene>>& task) override {
    auto black = std::make_shared<Environment>();
    black->name = "black";
    black->width = 2;
    black->height = 1;
    black->rgb.assign(2, glm::vec3(0.0f));
    const auto built = build_path_scene(
        {.scene = job.scene, .environment = std::move(black), .variant = job.variant, .geometry = &job.geometry});
    if (task.cancel) return {};
    return {std::make_shared<const std::shared_ptr<const PathScene>>(built), true};
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
  scene_ = *built;
  return true;
}

void ShadowScene::clear() {
  cancel();
  scene_.reset();
}

std::size_t ShadowScene::bytes() const {
  // The hierarchy takes about as much again as the triangles.
  return scene_ ? 2 * scene_->triangles.size() * sizeof(TracedTriangle) : 0;
}

}  // namespace maquette
