// What a reviewer waits for in the window: the first picture of another look, and frames of a path while it plays.
#include <epoxy/gl.h>

#include <algorithm>
#include <functional>
#include <memory>

#include "scenes/brdf.h"
#include "test_paths.h"
#include "tests/benchmarks/stage.h"
#include "ui/layout.h"
#include "viewer/stats.h"
#include "viewer/window_paths.h"
#include "viewer/window_picture.h"
#include "viewer/window_session.h"

namespace maquette::bench {
namespace {

constexpr double kSwitch_ms = 150.0, kOverMedian_ms = 50.0, kPatience_ms = 300e3;
constexpr int kRestFrames = 4;

/// The loop of a window of 1280 x 720, both sides open, without its panels.
class BareWindow {
 public:
  explicit BareWindow(const SceneOptions& options)
      : session(options), picture_rect_(compute_layout(LayoutRequest()).picture) {}

  /// One turn of the loop; true when a frame was drawn. The frame is whole on return.
  bool turn() {
    const double now_s = 1e-3 * now().wall_ms;
    paths.update(&session, now_s);
    session.update(paths.playing(), now_s);
    PictureUpdate update;
    update.width_px = static_cast<int>(picture_rect_.width);
    update.height_px = static_cast<int>(picture_rect_.height);
    update.playing = paths.playing();
    update.now_s = now_s;
    const bool drew = picture.update(&session, update);
    glFinish();
    return drew;
  }
  /// Until everything is read and baked and the picture rests.
  void settle() {
    const Clock begin = now();
    for (int rested = 0; rested < kRestFrames && (now() - begin).wall_ms < kPatience_ms;) {
      const bool drew = turn(), busy = session.loading() || !session.renderer().background_work().empty();
      rested = busy || !picture.still() ? 0 : rested + (drew ? 1 : 0);
    }
  }
  std::string size() const {
    return number(static_cast<double>(picture_rect_.width)) + " x " + number(static_cast<double>(picture_rect_.height));
  }

  WindowSession session;
  WindowPicture picture;
  WindowPaths paths;

 private:
  Rect picture_rect_;
};

SceneOptions cockpit_options(const Options& options) {
  SceneOptions result;
  result.scene = "builtin:cockpit";
  result.camera = "driver";
  result.screenshot = "none.png";  // such a window leaves no journal
  for (const auto& [name, text] : options.settings) result.settings.set_from_text(name, text);
  return result;
}

struct Change {
  const char* name;
  std::function<void(Look*)> make;
};

std::vector<Change> changes(const Scene& scene) {
  const auto paint = [&scene](Look* look) {
    look->edits.materials[scene.materials.front().name] = "builtin:" + builtin_brdfs()[4].name;
  };
  const auto camera = [&scene](Look* look) { look->camera = find_camera(scene, "passenger"); };
  const auto light = [](Look* look) {
    look->edits.env_rotation_deg = 60.0f;
    look->edits.env_scale *= 0.5f;
  };
  return {{"another material", paint},
          {"another camera", camera},
          {"another light (turned, half as bright)", light},
          {"material, camera and light",
           [=](Look* look) {
             paint(look);
             camera(look);
             light(look);
           }},
          {"another mode (splitsum)", [](Look* look) { look->mode = "splitsum"; }}};
}

struct Waited {
  Clock first = {};         ///< until a picture of the other look is shown
  std::string passes = {};  ///< of its frame, the slow ones
};

Waited switch_to(BareWindow* window, const Look& look) {
  const Clock begin = now();
  window->session.take(look);
  while (!window->turn() || window->session.loading()) {
  }
  Waited waited{now() - begin};
  for (const PassTime& pass : window->picture.stats()->passes)
    if (pass.ms > 10.0) waited.passes += " " + pass.name + " " + number(pass.ms);
  return waited;
}

Figures measure_switches(const Options& options) {
  Figures figures;
  BareWindow window(cockpit_options(options));
  window.settle();
  const Look first = canonical(window.session.state);
  for (const Change& change : changes(window.session.scene())) {
    if (!options.wants(change.name)) continue;
    Look second = first;
    change.make(&second);
    std::vector<double> times, cpu;
    std::string passes;
    for (int round = 0; round <= options.repeats; ++round)
      for (const Look* look : {static_cast<const Look*>(&second), &first}) {
        const Waited waited = switch_to(&window, *look);
        if (round > 0) {  // in the first round tables are read and shaders compiled
          times.push_back(waited.first.wall_ms);
          cpu.push_back(waited.first.cpu_ms);
        }
        if (look == &second) passes = waited.passes;
        window.settle();
      }
    const double middle = median(times);
    figures.push_back(judged(
        "first picture of a look with " + std::string(change.name) + ", " + window.size(), "<= 150 ms",
        number(middle) + " ms (CPU " + number(median(cpu)) + " ms), at most " +
            number(*std::ranges::max_element(times)) + " ms" + (passes.empty() ? "" : " (passes in ms:" + passes + ")"),
        middle <= kSwitch_ms));
  }
  return figures;
}

/// Plays a path once; the time of each frame. At a key where the path rests none is drawn.
std::vector<double> play(BareWindow* window, const CameraPath& path) {
  EditorState& state = window->session.state;
  state.paths = {path};
  state.path_view = {};
  EditorActions actions;
  actions.play_path = true;
  window->paths.carry_out(actions, &window->session, 1e-3 * now().wall_ms);
  std::vector<double> times;
  for (bool on = true; on; on = state.path_view.playing) {
    const Clock begin = now();
    if (window->turn()) times.push_back((now() - begin).wall_ms);
  }
  return times;
}

Figures measure_paths(const Options& options) {
  Figures figures;
  for (const char* name : {"cabin", "walkaround", "turning-light"}) {
    if (!options.wants(name)) continue;
    BareWindow window(cockpit_options(options));
    window.settle();
    const CameraPath path = load_path(std::string(MAQUETTE_SOURCE_DIR) + "/paths/" + name + ".path.json");
    play(&window, path);  // shaders are compiled
    window.settle();
    const std::vector<double> times = play(&window, path);
    const double middle = median(times), most = *std::ranges::max_element(times);
    const auto late = std::ranges::count_if(times, [&](double t) { return t > middle + kOverMedian_ms; });
    figures.push_back(judged("slowest frame of the path " + std::string(name) + " while it plays, " + window.size(),
                             "<= 50 ms above the median",
                             number(most - middle) + " ms above " + number(middle) + " ms; " + std::to_string(late) +
                                 " of " + std::to_string(times.size()) + " frames are over",
                             most <= middle + kOverMedian_ms));
  }
  return figures;
}

}  // namespace

Figures measure_looks(Stage& stage) {
  Figures figures = measure_switches(stage.options());
  for (Figure& figure : measure_paths(stage.options())) figures.push_back(std::move(figure));
  return figures;
}

}  // namespace maquette::bench
