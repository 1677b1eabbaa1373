#include "viewer/session.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "render/parts/parts.h"
#include "render/picture/tonemap.h"
#include "render/technique/registry.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/ground.h"
#include "scenes/luminance.h"
#include "scenes/subdivision.h"
#include "scenes/suggest.h"
#include "ui/camera_control.h"

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

std::string camera_name(const Scene& scene, const Node& node) {
  const std::string& name = scene.cameras[static_cast<std::size_t>(node.camera)].name;
  return name.empty() ? node.name : name;
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

/// A view from the front (+Z), the right and above that contains the bounding sphere.
CameraView frame_scene(const Bounds& bounds, float aspect) {
  CameraView view;
  view.fov_y_rad = kDefaultFov;
  if (bounds.empty()) return view;
  const float half = 0.5f * kDefaultFov;
  const float narrow = std::min(half, std::atan(std::tan(half) * aspect));
  const float distance = std::max(bounds.radius(), 1e-6f) / std::sin(narrow);
  view.target = bounds.center();
  view.eye = view.target + distance * glm::normalize(glm::vec3(0.7f, 0.4f, 1.0f));
  return view;
}

/// The vertex of a limit surface nearest to the dent: its position and unit normal, in the world.
struct Nearest {
  float distance_m = std::numeric_limits<float>::max();
  glm::vec3 normal{0.0f, 1.0f, 0.0f};
};

Nearest nearest_surface(const Scene& scene, const std::vector<glm::mat4>& world, const glm::vec3& center) {
  Nearest nearest;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (!node.visible || node.mesh < 0 || !scene.meshes[static_cast<std::size_t>(node.mesh)].cage) continue;
    const Primitive& surface = scene.meshes[static_cast<std::size_t>(node.mesh)].primitives.front();
    const glm::mat3 normal_matrix = glm::transpose(glm::inverse(glm::mat3(world[i])));
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      const float distance = glm::length(glm::vec3(world[i] * glm::vec4(surface.positions[v], 1.0f)) - center);
      if (distance < nearest.distance_m) nearest = {distance, glm::normalize(normal_matrix * surface.normals[v])};
    }
  }
  return nearest;
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
  if (!grounded) return compute_bounds(scene);
  Scene shown = scene;
  shown.nodes.back().visible = false;
  return compute_bounds(shown);
}

std::vector<std::string> camera_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const Node& node : scene.nodes)
    if (node.camera >= 0) names.push_back(camera_name(scene, node));
  return names;
}

CameraView camera_by_name(const Scene& scene, const std::string& name) {
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (node.camera >= 0 && (camera_name(scene, node) == name || node.name == name))
      return camera_of(scene, i, world[i]);
  }
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
    view = frame_scene(bounds, static_cast<float>(options.width) / static_cast<float>(options.height));
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

void press_dent(Scene* scene, const Dent& dent) {
  const std::vector<glm::mat4> world = compute_world_transforms(*scene);
  const Nearest nearest = nearest_surface(*scene, world, dent.center);
  int moved = 0;
  std::vector<bool> done(scene->meshes.size(), false);  // a mesh with several instances is dented once
  for (std::size_t i = 0; i < scene->nodes.size(); ++i) {
    const Node& node = scene->nodes[i];
    if (!node.visible || node.mesh < 0 || done[static_cast<std::size_t>(node.mesh)]) continue;
    Mesh& mesh = scene->meshes[static_cast<std::size_t>(node.mesh)];
    if (!mesh.cage) continue;
    const glm::mat4 node_from_world = glm::inverse(world[i]);
    const glm::vec3 push = glm::mat3(node_from_world) * (-nearest.normal * dent.depth_m);
    const float depth = glm::length(push);
    if (!(depth > 0.0f)) continue;
    const float scale = std::cbrt(std::abs(glm::determinant(glm::mat3(node_from_world))));
    SubdivisionCage cage = *mesh.cage;
    const int count = dent_cage(&cage, glm::vec3(node_from_world * glm::vec4(dent.center, 1.0f)), push / depth, depth,
                                dent.radius_m * scale);
    if (count == 0) continue;
    moved += count;
    done[static_cast<std::size_t>(node.mesh)] = true;
    mesh.cage = std::make_shared<const SubdivisionCage>(std::move(cage));
    tessellate_cage(&mesh);
  }
  if (moved > 0 || dent.depth_m == 0.0f) return;
  char text[96];
  std::snprintf(text, sizeof(text), "%g,%g,%g", static_cast<double>(dent.center.x), static_cast<double>(dent.center.y),
                static_cast<double>(dent.center.z));
  const bool any = nearest.distance_m < std::numeric_limits<float>::max();
  throw Error(std::string("--dent ") + text, "no control point of a subdivision surface is that near",
              any ? "the nearest surface is " +
                        to_text(SettingValue(std::round(static_cast<double>(nearest.distance_m) * 1e3) / 1e3)) +
                        " m away; move it or widen the radius"
                  : scene->name + " has no subdivision surface");
}

void turn_node(Scene* scene, const NodeTurn& turn) {
  const glm::dmat4 rotation =
      glm::rotate(glm::dmat4(1.0), glm::radians(static_cast<double>(turn.angle_deg)), glm::dvec3(turn.axis));
  if (turn.node == "*") {
    for (const int root : scene->roots) {
      Node& node = scene->nodes[static_cast<std::size_t>(root)];
      if (node.camera < 0 && node.light < 0) node.local = glm::mat4(rotation * glm::dmat4(node.local));
    }
    return;
  }
  for (const int index : find_nodes(*scene, turn.node)) {
    Node& node = scene->nodes[static_cast<std::size_t>(index)];
    const glm::dvec4 origin = glm::dmat4(node.local)[3];
    node.local = glm::mat4(rotation * glm::dmat4(node.local));
    node.local[3] = glm::vec4(origin);
  }
}

std::shared_ptr<Scene> load_session_scene(const SceneOptions& options) {
  check_is_scene(options.scene);
  auto scene = std::make_shared<Scene>(load_scene(options.scene, options.scene_of_file));
  find_variant(*scene, options.variant);
  for (const auto& [name, source] : options.materials) check_material_name(*scene, name);
  camera_of_options(*scene, options);
  for (const NodeTurn& turn : options.turns) turn_node(scene.get(), turn);
  for (const Dent& dent : options.dents) press_dent(scene.get(), dent);
  return scene;
}

std::string gloss_warning(const Scene& scene) {
  constexpr float kMatte = 0.9f;
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
         " neither gloss nor glass, so paint looks like chalk; take measured ones from the library";
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

FrameRequest make_request(const Scene& scene, const SceneOptions& options) {
  FrameRequest request;
  request.mode = options.mode;
  request.camera = camera_of_options(scene, options);
  request.width = options.width;
  request.height = options.height;
  fit_aspect(&request.camera, static_cast<float>(request.width) / static_cast<float>(request.height));
  request.msaa = options.msaa;
  request.samples = options.samples;
  request.seed = options.seed;
  request.env_rotation_rad = radians(options.env_rotation_deg);
  request.env_scale = options.env_scale;
  request.variant = find_variant(scene, options.variant);
  request.reflections = options.reflections;
  const Technique* reflector = builtin_registry().find_reflector(request.reflections);
  if (reflector && reflector->can.needs_eye && request.camera.is_orthographic())
    throw UsageError("--reflections " + request.reflections, "it projects from an eye, and the camera is orthographic",
                     "take one whose rays are traced: octree, raytraced");
  request.reflectors = options.reflectors;
  request.part_modes = options.part_modes;
  if (!request.part_modes.empty())
    layers_of_nodes(scene, request.part_modes, {});  // names unknown nodes before any work
  request.settings = options.settings;
  return request;
}

}  // namespace maquette
