#pragma once

#include <memory>

#include "render/bake/bake_runner.h"
#include "render/frame/key.h"
#include "render/reference/reference.h"
#include "render/scene_state/scene_state.h"

namespace maquette {

struct ShadowSceneJob {
  Scene scene;  ///< as edited
  FlatGeometry geometry;
  int variant = -1;
};

struct ShadowGeometry {
  std::shared_ptr<const PathScene> scene;
  /// Share of the sky, weighted by the cosine, that opaque surfaces hide from points of the scene's parts; each part
  /// counts the same, however large it is. By a few thousand rays.
  double hidden_share = 0.0;
};

/// The path tracer's scene without its tables of light and measured materials: what shadow rays need. Panes, cut-outs
/// and coverage count in it as in mode `reference`.
class ShadowScene final : public KeyedBake<Key, ShadowSceneJob, ShadowGeometry> {
 public:
  ShadowScene();
  const char* name() const override { return "shadow_rays"; }
  /// Starts to build it when the surfaces have changed, and takes over what is there; the old one stays until then.
  /// True when it is another. Throws what made it fail, once.
  bool update(const SceneState& scene, int variant);
  /// Forgets it: another scene.
  void clear();
  /// Null while there is none.
  const std::shared_ptr<const PathScene>& scene() const { return built_.scene; }
  std::optional<double> hidden_share() const { return ready() ? std::optional(built_.hidden_share) : std::nullopt; }
  bool ready() const override { return static_cast<bool>(built_.scene); }
  std::size_t bytes() const override;

 private:
  ShadowGeometry built_;
};

}  // namespace maquette
