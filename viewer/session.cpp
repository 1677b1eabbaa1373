#include "viewer/session.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "render/bake/bake_settings.h"
#include "render/parts/parts.h"
#include "render/picture/tonemap.h"
#include "render/technique/registry.h"
#include "review/review.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/ground.h"
#include "scenes/luminance.h"
#include "scenes/node_paths.h"
#include "scenes/subject_bounds.h"
#include "scenes/suggest.h"
#include "ui/camera_control.h"
#include "viewer/dents.h"
#include "viewer/pose.h"

namespace maquette {

namespace {

constexpr float kDefaultFov = radians(40.0f);

/// The error for a file that is not a scene: names the option for it.
void check_is_scene(const std::string& path) {
  if (path.starts_with("builtin:")) return;
  const std::string extension = lower_extension(path);
  if (extension == ".hdr" || extension == ".exr")
    throw UsageError(path, "is an environment, not a scene", "give it by --env " + path);
  if (extension == ".binary")
    throw UsageError(path, "is a measured material, not a scene", "give it by --material NAME=" + path);
}

struct NamedCamera {
  std::size_t node = 0;
  std::string name;
};

/// Cameras of a scene by their own names, or else their nodes'; a name that an earlier one has gets a number.
std::vector<NamedCamera> named_cameras(const Scene& scene) {
  std::vector<NamedCamera> cameras;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].camera < 0) continue;
    const std::string& own = scene.cameras[static_cast<std::size_t>(scene.nodes[i].camera)].name;
    const std::string name = own.empty() ? scene.nodes[i].name : own;
    std::string unique = name;
    for (int number = 2; std::ranges::find(cameras, unique, &NamedCamera::name) != cameras.end(); ++number)
      unique = name + " " + std::to_string(number);
    cameras.push_back({i, unique});
  }
  return cameras;
}

CameraView camera_of(const Scene& scene, std::size_t node, const glm::mat4& world_from_node) {
  CameraView view;
  view.eye = glm::vec3(world_from_node[3]);
  view.target = view.eye - glm::normalize(glm::vec3(world_from_node[2]));
  view.up = glm::normalize(glm::vec3(world_from_node[1]));
  const Camera& camera = scene.cameras[static_cast<std::size_t>(scene.nodes[node].camera)];
  view.fov_y_rad = camera.fov_y_rad;
  view.height_m = camera.height_m;
  view.aspect = camera.aspect;
  return view;
}

/// The end of Z at which a vehicle's front is: +1, as glTF has it, unless its nodes' names say otherwise (wheel_fl,
/// door-rear). Of words that are one of these.
float front_of(const Scene& scene) {
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  float sum[2] = {0.0f, 0.0f};
  int count[2] = {0, 0};
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    std::string word;
    for (const char c : scene.nodes[i].name + " ") {
      if (std::isalpha(static_cast<unsigned char>(c))) {
        word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        continue;
      }
      const bool front = word == "front" || word == "fl" || word == "fr",
                 rear = word == "rear" || word == "rl" || word == "rr";
      if (front || rear) {
        sum[rear] += world[i][3].z;
        ++count[rear];
      }
      word.clear();
    }
  }
  if (count[0] == 0 || count[1] == 0) return 1.0f;
  return sum[0] / static_cast<float>(count[0]) < sum[1] / static_cast<float>(count[1]) ? -1.0f : 1.0f;
}

/// A view three quarters from the front and above that contains the bounding sphere.
CameraView frame_scene(const Bounds& bounds, float front, float aspect) {
  CameraView view;
  view.fov_y_rad = kDefaultFov;
  if (bounds.empty()) return view;
  const float half = 0.5f * kDefaultFov;
  const float narrow = std::min(half, std::atan(std::tan(half) * aspect));
  const float distance = std::max(bounds.radius(), 1e-6f) / std::sin(narrow);
  view.target = bounds.center();
  view.eye = view.target + distance * glm::normalize(glm::vec3(0.7f * front, 0.4f, front));
  return view;
}

}  // namespace

GroundOptions ground_options(const Settings& settings) {
  return {.height_m = static_cast<float>(settings.get_double("ground.height")),
          .roughness = static_cast<float>(settings.get_double("ground.roughness"))};
}

std::shared_ptr<const Scene> with_ground(std::shared_ptr<const Scene> scene, const Environment& environment,
                                         const Settings& settings, float env_rotation_rad) {
  if (settings.get_string("ground.kind") == "none" || compute_bounds(*scene).empty()) return scene;
  auto grounded = std::make_shared<Scene>(*scene);
  add_ground(grounded.get(), environment, ground_options(settings));
  grounded->materials.back().base_color_texture.offset = ground_texture_offset(env_rotation_rad);
  return grounded;
}

Bounds framed_bounds(const Scene& scene) {
  const bool grounded = !scene.nodes.empty() && is_added_ground(scene, scene.nodes.size() - 1);
  if (!grounded) return subject_bounds(scene);
  Scene shown = scene;
  shown.nodes.back().visible = false;
  return subject_bounds(shown);
}

std::vector<std::string> camera_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const NamedCamera& camera : named_cameras(scene)) names.push_back(camera.name);
  return names;
}

CameraView camera_by_name(const Scene& scene, const std::string& name) {
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (const NamedCamera& camera : named_cameras(scene))
    if (camera.name == name) return camera_of(scene, camera.node, world[camera.node]);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    if (scene.nodes[i].camera >= 0 && scene.nodes[i].name == name) return camera_of(scene, i, world[i]);
  const std::vector<std::string> names = camera_names(scene);
  throw UsageError("--camera " + name, scene.name + " has no such camera",
                   names.empty() ? "it has none; use --eye and --target" : did_you_mean(name, names));
}

CameraView camera_of_options(const Scene& scene, const SceneOptions& options) {
  const std::vector<std::string> names = camera_names(scene);
  const Bounds bounds = framed_bounds(scene);
  CameraView view;
  if (!options.camera.empty())
    view = camera_by_name(scene, options.camera);
  else if (!names.empty())
    view = camera_by_name(scene, names.front());
  else
    view = frame_scene(bounds, front_of(scene), static_cast<float>(options.width) / static_cast<float>(options.height));
  if (options.eye) {
    view.eye = *options.eye;
    view.target = bounds.empty() ? glm::vec3(0.0f) : bounds.center();
    if (view.target == view.eye) view.target = view.eye - glm::vec3(0.0f, 0.0f, 1.0f);
    view.up = glm::vec3(0.0f, 1.0f, 0.0f);
  }
  if (options.target) view.target = *options.target;
  if (options.up) view.up = glm::normalize(*options.up);
  if (view.target == view.eye) throw UsageError("--target", "it is where the eye is");
  const glm::vec3 forward = glm::normalize(view.target - view.eye);
  if (glm::length(glm::cross(forward, view.up)) < 1e-4f)
    view.up = std::abs(forward.z) < 0.9f ? glm::vec3(0.0f, 0.0f, -1.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
  if (options.fov_deg) view.fov_y_rad = radians(*options.fov_deg);
  if (options.fov_deg || options.orthographic_m) {
    view.height_m = options.orthographic_m.value_or(0.0f);
    view.aspect = 0.0f;
  }
  if (options.eye) view.aspect = 0.0f;
  return view;
}

int find_variant(const Scene& scene, const std::string& name) {
  if (name.empty()) return -1;
  const auto found = std::find(scene.variants.begin(), scene.variants.end(), name);
  if (found != scene.variants.end()) return static_cast<int>(found - scene.variants.begin());
  throw UsageError("--variant " + name, scene.name + " has no such variant",
                   scene.variants.empty() ? "it has none" : did_you_mean(name, scene.variants));
}

void check_material_name(const Scene& scene, const std::string& name) {
  std::vector<std::string> names;
  for (const Material& material : scene.materials) {
    if (material.name == name) return;
    if (!material.name.empty()) names.push_back(material.name);
  }
  if (name == "*") return;
  throw UsageError("--material " + name, scene.name + " has no such material",
                   names.empty() ? "use * for all" : did_you_mean(name, names));
}

namespace {

/// With all that is below it.
void hide_node(Scene* scene, int node) {
  scene->nodes[static_cast<std::size_t>(node)].visible = false;
  for (const int child : scene->nodes[static_cast<std::size_t>(node)].children) hide_node(scene, child);
}

}  // namespace

std::shared_ptr<Scene> load_session_scene(const SceneOptions& options) {
  check_is_scene(options.scene);
  auto scene = std::make_shared<Scene>(load_scene(options.scene, options.scene_of_file));
  find_variant(*scene, options.variant);
  for (const auto& [name, source] : options.materials) check_material_name(*scene, name);
  camera_of_options(*scene, options);
  press_dents(scene.get(), options.dents);
  if (!options.animation.name.empty()) {
    const int animation = find_animation(*scene, options.animation.name);
    pose(scene.get(), scene->animations[static_cast<std::size_t>(animation)], options.animation.time_s);
  }
  for (const NodeTurn& turn : options.turns) turn_node(scene.get(), turn);
  for (const int node : called_nodes(*scene, options.hidden)) hide_node(scene.get(), node);
  return scene;
}

std::string gloss_warning(const Scene& scene, const std::string& remedy) {
  constexpr float kMatte = 0.75f;  // exporters write 0.8 where they know nothing
  std::size_t materials = 0;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const Material& m = scene.materials[i];
    if (m.name == kGroundName) continue;
    const bool measured = !m.measured.empty(), glass = m.glass || m.transmission > 0.0f,
               gloss = m.roughness < kMatte || m.clearcoat > 0.0f || m.unlit ||
                       (m.metallic_roughness_texture && m.roughness > 0.0f);
    if (measured || glass || gloss) return {};
    ++materials;
  }
  if (materials == 0) return {};
  return (materials == 1 ? std::string("its one material has")
                         : "its " + std::to_string(materials) + " materials have") +
         " neither gloss nor glass, so paint looks like chalk; " + remedy;
}

std::string units_warning(const Scene& scene, const Environment& environment, float env_scale,
                          const std::string& remedy, float* suited_env_scale) {
  constexpr double kStreetAtNight_cdm2 = 10.0, kHall_cdm2 = 500.0, kOutshines = 30.0;
  if (environment.name.starts_with("builtin:")) return {};
  double lamps = 0.0;
  for (const Material& material : scene.materials)
    lamps = std::max(lamps, static_cast<double>(luminance(material.emissive)));
  const double stored = mean_luminance(environment), mean = stored * static_cast<double>(env_scale);
  if (!(mean > 0.0) || mean > kStreetAtNight_cdm2 || lamps < kOutshines * mean) return {};
  const auto rounded = [](double value) {
    const double digit = std::pow(10.0, std::floor(std::log10(value)));
    return std::round(value / digit) * digit;
  };
  if (suited_env_scale) *suited_env_scale = static_cast<float>(rounded(kHall_cdm2 / stored));
  char text[256];
  std::snprintf(
      text, sizeof text,
      "about %.5g cd/m2 on average, the scene's lamps up to %.5g: as at night. If the file is in units of its own, "
      "%s %.10g lights it as a hall",
      rounded(mean), rounded(lamps), remedy.c_str(), rounded(kHall_cdm2 / stored));
  return text;
}

float exposure_of(const SceneOptions& options, const Environment& environment) {
  if (options.exposure_ev) return *options.exposure_ev;
  if (!(options.env_scale > 0.0f)) return 0.0f;
  return suggest_exposure_ev(environment) - std::log2(options.env_scale);
}

namespace {

std::vector<NodeTurn> turns_by_path(const Scene& scene, const std::vector<NodeTurn>& asked) {
  std::vector<NodeTurn> turns;
  if (asked.empty()) return turns;
  const std::vector<std::string> paths = node_paths(scene);
  for (const NodeTurn& turn : asked) {
    if (turn.node == "*") {
      turns.push_back(turn);
      continue;
    }
    for (const int node : find_nodes(scene, turn.node))
      turns.push_back({paths[static_cast<std::size_t>(node)], turn.axis, turn.angle_deg});
  }
  return turns;
}

}  // namespace

Look look_of_options(const Scene& scene, const SceneOptions& options) {
  Look look;
  Edits& edits = look.edits;
  edits.environment = options.environment;
  edits.env_rotation_deg = options.env_rotation_deg;
  edits.env_scale = options.env_scale;
  find_variant(scene, options.variant);
  edits.variant = options.variant;
  for (const auto& [name, source] : options.materials)
    for (const Material& material : scene.materials)
      if (name == "*" || material.name == name) edits.materials[material.name] = source;
  edits.dents = options.dents;
  edits.animation = options.animation;
  if (!edits.animation.name.empty()) find_animation(scene, edits.animation.name);
  edits.turns = turns_by_path(scene, options.turns);
  edits.reflectors = {options.reflectors.begin(), options.reflectors.end()};
  if (!options.part_modes.empty()) {
    const std::vector<std::string> paths = node_paths(scene);
    for (const PartMode& part : options.part_modes)
      for (const int node : find_nodes(scene, part.node))  // names unknown nodes before any work
        edits.part_modes[paths[static_cast<std::size_t>(node)]] = part.mode;
  }
  if (options.section) edits.section = *options.section;
  look.camera = camera_of_options(scene, options);
  look.mode = options.mode;
  look.reflections = options.reflections;
  look.settings = options.settings;
  look.auto_exposure = !options.exposure_ev;
  look.exposure_ev = options.exposure_ev.value_or(0.0f);
  look.tonemap = options.tonemap;
  check_given_settings(builtin_registry(), look.settings, options.settings_given, scene.name);
  return look;
}

SceneOptions without_edits(SceneOptions options) {
  options.dents.clear();
  options.turns.clear();
  options.animation = {};
  return options;
}

Look absolute_sources(Look look) {
  const std::string folder = std::filesystem::current_path().string();
  look.edits.environment = absolute_source(look.edits.environment, folder);
  for (auto& [name, source] : look.edits.materials) source = absolute_source(source, folder);
  return look;
}

namespace {

/// A mode with a setting NAME.ground may leave a ground that was added to the scene to the default mode.
void set_mode_of_ground(const Scene& scene, FrameRequest* request) {
  const std::string setting = request->mode + ".ground";
  const bool added = !scene.nodes.empty() && is_added_ground(scene, scene.nodes.size() - 1);
  if (!added || !find_setting(setting) || request->settings.get_string(setting) != "apart") return;
  const auto named = [](const PartMode& part) { return part.node == kGroundName; };
  if (std::ranges::none_of(request->part_modes, named))
    request->part_modes.push_back({kGroundName, builtin_registry().default_mode});
}

/// A mode with a setting NAME.parts shades those that it names, and the default mode the rest.
void set_modes_of_parts(const Scene& scene, FrameRequest* request) {
  const std::string setting = request->mode + ".parts";
  if (!find_setting(setting)) return;
  const std::string names = request->settings.get_string(setting);
  if (names.empty()) return;
  std::set<std::string> parts;
  std::istringstream in(names);
  for (std::string name; std::getline(in, name, ';');) parts.insert(name);
  std::vector<PartMode> modes;
  std::vector<int> open = scene.roots;
  while (!open.empty()) {  // the first nodes from the roots on that have a name
    const Node& node = scene.nodes[static_cast<std::size_t>(open.back())];
    open.pop_back();
    if (node.name.empty())
      open.insert(open.end(), node.children.begin(), node.children.end());
    else if (!parts.contains(node.name))
      modes.push_back({node.name, builtin_registry().default_mode});
  }
  for (const std::string& name : parts)
    if (!name.empty()) modes.push_back({name, request->mode});
  // Those that were given come later and win.
  request->part_modes.insert(request->part_modes.begin(), modes.begin(), modes.end());
}

}  // namespace

FrameRequest make_request(const Scene& scene, const Look& look, const FrameSize& size) {
  FrameRequest request;
  request.mode = look.mode;
  request.camera = look.camera;
  request.camera.section = look.edits.section;
  request.width = std::max(size.width, 1);
  request.height = std::max(size.height, 1);
  fit_aspect(&request.camera, static_cast<float>(request.width) / static_cast<float>(request.height));
  request.msaa = size.msaa;
  request.samples = size.samples;
  request.seed = size.seed;
  request.env_rotation_rad = radians(look.edits.env_rotation_deg);
  request.env_scale = look.edits.env_scale;
  request.variant = variant_index(scene, look.edits.variant);
  request.reflections = look.reflections;
  request.reflectors = {look.edits.reflectors.begin(), look.edits.reflectors.end()};
  request.settings = with_settings_of_bakes(builtin_registry(), look.settings, scene.name);
  // A mode that draws whole pictures shares none; the parts' modes are there again when another is chosen.
  if (builtin_registry().find_mode(look.mode).can.traces_picture) return request;
  set_modes_of_parts(scene, &request);
  set_mode_of_ground(scene, &request);
  if (look.edits.part_modes.empty()) return request;
  const std::vector<std::string> paths = node_paths(scene);
  for (const auto& [path, mode] : look.edits.part_modes)
    for (const int node : called_nodes(scene, paths, path)) request.part_modes.push_back({path, mode, node});
  return request;
}

FrameRequest make_request(const Scene& scene, const SceneOptions& options) {
  FrameRequest request = make_request(scene, look_of_options(scene, options),
                                      {options.width, options.height, options.msaa, options.samples, options.seed});
  request.reflectors = options.reflectors;  // as they were called, for messages and stats
  request.part_modes = options.part_modes;
  if (!builtin_registry().find_mode(request.mode).can.traces_picture) {
    set_modes_of_parts(scene, &request);
    set_mode_of_ground(scene, &request);
  }
  const Technique* reflector = builtin_registry().find_reflector(request.reflections);
  if (reflector && reflector->can.needs_eye && request.camera.is_orthographic())
    throw UsageError("--reflections " + request.reflections, "it projects from an eye, and the camera is orthographic",
                     "take one whose rays are traced: octree, raytraced");
  return request;
}

}  // namespace maquette
