#include "viewer/inspection_options.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace maquette {

glm::ivec4 pixels_of(const InspectedRegion& region, int width, int height) {
  const auto at = [](float share, int size) {
    return std::clamp(static_cast<int>(std::lround(share * static_cast<float>(size))), 0, size);
  };
  const int x = at(region.x, width), y = at(region.y, height);
  return {x, y, std::max(at(region.x + region.width, width) - x, 1),
          std::max(at(region.y + region.height, height) - y, 1)};
}

MeasureOptions measure_options_of(const InspectionSetup& view) {
  MeasureOptions options;
  options.threshold_cdm2 = static_cast<double>(view.threshold_cdm2);
  options.polarisation = static_cast<Polarisation>(view.polarisation);
  options.night = view.light == InspectionSetup::Light::night;
  if (view.light == InspectionSetup::Light::given) options.lux_on_glass = static_cast<double>(view.lux_on_glass);
  options.both_eyes = view.both_eyes;
  options.grid_columns = view.grid[0];
  options.grid_rows = view.grid[1];
  options.eye_box_mm = {static_cast<double>(view.eye_box_mm[0]), static_cast<double>(view.eye_box_mm[1])};
  if (view.background_given) options.background_cdm2 = static_cast<double>(view.background_cdm2);
  if (view.dash_given) options.dash_reflectance = static_cast<double>(view.dash_reflectance);
  return options;
}

SceneOptions inspected_options(const Look& shown, const std::string& scene) {
  SceneOptions options;
  options.scene = scene;
  options.environment = shown.edits.environment;
  options.env_rotation_deg = shown.edits.env_rotation_deg;
  options.env_scale = shown.edits.env_scale;
  options.variant = shown.edits.variant;
  if (shown.edits.section != glm::vec4(0.0f)) options.section = shown.edits.section;
  for (const Technique& technique : builtin_registry().techniques)
    if (technique.can.traces_picture) options.mode = technique.name;
  options.settings = shown.settings;
  options.settings.reset("reflections.layer");
  options.eye = shown.camera.eye;
  options.target = shown.camera.target;
  options.up = shown.camera.up;
  if (shown.camera.is_orthographic())
    options.orthographic_m = shown.camera.height_m;
  else
    options.fov_deg = glm::degrees(shown.camera.fov_y_rad);
  return options;
}

bool has_r_point(const Scene& scene) {
  return std::ranges::any_of(scene.nodes, [](const Node& node) { return node.name == "r_point"; });
}

std::vector<PictureRegion> picture_regions(const std::vector<InspectedRegion>& regions, int width, int height) {
  std::vector<PictureRegion> result;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const glm::ivec4 box = pixels_of(regions[i], width, height);
    const int x = std::min(box.x, width - 1), y = std::min(box.y, height - 1);
    result.push_back(
        {"region " + std::to_string(i + 1), x, y, std::min(box.z, width - x), std::min(box.w, height - y)});
  }
  return result;
}

MeasureOptions measure_options_of(const Review& review, const Scene& scene, const SceneOptions& asked,
                                  const MeasureOptions& options) {
  const InspectionSetup& setup = review.inspection;
  const MeasureOptions kept = measure_options_of(setup);
  const std::set<std::string>& given = asked.given;
  MeasureOptions result = options;
  const auto take = [&](const char* option, auto MeasureOptions::*member) {
    if (!given.contains(option)) result.*member = kept.*member;
  };
  take("--threshold", &MeasureOptions::threshold_cdm2);
  take("--polarisation", &MeasureOptions::polarisation);
  take("--background", &MeasureOptions::background_cdm2);
  take("--eye-box", &MeasureOptions::eye_box_mm);
  take("--eye-grid", &MeasureOptions::grid_columns);
  take("--eye-grid", &MeasureOptions::grid_rows);
  take("--both-eyes", &MeasureOptions::both_eyes);
  take("--dash-reflectance", &MeasureOptions::dash_reflectance);
  if (!given.contains("--night") && !given.contains("--lux-on-glass")) {
    result.night = kept.night;
    result.lux_on_glass = kept.lux_on_glass;
  }
  if (!given.contains("--right-hand-drive")) result.right_hand_drive = setup.right_hand_drive;
  // As in the window, a node of the scene counts more.
  if (!given.contains("--r-point") && !has_r_point(scene) && setup.r_point_m != InspectionSetup().r_point_m)
    result.r_point_m = glm::dvec3(setup.r_point_m[0], setup.r_point_m[1], setup.r_point_m[2]);
  if (result.regions.empty()) result.regions = picture_regions(review.regions, asked.width, asked.height);
  return result;
}

glm::dvec3 eye_of_button(int button, const InspectionView& view, const glm::dvec3& r_point_m, const VehicleAxes& axes) {
  char point[96];
  std::snprintf(point, sizeof point, "%.9g,%.9g,%.9g", static_cast<double>(view.eye_mm[0]),
                static_cast<double>(view.eye_mm[1]), static_cast<double>(view.eye_mm[2]));
  const EyePlace place{button == 1 ? "V1" : button == 2 ? "V2" : point, view.right_hand_drive};
  const glm::dvec3 middle = eye_from_r_point(r_point_m, axes, place);
  if (view.which_eye == 0) return middle;
  return both_eyes(middle, axes)[view.which_eye == 1 ? 0 : 1];
}

CameraView camera_at_eye(CameraView camera, const glm::dvec3& eye, const VehicleAxes& axes) {
  const glm::vec3 ahead = camera.target - camera.eye;
  camera.eye = glm::vec3(eye);
  camera.target = camera.eye + ahead;
  camera.up = glm::vec3(axes.up);
  return camera;
}

std::string interval_text(const Interval& i) {
  double half = i.half_width < 1e-6 * std::abs(i.mean) ? 0.0 : i.half_width;  // what is the same along every path
  if (half >= 100.0) {
    const double unit = std::pow(10.0, std::floor(std::log10(half)) - 1.0);
    half = unit * std::round(half / unit);
  }
  char text[96];
  std::snprintf(text, sizeof text, half >= 100.0 ? "%s +- %.0f cd/m2" : "%s +- %.2g cd/m2",
                plain_number(i.mean).c_str(), half);
  return text;
}

bool changes_glass_alone(const std::string& sweep) { return sweep == "wedge" || sweep == "thickness"; }

std::vector<float> worst_of_steps(const Measurement& result, const std::vector<float>& steps, bool ghost) {
  std::vector<float> worst(steps.size(), std::numeric_limits<float>::quiet_NaN());
  for (const EyeValues& eye : result.eyes)
    for (std::size_t i = 0; i < steps.size() && eye.looks_through; ++i) {
      if (eye.step.empty() || eye.regions.empty() || static_cast<float>(eye.step.front().second) != steps[i]) continue;
      const RegionValues& region = eye.regions.front();
      const double angle = region.ghost_arcmin ? region.ghost_arcmin->mean : 0.0;
      worst[i] = std::fmax(worst[i], static_cast<float>(ghost ? angle : region.reflected.mean));
    }
  return worst;
}

std::vector<std::pair<std::string, std::string>> worst_rows(const Measurement& result) {
  std::vector<std::pair<std::string, std::string>> rows;
  if (result.worst >= result.eyes.size() || result.eyes[result.worst].regions.empty()) return rows;
  const EyeValues& eye = result.eyes[result.worst];
  if (!eye.looks_through) return {{"Worst", "no eye looks through the pane"}};
  const RegionValues& region = eye.regions.front();
  std::string where = eye.eye;
  for (const auto& [name, value] : eye.step) where += ", " + name + " " + plain_number(value);
  rows.emplace_back("Worst", where);
  rows.emplace_back("Reflected",
                    plain_number(region.reflected.mean) + " cd/m2, at most " + plain_number(region.reflected.max));
  rows.emplace_back("Contrast kept", plain_number(100.0 * region.contrast) + " %");
  if (region.ghost_arcmin)
    rows.emplace_back("Ghost angle", plain_number(region.ghost_arcmin->mean) + " arc minutes, at most " +
                                         plain_number(region.ghost_arcmin->max));
  if (eye.light) {
    rows.emplace_back("On the glass", plain_number(eye.light->illuminance_lx) + " lx");
    rows.emplace_back("Rake", plain_number(eye.light->rake_deg) + " deg from the vertical");
  }
  if (region.veil_per_lux)
    rows.emplace_back("Veil per lux", plain_number(*region.veil_per_lux) + " cd/m2/lx, an own index");
  return rows;
}

}  // namespace maquette
