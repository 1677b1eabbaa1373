// What a window adds to the scene it was given, and what it advises about it.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <utility>

#include "render/btf/btf_source.h"
#include "scenes/angles.h"
#include "scenes/files.h"
#include "scenes/ground.h"
#include "scenes/node_paths.h"
#include "scenes/scene_files.h"
#include "viewer/reflector_picking.h"
#include "viewer/session.h"
#include "viewer/window_session.h"

namespace maquette {

void WindowSession::forget_applied() {
  applied_.materials.clear();
  applied_.dents.clear();
  applied_.hidden_nodes.clear();
  applied_.animation = {};
  applied_.turns.clear();
  surfaces_.reset();
  ground_of_ = {};
  ground_rotation_deg_ = 0.0f;
}

std::shared_ptr<const Scene> WindowSession::at_rest() const {
  if (!is_posed(applied_)) return scene_;
  auto rest = std::make_shared<Scene>(*scene_);
  pose_nodes(rest.get(), rest_, {});
  return rest;
}

void WindowSession::apply_pose() {
  auto posed = std::make_shared<Scene>(*scene_);
  pose_nodes(posed.get(), rest_, state.edits);
  const bool moved = renderer_.move_nodes(posed);
  if (!moved) renderer_.set_scene(posed);
  scene_ = std::move(posed);
  if (!moved) forget_applied();
  surfaces_.reset();
  applied_.dents.clear();  // the renderer has the meshes of the file again
  applied_.animation = state.edits.animation;
  applied_.turns = state.edits.turns;
  ++revision_;
}

/// Twice the same new time: who writes it has finished.
bool WindowSession::has_changed(const std::string& source, std::uint64_t stamp) {
  if (stamp == 0) return false;
  const auto [known, is_new] = watched_.try_emplace(source, Watched{stamp, stamp});
  Watched& watched = known->second;
  const bool rests = std::exchange(watched.seen, stamp) == stamp;
  if (is_new || !rests || stamp == watched.used) return false;
  watched.used = stamp;
  return true;
}

bool WindowSession::has_changed(const std::string& file) { return has_changed(file, file_stamp(file)); }

/// The file, or one that it names.
bool WindowSession::scene_has_changed(const std::string& scene) {
  bool changed = has_changed(scene);
  if (changed || files_of_ != scene) scene_files_ = scene_files(scene);
  files_of_ = scene;
  for (const std::string& file : scene_files_) changed = has_changed(file) || changed;
  return changed;
}

void WindowSession::watch_files(double now_s) {
  constexpr double kInterval_s = 1.0;
  if (now_s - watched_s_ < kInterval_s || loading() || opening_) return;
  watched_s_ = now_s;
  const std::string& scene = scene_->name;
  if (!scene.starts_with("builtin:") && scene_has_changed(scene)) {
    reading_again_ = true;
    scene_source_ = scene;
    scene_file_ = std::async(std::launch::async, [scene, of_file = scene_of_file_] {
      return std::make_shared<Scene>(load_scene(scene, of_file));
    });
    add_message(MessageLevel::note, scene + " has changed: it is read again");
  }
  if (!applied_.environment.starts_with("builtin:") && has_changed(applied_.environment)) {
    add_message(MessageLevel::note, applied_.environment + " has changed: it is read again");
    applied_.environment.clear();
    known_bakes_.forget();
  }
  for (const auto& [name, source] : std::map(applied_.materials)) {
    if (!has_changed(source, material_source_stamp(source))) continue;
    add_message(MessageLevel::note, source + " has changed: it is read again");
    applied_.materials.erase(name);
    known_bakes_.forget();
  }
}

void WindowSession::apply_ground(bool busy) {
  if (!environment_) return;  // still being read
  const Settings& settings = state.settings;
  GroundOf wanted{environment_, settings.get_string("ground.kind"), settings.get_double("ground.height"),
                  settings.get_double("ground.roughness")};
  const bool want = wanted.kind != "none";
  if (!want) wanted = {};
  if (!(ground_of_ == wanted)) {
    // The ground is the last of everything: what names parts by number stays true.
    auto scene = std::make_shared<Scene>(*scene_);
    remove_ground(scene.get());
    Edits turned = state.edits;
    turned.animation = {};  // the ground does not move with it
    pose_nodes(scene.get(), rest_, turned);
    if (want) add_ground(scene.get(), *environment_, ground_options(settings));
    renderer_.set_scene(scene);
    scene_ = std::move(scene);
    node_paths_ = node_paths(*scene_);
    dragged_dent_.reset();
    forget_applied();
    applied_.turns = state.edits.turns;
    ground_of_ = wanted;
    request_metering();
    ++revision_;
  }
  // While it is turned, the light alone follows: the ground's own light is found anew once it rests.
  if (!want || busy || ground_rotation_deg_ == state.edits.env_rotation_deg) return;
  ground_rotation_deg_ = state.edits.env_rotation_deg;
  renderer_.set_texture_offset(kGroundName, ground_texture_offset(radians(ground_rotation_deg_)));
  ++revision_;
}

void WindowSession::add_message(MessageLevel level, const std::string& text) {
  constexpr std::size_t kMost = 200;
  if (messages_.size() >= kMost) messages_.erase(messages_.begin());
  messages_.push_back({level, text, true});
}

void WindowSession::dismiss_message(int index) {
  if (index >= 0 && index < static_cast<int>(messages_.size()))
    messages_[static_cast<std::size_t>(index)].unread = false;
}

void WindowSession::dismiss_messages() {
  for (Message& message : messages_) message.unread = false;
}

void WindowSession::set_advice(Message advice) {
  const auto same = [&](const Message& message) { return message.topic == advice.topic; };
  const auto known = std::find_if(messages_.begin(), messages_.end(), same);
  if (known != messages_.end() && known->text == advice.text) return;
  std::erase_if(messages_, same);
  if (!advice.text.empty()) messages_.push_back(std::move(advice));
}

void WindowSession::advise() {
  if (!environment_) return;  // still being read
  float scale = 1.0f;
  std::string units = units_warning(*scene_, *environment_, state.edits.env_scale, "an Intensity of", &scale);
  if (!units.empty()) units = environment_->name + ": " + units;
  char label[64];
  std::snprintf(label, sizeof label, "Intensity %.4g", static_cast<double>(scale));
  set_advice({MessageLevel::warning, units, true, "units", label,
              [scale](EditorState* editor) { editor->edits.env_scale = scale; }});
  std::string gloss = state.edits.materials.empty() ? gloss_warning(*scene_) : "";
  if (scene_->name.starts_with("builtin:")) gloss.clear();
  if (!gloss.empty()) gloss = std::filesystem::path(scene_->name).filename().string() + ": " + gloss;
  set_advice({MessageLevel::warning, gloss, true, "gloss", "Open the library", [](EditorState* editor) {
                editor->left_open = true;
                editor->left_tab = 0;
              }});
}

void WindowSession::select(const Renderer::Pick& pick) {
  if (!pick.hit) return;
  state.selected_node = state.reveal_node = pick.node;
  if (pick.material >= 0 && pick.material < static_cast<int>(scene_->materials.size())) {
    state.selected_material = pick.material;
    state.reveal_material = true;
  }
}

void WindowSession::pick_reflector(const glm::vec2& at, float aspect, const Renderer::Pick& pick) {
  const CameraFrame camera = make_camera_frame(state.camera, 1, 1, bounds_);
  const EyeRay through = camera.ray_through({at.x * aspect, at.y});
  const glm::vec3 &eye = through.origin, ray = glm::normalize(through.direction);
  // A mirror that is not a reflector yet is itself the opaque surface at this point.
  const float limit_m = pick.hit ? 1.001f * glm::distance(pick.position, eye) : 1e30f;
  const int node = find_mirror(*scene_, state.edits, eye, ray, limit_m);
  if (node < 0)
    add_message(MessageLevel::warning, "Reflectors: nothing mirrors here; panes and smooth metals do");
  else if (scene_->nodes[static_cast<std::size_t>(node)].name.empty())
    add_message(MessageLevel::warning,
                "Reflectors: this part has no name in the file, by which it could be told apart");
  else if (!toggle_reflector(*scene_, node, &state.edits))
    add_message(MessageLevel::warning, "Reflectors: the last one stays; choose Reflections off to draw none");
  else
    state.selected_node = state.reveal_node = node;
}

void WindowSession::select_in_front(const glm::vec2& at, float aspect, const Renderer::Pick& pick) {
  const CameraFrame camera = make_camera_frame(state.camera, 1, 1, bounds_);
  const EyeRay through = camera.ray_through({at.x * aspect, at.y});
  const float limit_m = pick.hit ? 0.999f * glm::distance(pick.position, through.origin) : 1e30f;
  const int node = find_mirror(*scene_, state.edits, through.origin, glm::normalize(through.direction), limit_m);
  if (node < 0 || node == state.selected_node) return select(pick);
  const Node& front = scene_->nodes[static_cast<std::size_t>(node)];
  Renderer::Pick pane;
  pane.hit = true;
  pane.node = node;
  if (front.patch >= 0)
    pane.material = scene_->patches[static_cast<std::size_t>(front.patch)].material;
  else
    pane.material = material_of(scene_->meshes[static_cast<std::size_t>(front.mesh)].primitives.front(),
                                variant_index(*scene_, state.edits.variant));
  select(pane);
}

}  // namespace maquette
