// Frames while the camera flies or the light turns: the default picture beside the one with shadows by maps alone and
// without reflections.
#include <algorithm>
#include <filesystem>
#include <map>

#include "scenes/image_io.h"
#include "tests/benchmarks/stage.h"
#include "viewer/stats.h"

namespace maquette::bench {
namespace {

constexpr int kSteps = 100;

/// Step k of the stated path, which goes from the driver's eye to the passenger's in a straight line, looking from the
/// first's target to the second's; or of the light's turn by a degree a frame.
FrameRequest step(Stage& stage, const FrameRequest& base, bool light, int k) {
  FrameRequest r = base;
  const double t = static_cast<double>(k) / (kSteps - 1);
  if (light) {
    r.env_rotation_rad = static_cast<float>(0.017453292519943295 * k);
    return r;
  }
  const CameraView to = find_camera(stage.renderer().scene(), "passenger");
  r.camera.eye = glm::mix(base.camera.eye, to.eye, static_cast<float>(t));
  r.camera.target = glm::mix(base.camera.target, to.target, static_cast<float>(t));
  r.camera.fov_y_rad = glm::mix(base.camera.fov_y_rad, to.fov_y_rad, static_cast<float>(t));
  return r;
}

/// The picture in the middle of the path, to be looked at.
void save_frame(Stage& stage, std::string name) {
  std::replace(name.begin(), name.end(), ' ', '-');
  std::filesystem::create_directories(stage.options().charts);
  save_exr((std::filesystem::path(stage.options().charts) / (name + ".exr")).string(),
           stage.renderer().read_radiance());
}

}  // namespace

Figures measure_moving(Stage& stage) {
  stage.show({.name = "cockpit/driver", .scene = "builtin:cockpit", .camera = "driver", .width = 320, .height = 180});
  FrameRequest shown = stage.request("bandwidth", 0);
  shown.reflections = kAutoReflections;
  shown.settings.set_from_text("shading.visibility", "auto");
  FrameRequest plain = shown;
  plain.reflections = "off";
  plain.settings.set_from_text("shading.visibility", "baked");
  Figures figures;
  for (const bool light : {false, true}) {
    const std::string name = light ? "light turns" : "camera flies";
    if (!stage.options().wants(name)) continue;
    std::vector<double> times[2];
    std::map<std::string, std::vector<double>> passes;
    for (int repeat = 0; repeat <= stage.options().repeats; ++repeat)
      for (const bool full : {false, true}) {
        const FrameRequest& base = full ? shown : plain;
        stage.renderer().finish_background_work(base);
        for (int k = 0; k < kSteps; ++k) {
          const Clock begin = now();
          const FrameStats stats = stage.renderer().render(step(stage, base, light, k));
          if (repeat > 0) times[full].push_back((now() - begin).wall_ms);  // the first round compiles shaders
          for (const PassTime& pass : stats.passes)
            if (repeat > 0 && full) passes[pass.name].push_back(pass.ms);
          if (full && k == kSteps / 2 && !stage.options().charts.empty()) save_frame(stage, name);
        }
      }
    for (auto& [pass, ms] : passes)
      if (const double middle = median(ms); middle >= 0.5)
        figures.push_back(bench::shown(name + ": pass " + pass, number(middle) + " ms"));
    const double before = median(times[0]), after = median(times[1]);
    figures.push_back(judged("frame of the default picture while the " + name + ", 320 x 180",
                             ">= 0.6 of the rate with baked visibility and no reflections",
                             number(after) + " ms, beside " + number(before) + " ms: " + number(before / after),
                             before / after >= 0.6));
  }
  return figures;
}

}  // namespace maquette::bench
