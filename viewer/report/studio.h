#pragma once

#include <memory>
#include <string>

#include "render/gl/context.h"
#include "render/reference/reference.h"
#include "render/renderer.h"
#include "viewer/options.h"
#include "viewer/report/content_key.h"
#include "viewer/report/sweep.h"

namespace maquette::report {

/// Scene, environment and renderer of one report, with its own context.
class Studio {
 public:
  /// Throws Error (scene, environment, material, graphics).
  explicit Studio(const SceneOptions& options);

  const SceneOptions& options() const { return options_; }
  const DeviceInfo& device() const { return device_; }
  const std::shared_ptr<const Scene>& scene() const { return scene_; }
  const std::shared_ptr<const Environment>& environment() const { return environment_; }
  Renderer& renderer() { return *renderer_; }
  /// The scene with the materials of the options.
  Scene overridden_scene() const;
  /// For rays; built on first use.
  const std::shared_ptr<const PathScene>& path_scene();
  /// Key of the scene, the materials in use and the environment.
  const ContentKey& key() const { return key_; }
  /// Key of the scene's appearance, as the window computes it (curves_key).
  std::uint64_t appearance_key() const;
  /// The request of one frame with the options, seen by `camera`.
  FrameRequest request(const SweptCamera& camera) const;

 private:
  SceneOptions options_;
  std::shared_ptr<const Environment> environment_;
  std::shared_ptr<const Scene> scene_;
  GlContext context_;
  DeviceInfo device_;
  std::unique_ptr<Renderer> renderer_;
  std::shared_ptr<const PathScene> path_scene_;
  ContentKey key_;
};

}  // namespace maquette::report
