#include "viewer/window_session.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "render/btf/btf_source.h"
#include "render/frame/camera.h"
#include "render/frame/planning.h"
#include "render/parts/parts.h"
#include "render/picture/tonemap.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/ground.h"
#include "scenes/node_paths.h"
#include "ui/camera_control.h"
#include "viewer/reflector_picking.h"
#include "viewer/rendered_view.h"
#include "viewer/session.h"

namespace maquette {

namespace {

bool contains_name(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void remember(std::vector<std::string>* files, const std::string& source) {
  if (!source.starts_with("builtin:") && !contains_name(*files, source)) files->push_back(source);
}

/// The samples of `--samples` as the setting of the mode, so that the panel shows them.
Settings settings_of(const SceneOptions& options) {
  Settings settings = options.settings;
  std::vector<std::string> modes{options.mode};
  for (const PartMode& part : options.part_modes) modes.push_back(part.mode);
  for (const std::string& mode : modes) {
    const std::string& setting = builtin_registry().find_mode(mode).samples_setting;
    if (options.samples > 0 && !setting.empty()) settings.set(setting, options.samples);
  }
  return settings;
}

/// A file's scene with nothing level below it would float.
bool wants_ground(const Scene& scene) { return !scene.name.starts_with("builtin:") && !has_ground(scene); }

template <typename T>
bool ready(const std::future<T>& file) {
  return file.valid() && file.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

}  // namespace

WindowSession::WindowSession(const SceneOptions& asked) {
  SceneOptions options = asked;
  keeps_journal_ = options.screenshot.empty();
  std::unique_ptr<OpenReview> opened;
  if (!options.review.empty()) {
    opened = std::make_unique<OpenReview>(options.review);
    const Review& review = opened->review();
    options.scene = review.scene;
    options.scene_of_file = review.scene_of_file;
    options.environment = review.look.edits.environment;
    const std::vector<std::string> missing = missing_sources(review);
    if (std::ranges::find(missing, options.environment) != missing.end())
      options.environment = SceneOptions().environment;
  }
  renderer_.set_interactive(true);
  options.environment = absolute_source(options.environment, std::filesystem::current_path().string());
  environment_source_ = options.environment;
  auto environment = std::async(std::launch::async, [source = options.environment] {
    return std::make_shared<Environment>(load_environment(source));
  });
  ScenePointer scene = load_session_scene(without_edits(options));
  scene_of_file_ = options.scene_of_file;
  state.edits.env_scale = options.env_scale;
  use_scene(scene);
  use_environment(environment.get(), options.environment);
  make_request(*scene, options);  // what cannot be drawn is said before the window opens
  seed_ = options.seed;
  state.msaa = options.msaa;
  if (!options.screenshot.empty()) state.still_msaa = options.msaa;  // the same frames however long they take
  state.debug_view = options.debug_view;
  if (opened) {
    begin_review(std::move(opened), options.look);
    return;
  }
  begin_look(options);
  if (keeps_journal_) offer_left_behind();
  review_ = std::make_unique<OpenReview>(review_now(), keeps_journal_);
  report_notes();
}

void WindowSession::begin_look(const SceneOptions& options) {
  static_cast<Look&>(state) = absolute_sources(look_of_options(*scene_, options));
  if (!options.eye && !options.target) set_camera(state.camera);  // WindowPicture adapts it to the picture's size
  state.settings = settings_of(options);
  const bool asked = std::ranges::find(options.settings_given, "ground.kind") != options.settings_given.end();
  if (!asked && !options.settings.changed().contains("ground.kind") && wants_ground(*scene_))
    state.settings.set("ground.kind", std::string("projected"));
  state.edits.env_rotation_deg = wrap_degrees(options.env_rotation_deg);
  state.exposure_ev = exposure_of(options, *environment_);
  applied_.environment = state.edits.environment;
  for (const auto& [name, source] : options.materials) {
    remember(&brdf_files_, source);
    if (is_btf_source(source)) continue;  // the window opens before it is made
    renderer_.set_material(name, source);
    for (const Material& material : scene_->materials)
      if (name == "*" || material.name == name)
        applied_.materials[material.name] = state.edits.materials[material.name];
  }
}

void WindowSession::use_scene(ScenePointer scene) {
  renderer_.set_scene(scene);
  scene_ = std::move(scene);
  rest_ = rest_pose(*scene_);
  bounds_ = framed_bounds(*scene_);
  node_paths_ = node_paths(*scene_);
  dragged_dent_.reset();
  for (const std::string& warning : scene_->warnings)
    add_message(MessageLevel::warning, std::filesystem::path(scene_->name).filename().string() + ": " + warning);
  Edits fresh;  // the light stays as it was
  fresh.environment = state.edits.environment;
  fresh.env_rotation_deg = state.edits.env_rotation_deg;
  fresh.env_scale = state.edits.env_scale;
  forget_applied();
  known_bakes_.forget();
  state.edits = fresh;
  state.selected_node = state.selected_material = state.reveal_node = -1;
  request_metering();
  ++revision_;
}

void WindowSession::use_environment(EnvironmentPointer environment, const std::string& source) {
  renderer_.set_environment(environment);
  environment_ = std::move(environment);
  suggested_ev_ = suggest_exposure_ev(*environment_);
  const SunPlace sun = find_sun(*environment_, 0.0);
  sun_ = sun.found ? std::optional(sun) : std::nullopt;
  if (state.auto_exposure) state.exposure_ev = suggested_exposure();
  request_metering();
  for (const std::string& warning : environment_->warnings)
    add_message(MessageLevel::warning, std::filesystem::path(source).filename().string() + ": " + warning);
  remember(&environment_files_, source);
  state.edits.environment = source;
  applied_.environment = source;
  ++revision_;
}

float WindowSession::suggested_exposure() const {
  const float scale = state.edits.env_scale;
  return suggested_ev_ - (scale > 0.0f ? std::log2(scale) : 0.0f);
}

void WindowSession::open(const std::string& named, int material) {
  const std::string source = absolute_source(named, std::filesystem::current_path().string());
  const std::string extension = lower_extension(source);
  if (is_review_file(source)) {
    open_review(source);
  } else if (extension == ".json") {
    open_path(source);
  } else if (contains_name({".hdr", ".exr", ".pic"}, extension) ||
             (source.starts_with("builtin:") && (contains_name(builtin_environment_names(), source) ||
                                                 contains_name(builtin_environment_names(), source.substr(8))))) {
    state.edits.environment = source;
  } else if (extension == ".binary" || (extension != ".exr" && is_btf_source(source))) {
    if (material < 0 || material >= static_cast<int>(scene_->materials.size())) {
      add_message(MessageLevel::error, source +
                                           ": there is no material to give it to; drop it on a surface, or choose "
                                           "a material first");
      return;
    }
    state.edits.materials[scene_->materials[static_cast<std::size_t>(material)].name] =
        with_btf_reading(source, state.settings);
    state.selected_material = material;
  } else if (contains_name({".glb", ".gltf"}, extension) || source.starts_with("builtin:")) {
    if (scene_file_.valid()) {
      add_message(MessageLevel::warning, source + ": " + scene_source_ + " is still being read; try again then");
      return;
    }
    scene_source_ = source;
    scene_file_ = std::async(std::launch::async, [source] { return std::make_shared<Scene>(load_scene(source)); });
  } else {
    add_message(MessageLevel::error, source +
                                         ": what this is cannot be told from its extension; known are .glb, "
                                         ".gltf, .hdr, .exr, .binary, .btf, .maquette.json and .path.json");
  }
}

void WindowSession::start_environment() {
  if (environment_file_.valid() || state.edits.environment == applied_.environment) return;
  if (missing_.contains(state.edits.environment)) return;
  environment_source_ = state.edits.environment;
  environment_file_ = std::async(std::launch::async, [source = environment_source_] {
    return std::make_shared<Environment>(load_environment(source));
  });
}

void WindowSession::poll_files() {
  if (ready(environment_file_)) {
    const std::string wanted = state.edits.environment;
    try {
      use_environment(environment_file_.get(), environment_source_);
      if (wanted != environment_source_) state.edits.environment = wanted;
    } catch (const Error& error) {
      add_message(MessageLevel::error, error.what());
      if (wanted == environment_source_) state.edits.environment = applied_.environment;
      amend();
    }
  }
  if (!ready(scene_file_)) return;
  std::unique_ptr<OpenReview> opening = std::move(opening_);
  const bool again = std::exchange(reading_again_, false);
  try {
    if (again) {
      const Review kept = review_now();
      use_scene(scene_file_.get());
      return show(kept);
    }
    use_scene(scene_file_.get());
    if (opening) {
      scene_of_file_ = opening->review().scene_of_file;
      begin_review(std::move(opening), "");
    } else {
      scene_of_file_.clear();
      state.looks.clear();
      state.paths.clear();
      state.inspection.regions.clear();
      state.inspection.r_point_m = InspectionSetup().r_point_m;
      state.settings.set("ground.kind", std::string(wants_ground(*scene_) ? "projected" : "none"));
      set_camera(camera_of_options(*scene_, SceneOptions()));
      review_ = std::make_unique<OpenReview>(review_now(), keeps_journal_);
    }
  } catch (const Error& error) {
    add_message(MessageLevel::error, error.what());
  }
}

void WindowSession::update(bool busy, double now_s) {
  if (!state.continued_journal.empty()) continue_review(std::exchange(state.continued_journal, {}));
  watch_files(now_s);
  poll_files();
  poll_btf();
  start_environment();
  apply_ground(busy);
  if (state.edits.materials != applied_.materials) apply_materials();
  if (state.edits.animation != applied_.animation || state.edits.turns != applied_.turns) apply_pose();
  if (state.edits.dents != applied_.dents) apply_dents();
  if (state.edits.hidden_nodes != applied_.hidden_nodes) apply_visibility();
  // While a scene is being exchanged there is no one state.
  const bool held = busy || dragged_dent_.has_value();
  if (!opening_) review_->observe(review_now(), held, !held && std::exchange(camera_put_, false));
  watch_bakes(busy || dragged_dent_.has_value());
  report_notes();
  advise();
}

std::vector<std::string> WindowSession::drawn_sources() const {
  std::vector<std::string> sources;
  for (const auto& [name, source] : applied_.materials)
    if (!source.empty()) sources.push_back(source);
  for (const Material& material : scene_->materials)
    if (!material.measured.empty() && !is_btf_source(material.measured)) sources.push_back(material.measured);
  return sources;
}

bool WindowSession::is_ready(const std::string& source) {
  if (source.empty() || !is_btf_source(source) || ready_btfs_.contains(source)) return true;
  if (!btf_in_work_.empty()) return false;
  if (!btf_worker_)
    btf_worker_ = std::make_unique<BackgroundWorker<std::string, std::string>>(
        [](const std::string& wanted, const BackgroundTask<std::string>& task) -> std::optional<std::string> {
          BtfTask btf;
          btf.progress = [&](const std::string&, double share) { task.progress(share); };
          btf.cancelled = [&] { return task.cancel.load(); };
          load_material_table(wanted, btf);
          return wanted;
        });
  btf_in_work_ = source;
  btf_worker_->submit(source);
  return false;
}

void WindowSession::poll_btf() {
  if (btf_in_work_.empty()) return;
  const auto wanted = [&](const auto& entry) { return entry.second == btf_in_work_; };
  std::map<std::string, std::string>& edits = state.edits.materials;
  if (std::none_of(edits.begin(), edits.end(), wanted)) {  // another was chosen meanwhile
    btf_worker_->cancel();
    btf_in_work_.clear();
    return;
  }
  try {
    if (const std::optional<std::string> made = btf_worker_->take()) {
      ready_btfs_.insert(*made);
      btf_in_work_.clear();
    }
  } catch (const Error& error) {
    add_message(MessageLevel::error, error.what());
    for (auto entry = edits.begin(); entry != edits.end();) {
      const auto before = applied_.materials.find(entry->first);
      if (!wanted(*entry)) {
        ++entry;
      } else if (before != applied_.materials.end()) {
        (entry++)->second = before->second;
      } else {
        entry = edits.erase(entry);
      }
    }
    amend();
    btf_in_work_.clear();
  }
}

void WindowSession::apply_materials() {
  std::map<std::string, std::string> wanted = state.edits.materials;
  for (const auto& [name, source] : applied_.materials) wanted.try_emplace(name, "");
  for (const auto& [name, source] : wanted) {
    const auto now = applied_.materials.find(name);
    const bool set = now != applied_.materials.end();
    if (set ? now->second == source : source.empty()) continue;
    if (missing_.contains(source) || !is_ready(source)) continue;
    try {
      renderer_.set_material(name, source);
      if (source.empty())
        applied_.materials.erase(name);
      else
        applied_.materials[name] = source;
      remember(&brdf_files_, source.empty() ? "builtin:" : source);
      ++revision_;
      ++material_revision_;
    } catch (const Error& error) {
      add_message(MessageLevel::error, error.what());
      if (set)
        state.edits.materials[name] = now->second;
      else
        state.edits.materials.erase(name);
      amend();
    }
  }
}

void WindowSession::apply_dents() {
  try {
    if (!surfaces_) {
      surfaces_of_ = at_rest();
      surfaces_ = std::make_unique<DentedSurfaces>(surfaces_of_.get());
    }
    for (const int mesh : surfaces_->press(state.edits.dents)) {
      const DentedSurfaces::Surface* dented = surfaces_->surface(mesh);
      const Primitive& plain = scene_->meshes[static_cast<std::size_t>(mesh)].primitives[0];
      renderer_.update_mesh(mesh, dented ? dented->positions : plain.positions,
                            dented ? dented->normals : plain.normals);
      ++revision_;
    }
    applied_.dents = state.edits.dents;
  } catch (const Error& error) {
    add_message(MessageLevel::error, error.what());
    dragged_dent_.reset();
    state.edits.dents = applied_.dents;
    amend();
  }
}

void WindowSession::apply_visibility() {
  const std::set<int> before = called_nodes(*scene_, applied_.hidden_nodes),
                      now = called_nodes(*scene_, state.edits.hidden_nodes);
  const auto shown = [&](int node, const std::set<int>& hidden) {
    for (int i = node; i >= 0; i = scene_->nodes[static_cast<std::size_t>(i)].parent)
      if (hidden.contains(i)) return false;
    return true;
  };
  for (int i = 0; i < static_cast<int>(scene_->nodes.size()); ++i)
    if (shown(i, now) != shown(i, before)) renderer_.set_node_visible(i, shown(i, now));
  applied_.hidden_nodes = state.edits.hidden_nodes;
  ++revision_;
}

bool WindowSession::begin_dent(const Renderer::Pick& pick) {
  const auto refuse = [&](const std::string& why) {
    add_message(MessageLevel::warning, "Dent: " + why);
    return false;
  };
  if (!pick.hit || pick.node < 0) return refuse("there is nothing here");
  const Node& node = scene_->nodes[static_cast<std::size_t>(pick.node)];
  if (node.mesh < 0 || !scene_->meshes[static_cast<std::size_t>(node.mesh)].cage)
    return refuse(node.name + " is not a subdivision surface; try the door of builtin:cockpit");
  for (Message& message : messages_) message.unread = message.unread && message.level == MessageLevel::error;
  dragged_dent_ = state.edits.dents.size();
  const auto part = static_cast<std::size_t>(pick.node);
  glm::vec3 at = pick.position;
  if (is_posed(applied_)) {
    const glm::mat4 now = compute_world_transforms(*scene_)[part], then = compute_world_transforms(*at_rest())[part];
    at = glm::vec3(then * glm::inverse(now) * glm::vec4(at, 1.0f));
  }
  state.edits.dents.push_back({at, 0.0f, state.dent_radius_m, node_paths_[part]});
  return true;
}

void WindowSession::drag_dent(float depth_m, float radius_m) {
  if (!dragged_dent_ || *dragged_dent_ >= state.edits.dents.size()) return;
  state.edits.dents[*dragged_dent_].depth_m = depth_m;
  state.edits.dents[*dragged_dent_].radius_m = radius_m;
}

void WindowSession::go_to_camera(int index) {
  const std::vector<std::string> names = camera_names(*scene_);
  if (index >= 0 && index < static_cast<int>(names.size()))
    set_camera(camera_by_name(*scene_, names[static_cast<std::size_t>(index)]));
  request_metering();
}

void WindowSession::meter_if_requested(bool continued) {
  Metered now{rest_, environment_, state.edits, renderer_.background_work().empty()};
  now.edits.animation = {};  // one exposure for all of it
  now.edits.section = {};    // and for what a cut lays open
  if (!(metered_ == now)) {
    metering_ = true;
    frames_metered_ = 0;
  }
  if (!metering_ || !state.auto_exposure) return;
  metered_ = now;
  state.exposure_ev = meter_exposure_ev(renderer_.read_radiance(), suggested_exposure());
  // A bake that has just finished shows only in the next frame, which starts anew.
  constexpr int kFramesOfABake = 3;
  metering_ = !continued || !renderer_.background_work().empty() || ++frames_metered_ < kFramesOfABake;
}

void WindowSession::put_camera(const CameraView& camera) {
  state.camera = camera;
  camera_put_ = true;
}

/// A camera of a file has no target distance: that of the middle of the scene is used.
void WindowSession::set_camera(const CameraView& camera) {
  put_camera(camera);
  const float distance = glm::dot(bounds_.center() - camera.eye, glm::normalize(camera.target - camera.eye));
  if (!bounds_.empty()) set_target_distance(&state.camera, std::max(distance, 0.05f * bounds_.radius()));
}

void WindowSession::frame_scene(float aspect) {
  frame_bounds(&state.camera, bounds_, aspect);
  camera_put_ = true;
}

FrameRequest WindowSession::make_frame_request(int width, int height) const {
  FrameSize size;
  size.width = width;
  size.height = height;
  size.msaa = state.msaa;
  size.seed = seed_;
  FrameRequest request = make_request(*scene_, state, size);
  request.display = true;
  return request;
}

void WindowSession::fill_facts(EditorFacts* facts) const {
  facts->scene = scene_.get();
  facts->cameras = camera_names(*scene_);
  facts->background = renderer_.background_work();
  facts->loading = scene_file_.valid() ? scene_source_ : environment_file_.valid() ? environment_source_ : "";
  if (facts->loading.empty() && !btf_in_work_.empty())
    facts->loading = btf_in_work_ + " (" + percent_done(btf_worker_->progress()) + ")";
  facts->environment_files = environment_files_;
  facts->brdf_files = brdf_files_;
  facts->messages = &messages_;
  facts->node_paths = &node_paths_;
  facts->bounds = bounds_;
  facts->can_undo = review_->can_undo();
  facts->can_redo = review_->can_redo();
  facts->review_file = review_->file();
  facts->review_changed = review_->changed();
  facts->review_read_only = review_->read_only();
  if (state.reflections != "off") facts->reflecting = reflecting_nodes(*scene_, state.edits);
  facts->sun_deg.reset();
  if (sun_)
    facts->sun_deg = glm::vec2(sun_->elevation_deg,
                               wrap_degrees(static_cast<float>(sun_->azimuth_deg) + state.edits.env_rotation_deg));
  facts->suggested_exposure_ev = suggested_exposure();
  facts->command = render_command(*scene_, state);
}

}  // namespace maquette
