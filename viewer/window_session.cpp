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

float wrap_degrees(float degrees) { return degrees - 360.0f * std::round(degrees / 360.0f); }

/// A file's scene with nothing level below it would float.
bool wants_ground(const Scene& scene) { return !scene.name.starts_with("builtin:") && !has_ground(scene); }

template <typename T>
bool ready(const std::future<T>& file) {
  return file.valid() && file.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

}  // namespace

WindowSession::WindowSession(const SceneOptions& options) {
  renderer_.set_interactive(true);
  environment_source_ = options.environment;
  auto environment = std::async(std::launch::async, [source = options.environment] {
    return std::make_shared<Environment>(load_environment(source));
  });
  ScenePointer scene = load_session_scene(options);
  state.edits.env_scale = options.env_scale;
  use_scene(scene);
  use_environment(environment.get(), options.environment);
  const FrameRequest request = make_request(*scene, options);
  if (options.eye || options.target)
    state.camera = request.camera;
  else
    set_camera(camera_of_options(*scene, options));  // WindowPicture adapts it to the picture's size
  state.mode = options.mode;
  state.settings = settings_of(options);
  if (!options.settings.changed().contains("ground.kind") && wants_ground(*scene))
    state.settings.set("ground.kind", std::string("projected"));
  state.msaa = options.msaa;
  if (!options.screenshot.empty()) state.still_msaa = options.msaa;  // the same frames however long they take
  state.tonemap = options.tonemap;
  state.debug_view = options.debug_view;
  state.edits.variant = request.variant;
  state.edits.env_rotation_deg = wrap_degrees(options.env_rotation_deg);
  state.auto_exposure = !options.exposure_ev;
  state.exposure_ev = exposure_of(options, *environment_);
  seed_ = options.seed;
  state.reflections = options.reflections;
  state.edits.reflectors = {options.reflectors.begin(), options.reflectors.end()};
  for (const PartMode& part : options.part_modes)
    for (const int node : find_nodes(*scene, part.node)) state.edits.part_modes[node] = part.mode;
  std::map<std::string, std::string> set_already;
  for (const auto& [name, source] : options.materials) {
    const bool later = is_btf_source(source);  // the window opens before it is made
    if (!later) renderer_.set_material(name, source);
    remember(&brdf_files_, source);
    for (const Material& material : scene->materials)
      if (name == "*" || material.name == name) {
        state.edits.materials[material.name] = source;
        if (!later) set_already[material.name] = source;
      }
  }
  applied_ = state.edits;
  applied_.materials = set_already;
  undo_.reset(state.edits);
}

void WindowSession::use_scene(ScenePointer scene) {
  renderer_.set_scene(scene);
  scene_ = std::move(scene);
  bounds_ = framed_bounds(*scene_);
  evaluators_.clear();
  dent_.reset();
  for (const std::string& warning : scene_->warnings)
    add_message(MessageLevel::warning, std::filesystem::path(scene_->name).filename().string() + ": " + warning);
  Edits fresh;  // the light stays as it was
  fresh.environment = state.edits.environment;
  fresh.env_rotation_deg = state.edits.env_rotation_deg;
  fresh.env_scale = state.edits.env_scale;
  forget_applied();
  state.edits = fresh;
  state.selected_node = state.selected_material = state.reveal_node = -1;
  undo_.reset(state.edits);
  request_metering();
  ++revision_;
}

void WindowSession::use_environment(EnvironmentPointer environment, const std::string& source) {
  renderer_.set_environment(environment);
  environment_ = std::move(environment);
  suggested_ev_ = suggest_exposure_ev(*environment_);
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

void WindowSession::open(const std::string& source, int material) {
  const std::string extension = lower_extension(source);
  if (contains_name({".hdr", ".exr", ".pic"}, extension) ||
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
                                         ".gltf, .hdr, .exr, .binary and .btf");
  }
}

void WindowSession::start_environment() {
  if (environment_file_.valid() || state.edits.environment == applied_.environment) return;
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
      undo_.correct(state.edits);
    }
  }
  if (ready(scene_file_)) {
    try {
      use_scene(scene_file_.get());
      state.settings.set("ground.kind", std::string(wants_ground(*scene_) ? "projected" : "none"));
      set_camera(camera_of_options(*scene_, SceneOptions()));
    } catch (const Error& error) {
      add_message(MessageLevel::error, error.what());
    }
  }
}

void WindowSession::update(bool busy) {
  poll_files();
  poll_btf();
  start_environment();
  apply_ground(busy);
  if (state.edits.materials != applied_.materials) apply_materials();
  if (state.edits.dents != applied_.dents) apply_dents();
  if (state.edits.hidden_nodes != applied_.hidden_nodes) apply_visibility();
  undo_.observe(state.edits, busy || dent_.has_value());
  advise();
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
    undo_.correct(state.edits);
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
    if (!is_ready(source)) continue;
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
      undo_.correct(state.edits);
    }
  }
}

std::vector<glm::vec3> WindowSession::control_points(int mesh) const {
  if (const auto found = state.edits.dents.find(mesh); found != state.edits.dents.end()) return *found->second;
  return scene_->meshes[static_cast<std::size_t>(mesh)].cage->positions;
}

bool WindowSession::move_surface(int mesh, const std::vector<glm::vec3>& points) {
  try {
    auto found = evaluators_.find(mesh);
    if (found == evaluators_.end()) {
      SubdivisionEvaluator evaluator(*scene_->meshes[static_cast<std::size_t>(mesh)].cage);
      found = evaluators_.emplace(mesh, std::move(evaluator)).first;
    }
    std::vector<glm::vec3> positions, normals;
    found->second.evaluate(points, &positions, &normals);
    renderer_.update_mesh(mesh, positions, normals);
    ++revision_;
    return true;
  } catch (const Error& error) {
    add_message(MessageLevel::error, error.what());
    return false;
  }
}

void WindowSession::apply_dents() {
  std::map<int, std::shared_ptr<const std::vector<glm::vec3>>> touched = state.edits.dents;
  for (const auto& [mesh, points] : applied_.dents) touched.try_emplace(mesh, nullptr);
  for (const auto& [mesh, points] : touched) {
    const auto now = applied_.dents.find(mesh);
    if (now != applied_.dents.end() && now->second == points) continue;
    if (!move_surface(mesh, control_points(mesh))) {
      state.edits.dents = applied_.dents;
      undo_.correct(state.edits);
      return;
    }
  }
  applied_.dents = state.edits.dents;
}

void WindowSession::apply_visibility() {
  const auto shown = [&](int node, const std::set<int>& hidden) {
    for (int i = node; i >= 0; i = scene_->nodes[static_cast<std::size_t>(i)].parent)
      if (hidden.contains(i)) return false;
    return true;
  };
  for (int i = 0; i < static_cast<int>(scene_->nodes.size()); ++i) {
    const bool now = shown(i, state.edits.hidden_nodes);
    if (now != shown(i, applied_.hidden_nodes)) renderer_.set_node_visible(i, now);
  }
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
  dismiss_messages();
  const glm::mat4 node_from_world =
      glm::inverse(compute_world_transforms(*scene_)[static_cast<std::size_t>(pick.node)]);
  DentDrag drag;
  drag.mesh = node.mesh;
  drag.center = glm::vec3(node_from_world * glm::vec4(pick.position, 1.0f));
  drag.push = glm::mat3(node_from_world) * -pick.normal;
  drag.node_scale = std::cbrt(std::abs(glm::determinant(glm::mat3(node_from_world))));
  drag.before = std::make_shared<const std::vector<glm::vec3>>(control_points(node.mesh));
  dent_ = drag;
  return true;
}

void WindowSession::drag_dent(float depth_m, float radius_m) {
  if (!dent_) return;
  SubdivisionCage cage = *scene_->meshes[static_cast<std::size_t>(dent_->mesh)].cage;
  cage.positions = *dent_->before;
  const glm::vec3 push = dent_->push * depth_m;
  const float depth = glm::length(push);
  if (depth > 0.0f) dent_cage(&cage, dent_->center, push / depth, depth, radius_m * dent_->node_scale);
  state.edits.dents[dent_->mesh] = std::make_shared<const std::vector<glm::vec3>>(std::move(cage.positions));
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

void WindowSession::undo() {
  if (const std::optional<Edits> before = undo_.undo()) state.edits = *before;
}

void WindowSession::go_to_camera(int index) {
  const std::vector<std::string> names = camera_names(*scene_);
  if (index >= 0 && index < static_cast<int>(names.size()))
    set_camera(camera_by_name(*scene_, names[static_cast<std::size_t>(index)]));
  request_metering();
}

void WindowSession::meter_if_requested(bool continued) {
  const Metered now{scene_, environment_, state.edits, renderer_.background_work().empty()};
  if (!(metered_ == now)) metering_ = true;
  if (!metering_ || !state.auto_exposure) return;
  metered_ = now;
  state.exposure_ev = meter_exposure_ev(renderer_.read_radiance(), suggested_exposure());
  // A bake that is read from the cache may be finished before its frame is, and then shows only in the next frame.
  metering_ = !continued || !renderer_.background_work().empty();
}

/// A camera of a file has no target distance: that of the middle of the scene is used.
void WindowSession::set_camera(const CameraView& camera) {
  state.camera = camera;
  const float distance = glm::dot(bounds_.center() - camera.eye, glm::normalize(camera.target - camera.eye));
  if (!bounds_.empty()) set_target_distance(&state.camera, std::max(distance, 0.05f * bounds_.radius()));
}

void WindowSession::frame_scene(float aspect) { frame_bounds(&state.camera, bounds_, aspect); }

void WindowSession::add_message(MessageLevel level, const std::string& text) {
  constexpr std::size_t kMost = 200;
  if (messages_.size() >= kMost) messages_.erase(messages_.begin());
  messages_.push_back({level, text, true});
}

void WindowSession::dismiss_messages() {
  for (Message& message : messages_) message.unread = false;
}

FrameRequest WindowSession::make_frame_request(int width, int height) const {
  FrameRequest request;
  request.mode = state.mode;
  request.camera = state.camera;
  request.width = std::max(width, 1);
  request.height = std::max(height, 1);
  request.msaa = state.msaa;
  request.seed = seed_;
  request.env_rotation_rad = radians(state.edits.env_rotation_deg);
  request.env_scale = state.edits.env_scale;
  request.variant = state.edits.variant;
  request.reflections = state.reflections;
  request.reflectors = {state.edits.reflectors.begin(), state.edits.reflectors.end()};
  // A mode that draws whole pictures shares none; the parts' modes are there again when another is chosen.
  if (!renderer_.registry().find_mode(state.mode).can.traces_picture)
    for (const auto& [node, mode] : state.edits.part_modes)
      request.part_modes.push_back({node_path(renderer_.scene(), node), mode, node});
  request.settings = state.settings;
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
  facts->can_undo = undo_.can_undo();
  if (state.reflections != "off") facts->reflecting = reflecting_nodes(*scene_, state.edits);
  facts->suggested_exposure_ev = suggested_exposure();
  facts->command = render_command(*scene_, state);
}

}  // namespace maquette
