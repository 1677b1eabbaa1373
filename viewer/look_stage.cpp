#include "viewer/look_stage.h"

#include <cmath>
#include <cstdio>

#include "render/picture/tonemap.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/node_paths.h"
#include "viewer/bake_lines.h"
#include "viewer/btf_preparation.h"
#include "viewer/dents.h"
#include "viewer/print.h"

namespace maquette {

namespace {

constexpr int kMeterWidth = 160, kMeterHeight = 90;

/// The part of a look for which a renderer is made anew.
Look fixed_part(Look look) {
  look.name.clear();
  look.note.clear();
  look.camera = CameraView();
  look.edits.env_scale = 1.0f;
  if (look.settings.get_string("ground.kind") == "none") {
    look.edits.env_rotation_deg = 0.0f;
    look.edits.turns.clear();
  }
  look.edits.animation = {};
  look.auto_exposure = true;
  look.exposure_ev = 0.0f;
  look.tonemap.clear();
  return look;
}

void hide(Renderer* renderer, const Scene& scene, const std::set<std::string>& hidden) {
  const std::set<int> named = called_nodes(scene, hidden);
  for (int i = 0; i < static_cast<int>(scene.nodes.size()); ++i)
    for (int above = i; above >= 0; above = scene.nodes[static_cast<std::size_t>(above)].parent)
      if (named.contains(above)) {
        renderer->set_node_visible(i, false);
        break;
      }
}

}  // namespace

std::shared_ptr<const Environment> LookStage::environment(const std::string& source) {
  std::shared_ptr<const Environment>& kept = environments_[source];
  if (!kept) {
    kept = std::make_shared<const Environment>(load_environment(source));
    print_warnings(kept->name, kept->warnings);
  }
  return kept;
}

void LookStage::show(const Look& look) {
  const Look fixed = fixed_part(look);
  const Edits& edits = look.edits;
  if (shown_ && *shown_ == fixed && animation_ == edits.animation && turns_ == edits.turns) return;
  if (shown_ && *shown_ == fixed && move(edits)) return;
  shown_.reset();
  renderer_.reset();  // one at a time is in memory
  prepare(look);
  shown_ = fixed;
  animation_ = edits.animation;
  turns_ = edits.turns;
}

bool LookStage::move(const Edits& edits) {
  auto moved = std::make_shared<Scene>(*drawn_);
  pose_nodes(moved.get(), rest_, edits);
  if (!renderer_->move_nodes(moved)) return false;
  drawn_ = std::move(moved);
  animation_ = edits.animation;
  turns_ = edits.turns;
  return true;
}

void LookStage::prepare(const Look& look) {
  const Edits& edits = look.edits;
  std::shared_ptr<const Scene> scene = scene_;
  if (!edits.dents.empty() || !edits.turns.empty()) {
    auto edited = std::make_shared<Scene>(*scene_);
    press_dents(edited.get(), edits.dents);
    Edits turned = edits;
    turned.animation = {};  // the ground does not move with it
    pose_nodes(edited.get(), rest_, turned);
    scene = std::move(edited);
  }
  const std::shared_ptr<const Environment> light = environment(edits.environment);
  drawn_ = with_ground(scene, *light, look.settings, radians(edits.env_rotation_deg));
  if (!edits.animation.name.empty()) {
    auto moved = std::make_shared<Scene>(*drawn_);
    pose_nodes(moved.get(), rest_, edits);
    drawn_ = std::move(moved);
  }
  for (const auto& [name, source] : edits.materials) {
    check_material_name(*drawn_, name);
    prepare_btf(source);
  }
  find_variant(*drawn_, edits.variant);
  renderer_ = std::make_unique<Renderer>();
  renderer_->set_scene(drawn_);
  renderer_->set_environment(light);
  for (const auto& [name, source] : edits.materials) renderer_->set_material(name, source);
  hide(renderer_.get(), *drawn_, edits.hidden_nodes);
}

FrameStats LookStage::render(const Look& look, const SettledFrame& settled) {
  show(look);
  request_ = make_request(*drawn_, look, settled.size);
  request_.settings.set("shading.reuse", false);
  request_.single = settled.frames <= 1;
  renderer_->forget_frames();
  renderer_->finish_background_work(request_);
  FrameStats stats;
  for (int i = 0; i < std::max(settled.frames, 1); ++i) {
    if (progress_ && i > 0) progress_(static_cast<double>(i) / settled.frames);
    stats = renderer_->render(request_, true);
  }
  warn_of_frame_bakes(stats.status, &told_);
  return stats;
}

std::string LookStage::bake_key(const Look& look, const std::string& bake) {
  show(look);
  return renderer_->bake_key(make_request(*drawn_, look, FrameSize()), bake);
}

float LookStage::suited_exposure_ev(const Look& look) {
  const float scale = look.edits.env_scale;
  return scale > 0.0f ? suggest_exposure_ev(*environment(look.edits.environment)) - std::log2(scale) : 0.0f;
}

float LookStage::exposure_ev(const Look& look) {
  if (!look.auto_exposure) return look.exposure_ev;
  SettledFrame small;
  small.size.width = kMeterWidth;
  small.size.height = kMeterHeight;
  render(look, small);
  return meter_exposure_ev(renderer_->read_radiance(), suited_exposure_ev(look));
}

}  // namespace maquette
