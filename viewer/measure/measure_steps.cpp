// The eyes and the steps of the sweeps of a measurement.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "render/inspection/light_on_pane.h"
#include "render/reference/path_scene.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/suggest.h"
#include "viewer/inspection_options.h"
#include "viewer/interrupt.h"
#include "viewer/measure/measure_run.h"
#include "viewer/measure/scene_edits.h"
#include "viewer/session.h"

namespace maquette {

glm::dvec3 r_point_of(const Scene& scene, const MeasureOptions& options) {
  if (options.r_point_m) return *options.r_point_m;
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    if (scene.nodes[i].name == "r_point") return glm::dvec3(glm::vec3(world[i][3]));
  throw Error("--eye-point", scene.name + " has no node r_point",
              "give the R-point in metres of the scene: --r-point x,y,z");
}

namespace {

using Step = std::vector<std::pair<std::string, double>>;

/// All combinations of the sweeps' values; one empty step without sweeps.
std::vector<Step> steps_of(const std::vector<Sweep>& sweeps) {
  std::vector<Step> steps = {{}};
  for (const Sweep& sweep : sweeps) {
    std::vector<Step> more;
    for (const Step& step : steps)
      for (const double value : sweep.values) {
        more.push_back(step);
        more.back().emplace_back(sweep.name, value);
      }
    steps = std::move(more);
  }
  return steps;
}

std::optional<double> value_of(const Step& step, const std::string& name) {
  for (const auto& [key, value] : step)
    if (key == name) return value;
  return std::nullopt;
}

struct NamedEye {
  std::string name;
  CameraView view;
};

/// Looks from the eye at what the camera of the options looks at, without one at the pane's middle.
CameraView view_from(const glm::dvec3& eye, const Scene& scene, const SceneOptions& options, const VehicleAxes& axes) {
  const CameraView camera = camera_of_options(scene, options);
  CameraView view = camera_at_eye(camera, eye, axes);
  view.section = options.section.value_or(glm::vec4(0.0f));
  if (options.target) view.target = camera.target;
  if (options.up) view.up = camera.up;
  return view;
}

std::vector<NamedEye> eyes_of(const Scene& scene, const SceneOptions& scene_options, const MeasureOptions& options) {
  const VehicleAxes axes = vehicle_axes(options.axes);
  std::vector<NamedEye> eyes;
  CameraView camera = camera_of_options(scene, scene_options);
  camera.section = scene_options.section.value_or(glm::vec4(0.0f));
  glm::dvec3 middle(camera.eye);
  std::string name = "camera";
  if (options.eye) {
    middle = eye_from_r_point(r_point_of(scene, options), axes, *options.eye);
    name = options.eye->point;
  }
  const auto add = [&](const std::string& eye_name, const glm::dvec3& eye) {
    eyes.push_back({eye_name, options.eye || !eyes.empty() || eye_name != "camera"
                                  ? view_from(eye, scene, scene_options, axes)
                                  : camera});
  };
  const std::vector<glm::dvec3> grid = eye_grid(middle, axes, options.grid_columns, options.grid_rows,
                                                1e-3 * options.eye_box_mm.x, 1e-3 * options.eye_box_mm.y);
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const std::string place =
        grid.size() == 1 ? name
                         : name + ", row " + std::to_string(k / static_cast<std::size_t>(options.grid_columns) + 1) +
                               ", column " + std::to_string(k % static_cast<std::size_t>(options.grid_columns) + 1);
    if (options.both_eyes) {
      const std::vector<glm::dvec3> both = both_eyes(grid[k], axes);
      add(place + ", left", both[0]);
      add(place + ", right", both[1]);
    } else {
      add(place, grid[k]);
    }
  }
  return eyes;
}

/// Everything that a step of the sweeps changes.
struct StepScene {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Environment> environment;
  SceneOptions options;
  MeasureOptions measure;
  std::shared_ptr<const PathScene> paths;
  /// On the inner side of the pane, m: the first eye, turned with the pane, so that its outer face stays the same one.
  glm::dvec3 inside{0.0};
  std::optional<PaneLight> light;
  std::optional<SunPlace> sun;
};

class Steps {
 public:
  Steps(const SceneOptions& options, const MeasureOptions& measure, std::shared_ptr<const Scene> scene,
        std::shared_ptr<const Environment> environment)
      : options_(options), measure_(measure), scene_(std::move(scene)), environment_(std::move(environment)) {
    const std::shared_ptr<const PathScene> paths = trace_scene(*scene_, environment_);
    const NamedEye eye = eyes_of(*scene_, options_, measure_).front();
    const EyeRays rays = eye_rays(eye.view, options_.width, options_.height, paths->bounds);
    const std::vector<Sight> sights = look_at_all(*paths, rays, glm::dvec3(eye.view.up));
    pane_ = pane_of(*scene_, measure_.pane, sights);
    inside_ = glm::dvec3(eye.view.eye);
    plain_ = light_on_pane(*paths, *environment_, radians(options_.env_rotation_deg), 1.0f, pane_, inside_);
    dash_ = dash_of(sights);
    first_paths_ = paths;
  }

  int pane() const { return pane_; }
  const std::string& dash_name() const { return scene_->materials[static_cast<std::size_t>(dash_)].name; }
  bool has_dash() const { return dash_ >= 0; }

  StepScene make(const Step& step) {
    StepScene s{scene_, environment_, options_, measure_, nullptr, inside_, {}, {}};
    if (const auto reflectance = value_of(step, "dash-reflectance")) s.measure.dash_reflectance = reflectance;
    if (const auto wedge = value_of(step, "wedge")) s.options.settings.set("reflections.wedge", *wedge);
    if (const auto thickness = value_of(step, "thickness")) s.options.settings.set("reflections.thickness", *thickness);
    edit_scene(step, &s);
    edit_light(step, &s);
    const bool same = s.scene == scene_ && s.environment == environment_;
    s.paths = same ? first_paths_ : trace_scene(*s.scene, s.environment);
    const float rotation = radians(s.options.env_rotation_deg);
    const auto light = light_on_pane(*s.paths, *s.environment, rotation, 1.0f, pane_, s.inside);
    if (s.measure.night) {
      s.options.env_scale = 0.0f;
    } else if (s.measure.lux_on_glass) {
      if (!light || !(light->illuminance_lx > 0.0))
        throw Error("--lux-on-glass", "no light of the environment reaches the pane",
                    "choose another --env or rotation");
      s.options.env_scale = static_cast<float>(*s.measure.lux_on_glass / light->illuminance_lx);
    }
    if (light) {
      s.light = light;
      s.light->illuminance_lx *= static_cast<double>(s.options.env_scale);
      s.light->unshadowed_lx *= static_cast<double>(s.options.env_scale);
    }
    s.sun = find_sun(*s.environment, static_cast<double>(rotation));
    if (!s.sun->found) s.sun.reset();
    return s;
  }

 private:
  std::shared_ptr<const PathScene> trace_scene(const Scene& scene,
                                               const std::shared_ptr<const Environment>& environment) {
    Scene traced = scene;
    traced.materials = effective_materials(scene, {options_.materials.begin(), options_.materials.end()});
    return build_path_scene({.scene = traced,
                             .environment = environment,
                             .variant = find_variant(scene, options_.variant),
                             .geometry = nullptr,
                             .library = &library_});
  }

  int dash_of(const std::vector<Sight>& sights) const {
    if (!measure_.dash.empty()) {
      std::vector<std::string> names;
      for (const Material& material : scene_->materials) names.push_back(material.name);
      const auto found = std::ranges::find(names, measure_.dash);
      if (found != names.end()) return static_cast<int>(found - names.begin());
      throw UsageError("--dash " + measure_.dash, scene_->name + " has no such material",
                       did_you_mean(measure_.dash, names));
    }
    std::vector<std::size_t> counts(scene_->materials.size() + 1, 0);
    for (const Sight& sight : sights)
      if (sight.pane && sight.pane->node == pane_ && sight.pane->mirrored.surface && sight.pane->mirrored.material >= 0)
        ++counts[static_cast<std::size_t>(sight.pane->mirrored.material)];
    const auto most = std::max_element(counts.begin(), counts.end() - 1);
    return *most > 0 ? static_cast<int>(most - counts.begin()) : -1;
  }

  void edit_scene(const Step& step, StepScene* s) const {
    const auto rake = value_of(step, "rake");
    if (!rake && !s->measure.dash_reflectance) return;
    auto edited = std::make_shared<Scene>(*scene_);
    if (s->measure.dash_reflectance) {
      if (dash_ < 0) throw Error("--dash-reflectance", "the pane mirrors no surface", "name one by --dash MATERIAL");
      make_lambertian(edited.get(), dash_, *s->measure.dash_reflectance);
    }
    if (rake && plain_) {
      // About the pane's lower edge, below its middle.
      const glm::dvec3 up(0.0, 1.0, 0.0), slope = glm::normalize(up - plain_->normal * plain_->normal.y);
      const glm::dvec3 hinge =
          plain_->middle + slope * ((plain_->lowest_m - plain_->middle.y) / std::max(slope.y, 1e-6));
      const glm::dmat4 turn = turn_rake(edited.get(), pane_, hinge, plain_->normal, *rake - plain_->rake_deg);
      s->inside = glm::dvec3(turn * glm::dvec4(inside_, 1.0));
    }
    s->scene = std::move(edited);
  }

  void edit_light(const Step& step, StepScene* s) const {
    if (const auto elevation = value_of(step, "sun-elevation")) {
      if (!options_.environment.starts_with("builtin:clear-sky"))
        throw UsageError("--sweep sun-elevation", "the sun of " + options_.environment + " stays where it was recorded",
                         "sweep sun-azimuth, or take --env builtin:clear-sky");
      char name[64];
      std::snprintf(name, sizeof name, "builtin:clear-sky:%.6g", *elevation);
      s->environment = std::make_shared<const Environment>(load_environment(name));
      s->options.environment = name;
    }
    if (const auto azimuth = value_of(step, "sun-azimuth")) {
      const SunPlace sun = find_sun(*s->environment, 0.0);
      if (!sun.found)
        throw UsageError("--sweep sun-azimuth", options_.environment + " has no sun", "sweep another quantity");
      s->options.env_rotation_deg = static_cast<float>(*azimuth - sun.azimuth_deg);
    }
  }

  SceneOptions options_;
  MeasureOptions measure_;
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Environment> environment_;
  MeasuredLibrary library_;
  std::shared_ptr<const PathScene> first_paths_;
  int pane_ = -1, dash_ = -1;
  glm::dvec3 inside_{0.0};
  std::optional<PaneLight> plain_;
};

/// A larger veil; where both have the same one, as when only the glass changes, a larger ghost angle.
bool worse(const RegionValues& a, const RegionValues& b) {
  const double more = a.reflected.mean - b.reflected.mean;
  if (std::abs(more) > 1e-6 * std::abs(b.reflected.mean)) return more > 0.0;
  return a.ghost_arcmin && b.ghost_arcmin && a.ghost_arcmin->mean > b.ghost_arcmin->mean;
}

bool shows_ghost(const SceneOptions& options) { return options.settings.get_bool("reflections.ghost"); }

/// The layers of one eye by paths: of the panes' pixels and those that are probed, of all where the picture is kept.
LayerPictures traced_pictures(const StepScene& s, const EyeContext& context, const SceneOptions& own,
                              const EyeRays& rays, const std::vector<Sight>& sights, const MeasureOptions& options,
                              bool shown) {
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < sights.size(); ++i)
    if (sights[i].pane || shown) pixels.push_back(i);
  for (const glm::ivec2& p : options.probes)
    if (p.x >= 0 && p.y >= 0 && p.x < own.width && p.y < own.height)
      pixels.push_back(static_cast<std::size_t>(p.y * own.width + p.x));
  PathOptions asked = context.paths;
  if (own.settings.get_string("reference.transport") == "direct") asked.transport = Transport::direct;
  std::optional<GhostSheet> ghost;
  if (shown || shows_ghost(own))
    ghost = {static_cast<float>(context.sheet.thickness_m), static_cast<float>(context.sheet.wedge_rad),
             shows_ghost(own)};
  return trace_layers(*s.paths, asked, rays, pixels, {own.width, own.height},
                      own.samples > 0 ? own.samples : kPathsOfAPixel, own.seed, ghost);
}

}  // namespace

Measurement measure(const SceneOptions& scene_options, const MeasureOptions& options,
                    const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Environment>& environment,
                    const MeasureProgress& progress, LastEye* last) {
  const std::vector<PictureRegion> regions =
      checked_regions(options.regions, scene_options.width, scene_options.height);
  Steps steps(scene_options, options, scene, environment);
  const std::unique_ptr<LayerSource> source = make_layer_source(scene_options);
  Measurement result;
  const std::vector<Step> all = steps_of(options.sweeps);
  const std::size_t eye_count = eyes_of(*scene, scene_options, options).size();
  std::size_t done = 0;
  for (const Step& step : all) {
    const StepScene s = steps.make(step);
    for (const NamedEye& eye : eyes_of(*s.scene, s.options, s.measure)) {
      if (InterruptGuard::asked()) throw Error("maquette measure", "interrupted", "nothing was written");
      if (progress) progress(static_cast<double>(done) / static_cast<double>(all.size() * eye_count));
      ++done;
      SceneOptions own = s.options;
      own.camera.clear();
      own.eye = eye.view.eye;
      own.target = eye.view.target;
      own.up = eye.view.up;
      if (!eye.view.is_orthographic()) own.fov_deg = glm::degrees(eye.view.fov_y_rad);
      const EyeRays rays = eye_rays(eye.view, own.width, own.height, s.paths->bounds);
      const std::vector<Sight> sights = look_at_all(*s.paths, rays, glm::dvec3(eye.view.up));
      EyeContext context{*s.scene, s.measure, own.width, own.height, steps.pane(), {}, s.light, {}, own.seed};
      context.sheet = {glm::dvec3(eye.view.eye), 1e-3 * own.settings.get_double("reflections.thickness"),
                       1e-3 * own.settings.get_double("reflections.wedge")};
      context.paths.env_rotation_rad = radians(own.env_rotation_deg);
      context.paths.env_scale = own.env_scale;
      context.paths.max_bounces = own.settings.get_int("reference.bounces");
      const bool shown = !options.layers.empty() && done == all.size() * eye_count;
      LayerPictures pictures = source ? source->draw(s.scene, s.environment, own, shown || shows_ghost(own))
                                      : traced_pictures(s, context, own, rays, sights, options, shown);
      EyeValues values{eye.name, glm::dvec3(eye.view.eye), step, true, s.light, s.sun, {}, {}};
      for (const PictureRegion& region : regions) {
        values.regions.push_back(region_values(context, region, pictures, sights));
        if (options.paths > 0 && values.regions.back().pane_pixels > 0)
          values.regions.back().traced =
              traced_value(context, *s.paths, rays, pane_pixels(region, own.width, steps.pane(), sights), sights);
      }
      for (const glm::ivec2& pixel : options.probes)
        values.probes.push_back(probe_values(context, pixel, pictures, sights));
      const auto seen = pane_pixels(regions.front(), own.width, steps.pane(), sights);
      values.looks_through = !seen.empty() && std::ranges::all_of(seen, [&](std::size_t i) {
        return !s.light || glm::dot(sights[i].pane->normal, s.light->normal) < 0.0;
      });
      result.eyes.push_back(std::move(values));
      if (last) *last = {std::move(pictures), sights, own};
    }
  }
  for (std::size_t r = 0; r < regions.size(); ++r)
    if (std::ranges::all_of(result.eyes, [&](const EyeValues& eye) { return eye.regions[r].pane_pixels == 0; }))
      throw no_pane_in(regions[r], *scene, steps.pane());
  for (std::size_t i = 0; i < result.eyes.size(); ++i) {
    const EyeValues &eye = result.eyes[i], &worst = result.eyes[result.worst];
    if (eye.looks_through && (!worst.looks_through || worse(eye.regions.front(), worst.regions.front())))
      result.worst = i;
  }
  add_assumptions(scene_options, options, *scene, steps.pane(), steps.has_dash() ? steps.dash_name() : "", &result);
  return result;
}

}  // namespace maquette
