// The window's error figure: how soon after the camera rests it is available.
#include <memory>
#include <utility>

#include "tests/benchmarks/stage.h"
#include "viewer/error_meter.h"

namespace maquette::bench {
namespace {

constexpr double kMeterPatience_ms = 60e3, kTarget_ms = 2e3;

struct Answer {
  double wall_ms = 0.0;
  std::optional<MeteredError> error;
  int paths = 0;
};

/// As the window does: the picture keeps converging, and its error is measured after a frame when there is an update.
Answer wait_for_answer(Stage& stage, const FrameRequest& request, ErrorMeter* meter, const ErrorMeter::View& view,
                       const ErrorMeter::SceneMaker& make_scene) {
  Answer answer;
  const Clock start = now();
  meter->watch(view, make_scene);
  while (!answer.error && (now() - start).wall_ms < kMeterPatience_ms) {
    stage.renderer().render(request, true);
    std::uint64_t version = 0;
    if (const auto reference = meter->newest(&version)) {
      answer.error = meter_error(stage.renderer().read_radiance(), *reference);
      answer.paths = reference->paths;
    }
  }
  answer.wall_ms = (now() - start).wall_ms;
  return answer;
}

}  // namespace

Figures measure_meter(Stage& stage) {
  stage.show({.name = "meter", .scene = "builtin:cockpit", .camera = "driver"});
  FrameRequest request = stage.request("bandwidth", 0);
  request.settings.set_from_text("shading.visibility", "auto");  // as the window has it
  stage.renderer().finish_background_work(request);
  auto snapshot = std::make_shared<Renderer::PathSnapshot>(stage.renderer().path_snapshot());
  const ErrorMeter::SceneMaker make_scene = [snapshot] {
    return build_path_scene(
        {.scene = snapshot->scene, .environment = snapshot->environment, .geometry = &snapshot->geometry});
  };
  ErrorMeter meter;
  Figures figures;
  for (const char* when : {"first view of a scene", "next view"}) {
    request.camera.eye.y += 0.01f;  // so that nothing of the view before counts
    stage.renderer().render(request);
    const ErrorMeter::View view{
        .camera = request.camera, .width = request.width, .height = request.height, .paths = {}, .scene_revision = 1};
    const Answer a = wait_for_answer(stage, request, &meter, view, make_scene);
    figures.push_back(judged(
        std::string("error of the resting picture in the window, cockpit/driver, ") + when, "<= 2 s",
        a.error ? number(1e-3 * a.wall_ms) + " s (" + number(100.0 * a.error->error) +
                      " %, 95 % sure: " + number(100.0 * a.error->low) + " to " + number(100.0 * a.error->high) +
                      " %, " + std::to_string(a.error->pixels) + " pixels, " + std::to_string(a.paths) + " paths)"
                : "nothing within a minute",
        a.error && a.wall_ms <= kTarget_ms));
  }
  return figures;
}

}  // namespace maquette::bench
