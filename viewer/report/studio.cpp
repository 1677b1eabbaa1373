#include "viewer/report/studio.h"

#include <cstdio>
#include <map>

#include "render/btf/btf_source.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/angles.h"
#include "scenes/files.h"
#include "ui/camera_control.h"
#include "viewer/btf_preparation.h"
#include "viewer/budget_curve.h"
#include "viewer/print.h"
#include "viewer/session.h"

namespace maquette::report {

Studio::Studio(const SceneOptions& options)
    : options_(options),
      environment_(std::make_shared<const Environment>(load_environment(options.environment))),
      scene_(
          with_ground(load_session_scene(options), *environment_, options.settings, radians(options.env_rotation_deg))),
      context_(GlContext::create_headless()),
      device_(query_device()),
      renderer_(std::make_unique<Renderer>()),
      key_(scene_key(*scene_)) {
  print_warnings("", scene_->warnings);
  print_warnings("", environment_->warnings);
  prepare_btfs(options, *scene_);
  renderer_->set_scene(scene_);
  renderer_->set_environment(environment_);
  for (const auto& [name, source] : options.materials) {
    renderer_->set_material(name, source);
    key_.mix(name).mix(source);
    if (!source.starts_with("builtin:")) key_.mix(std::to_string(material_source_key(source)));
  }
  const std::uint64_t environment_hash = environment_->hash;
  key_.mix_bytes(std::as_bytes(std::span(&environment_hash, 1)));
}

Scene Studio::overridden_scene() const {
  Scene scene = *scene_;
  const std::map<std::string, std::string> sources(options_.materials.begin(), options_.materials.end());
  scene.materials = effective_materials(scene, sources);
  return scene;
}

std::uint64_t Studio::appearance_key() const { return curves_key(overridden_scene(), *environment_); }

const std::shared_ptr<const PathScene>& Studio::path_scene() {
  if (path_scene_) return path_scene_;
  const Scene scene = overridden_scene();
  path_scene_ = build_path_scene({scene, environment_, find_variant(*scene_, options_.variant), nullptr, nullptr});
  return path_scene_;
}

FrameRequest Studio::request(const SweptCamera& camera) const {
  FrameRequest request = make_request(*scene_, options_);
  request.camera = camera.view;
  fit_aspect(&request.camera, static_cast<float>(request.width) / static_cast<float>(request.height));
  return request;
}

}  // namespace maquette::report
