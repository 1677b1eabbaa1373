#include "render/prt/store.h"

#include <algorithm>
#include <chrono>

#include "render/frame/plan.h"
#include "render/frame/request.h"
#include "render/parts/baked_parts.h"
#include "render/scene_state/scene_state.h"

namespace maquette {

namespace {

Key key_of(const SceneState& scene, const FrameRequest& request, const std::vector<bool>& nodes) {
  const Revisions& r = scene.revisions();
  Key key = Key::of(r.geometry, r.occlusion, r.surfaces, r.tables, request.variant, nodes);
  for (const auto& [name, value] : request.settings.changed()) {
    if (!name.starts_with("prt.") || name == "prt.coefficients" || name == "prt.run") continue;
    key.add(name);
    key.add(to_text(value));
  }
  return key;
}

TransferInput make_input(const SceneState& scene, const FrameRequest& request, const std::vector<bool>& nodes) {
  return {std::make_shared<Scene>(scene.edited_scene()), std::make_shared<const FlatGeometry>(scene.geometry()),
          request.variant, nodes, request.settings};
}

}  // namespace

Baked<Transfer> TransferKind::run(const TransferInput& input, const Baked<Transfer>&, const BakeTask<Transfer>& task) {
  TransferJob job = make_transfer_job(input, {}, &memory_.library, &task.cancel);
  job.preview = task.publish;
  const auto transfer = bake_transfer(job, {}, memory_.bake, task.cancel, task.progress);
  if (transfer) memory_.bake = transfer->bake;
  return {transfer, transfer != nullptr, true};
}

bool TransferStore::update(const SceneState& scene, const FrameRequest& request, const ShadingPlan& layer) {
  const std::vector<bool> nodes = nodes_of_layer(scene.scene(), request, layer);
  held_ = request.settings.get_string("prt.run") == "hold";
  wanted_ = key_of(scene, request, nodes);
  if (held_ && busy()) cancel();
  if (!held_) {
    begun_ = wanted_;
    require(*wanted_, [&] { return make_input(scene, request, nodes); });
  }
  bool changed = false;
  if (const std::shared_ptr<const Transfer> made = take()) {
    buffers_.reset();
    buffers_.emplace(*made, scene.geometry().indices.size() / 3);
    if (!transfer_ || transfer_->bake != made->bake) importance_ = made->bake->table.importance();
    transfer_ = made;
    shown_ = digits_of_ = begun_;
    digits_ = made->key;
    cube_.emplace(made->bake->options.faces);
    light_of_.reset();
    changed = true;
  }
  return (buffers_ && scene.has_environment() && update_light(scene, request)) || changed;
}

std::string TransferStore::key(const SceneState& scene, const FrameRequest& request, const ShadingPlan& layer) {
  const std::vector<bool> nodes = nodes_of_layer(scene.scene(), request, layer);
  const Key now = key_of(scene, request, nodes);
  if (digits_of_ != now) {
    MeasuredLibrary library;
    digits_ = make_transfer_job(make_input(scene, request, nodes), {}, &library).key;
  }
  digits_of_ = now;
  return digits_;
}

bool TransferStore::is_kept(const std::string& key, const std::string& scene, const Settings& settings) const {
  return is_whole_transfer(transfer_folder(settings.get_string("prt.bake"), scene, key));
}

bool TransferStore::update_light(const SceneState& scene, const FrameRequest& request) {
  const Key pyramid = Key::of(scene.revisions().sky);
  if (pyramid_of_ != pyramid) {
    pyramid_ = CubePyramid(scene.environment().environment());
    pyramid_of_ = pyramid;
    light_of_.reset();
  }
  const int coefficients = request.settings.get_int("prt.coefficients");
  const Key light = Key::of(request.env_rotation_rad, coefficients);
  if (light_of_ == light) return false;
  light_of_ = light;
  const auto begin = std::chrono::steady_clock::now();
  const glm::dmat3 environment_from_baked =
      environment_rotation(static_cast<double>(request.env_rotation_rad)) * glm::transpose(transfer_->baked_from_world);
  const CubeLight haar = haar_light(pyramid_, *cube_, environment_from_baked);
  KeptLight kept = choose_coefficients(haar, importance_, static_cast<std::size_t>(6 * coefficients));
  const double left_out = light_left_out(haar, kept, importance_);
  transfer_->bake->table.sums(kept, &sums_);
  buffers_->set_sums(sums_);
  light_ = {std::move(kept), left_out,
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count()};
  return true;
}

std::vector<std::string> TransferStore::notes() const {
  std::vector<std::string> notes;
  if (!transfer_) return notes;
  notes = transfer_->left_out;
  if (!transfer_->stale.empty()) notes.push_back("the radiance transfer is stale: " + transfer_->stale);
  if (held_ && shown_ != wanted_)
    notes.push_back(
        "the radiance transfer is stale: the scene or its settings changed since it was baked; bake it again "
        "(prt.run=auto)");
  return notes;
}

std::function<glm::vec3(const glm::dvec3&)> TransferStore::kept_sky() const {
  const int side = cube_->side();
  return [side, light = light_of_coefficients(light_.kept, side),
          cube_from_world = transfer_->baked_from_world](const glm::dvec3& direction) {
    const CubePoint p = cube_point(cube_from_world * direction);
    const auto texel = [&](double u) { return std::clamp(static_cast<int>(0.5 * (u + 1.0) * side), 0, side - 1); };
    const Eigen::Index i = (p.face * side + texel(p.v)) * side + texel(p.u);
    return glm::vec3(light(i, 0), light(i, 1), light(i, 2));
  };
}

}  // namespace maquette
