#include "viewer/review_options.h"

#include <algorithm>
#include <set>

#include "render/bake/bake_settings.h"
#include "render/technique/registry.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/node_paths.h"
#include "scenes/suggest.h"
#include "viewer/print.h"
#include "viewer/session.h"

namespace maquette {

namespace {

/// The camera of a look, turned by what the options say.
CameraView camera_on_top(const CameraView& base, const Scene& scene, const SceneOptions& options) {
  if (options.given.contains("--camera") || options.eye) return camera_of_options(scene, options);
  CameraView view = base;
  if (options.target) view.target = *options.target;
  if (options.up) view.up = glm::normalize(*options.up);
  if (view.target == view.eye) throw UsageError("--target", "it is where the eye is");
  if (options.fov_deg) view.fov_y_rad = radians(*options.fov_deg);
  if (options.fov_deg || options.orthographic_m) {
    view.height_m = options.orthographic_m.value_or(0.0f);
    view.aspect = 0.0f;
  }
  return view;
}

const Look& named_look(const Review& review, const SceneOptions& options) {
  return options.look.empty() ? review.look : find_look(review, options.look);
}

/// A scene that was exported anew may have other names: what a look says of parts that are gone is ignored, with a
/// line.
void warn_of_unknown(const Look& look, const Scene& scene, const std::string& review) {
  const std::vector<std::string> paths = node_paths(scene);
  std::set<std::string> known(paths.begin(), paths.end());
  for (const Node& node : scene.nodes) known.insert(node.name);
  std::set<std::string> gone;
  const auto check = [&](const std::string& node) {
    if (node != "*" && !known.contains(node)) gone.insert(node);
  };
  for (const std::string& node : look.edits.hidden_nodes) check(node);
  for (const NodeTurn& turn : look.edits.turns) check(turn.node);
  for (const auto& [node, mode] : look.edits.part_modes) check(node);
  const std::string where = review + (look.name.empty() ? "" : ": look " + look.name);
  if (!gone.empty())
    print_line(stderr, "warning: %s: hides, turns or shades parts that %s does not have: %s", where.c_str(),
               scene.name.c_str(), join({gone.begin(), gone.end()}).c_str());
  const std::string& played = look.edits.animation.name;
  const bool has = std::ranges::any_of(scene.animations, [&](const Animation& a) { return a.name == played; });
  if (!played.empty() && !has)
    print_line(stderr, "warning: %s: %s has no animation \"%s\"", where.c_str(), scene.name.c_str(), played.c_str());
}

}  // namespace

std::optional<Review> review_of(const SceneOptions& options) {
  if (options.review.empty()) return std::nullopt;
  Review review = load_review(options.review);
  if (const std::vector<std::string> missing = missing_sources(review); !missing.empty())
    throw Error(options.review, "these files are missing: " + join(missing), "put them there, or open it in a window");
  return review;
}

Look look_of_review(const Review& review, const Scene& scene, const SceneOptions& options) {
  Look look = named_look(review, options);
  warn_of_unknown(look, scene, options.review);
  const Look asked = look_of_options(scene, options);
  const auto given = [&](const char* name) { return options.given.contains(name); };
  if (given("--env")) look.edits.environment = asked.edits.environment;
  if (given("--env-rotation")) look.edits.env_rotation_deg = asked.edits.env_rotation_deg;
  if (given("--env-scale")) look.edits.env_scale = asked.edits.env_scale;
  if (given("--variant")) look.edits.variant = asked.edits.variant;
  for (const auto& [name, source] : asked.edits.materials) look.edits.materials[name] = source;
  look.edits.dents.insert(look.edits.dents.end(), asked.edits.dents.begin(), asked.edits.dents.end());
  if (given("--animation")) look.edits.animation = asked.edits.animation;
  look.edits.turns.insert(look.edits.turns.end(), asked.edits.turns.begin(), asked.edits.turns.end());
  if (given("--section")) look.edits.section = asked.edits.section;
  if (given("--reflector")) look.edits.reflectors = asked.edits.reflectors;
  for (const auto& [path, mode] : asked.edits.part_modes) look.edits.part_modes[path] = mode;
  look.camera = camera_on_top(look.camera, scene, options);
  if (given("--mode")) look.mode = asked.mode;
  if (given("--reflections")) look.reflections = asked.reflections;
  for (const std::string& name : options.settings_given) look.settings.set(name, options.settings.get(name));
  if (given("--exposure")) {
    look.auto_exposure = false;
    look.exposure_ev = asked.exposure_ev;
  }
  if (given("--tonemap")) look.tonemap = asked.tonemap;
  check_given_settings(builtin_registry(), look.settings, options.settings_given, scene.name);
  return look;
}

std::optional<Look> take_review(SceneOptions* options) {
  const std::optional<Review> review = review_of(*options);
  if (!review) return std::nullopt;
  options->scene = review->scene;
  options->scene_of_file = review->scene_of_file;
  const Look look = look_of_review(*review, load_scene(review->scene, review->scene_of_file), *options);
  options->mode = look.mode;
  options->reflections = look.reflections;
  options->reflectors = {look.edits.reflectors.begin(), look.edits.reflectors.end()};
  options->part_modes.clear();
  for (const auto& [path, mode] : look.edits.part_modes) options->part_modes.push_back({path, mode});
  options->environment = look.edits.environment;
  options->env_rotation_deg = look.edits.env_rotation_deg;
  options->env_scale = look.edits.env_scale;
  options->exposure_ev = look.auto_exposure ? std::nullopt : std::optional(look.exposure_ev);
  options->tonemap = look.tonemap;
  options->materials = {look.edits.materials.begin(), look.edits.materials.end()};
  options->variant = look.edits.variant;
  options->dents = look.edits.dents;
  if (look.edits.section != glm::vec4(0.0f)) options->section = look.edits.section;
  options->animation = look.edits.animation;
  options->turns = look.edits.turns;
  options->hidden = look.edits.hidden_nodes;
  options->settings = look.settings;
  options->camera.clear();
  options->eye = look.camera.eye;
  options->target = look.camera.target;
  options->up = look.camera.up;
  options->fov_deg.reset();
  options->orthographic_m.reset();
  if (look.camera.is_orthographic())
    options->orthographic_m = look.camera.height_m;
  else
    options->fov_deg = glm::degrees(look.camera.fov_y_rad);
  return look;
}

}  // namespace maquette
