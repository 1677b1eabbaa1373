#pragma once

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <optional>

#include "render/gl/objects.h"
#include "ui/inspection_state.h"
#include "ui/layout.h"
#include "viewer/measure/measurement.h"
#include "viewer/measure/traced_layers.h"
#include "viewer/window_picture.h"
#include "viewer/window_session.h"

namespace maquette {

template <typename T>
bool is_ready(const std::future<T>& future) {
  return future.valid() && future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

/// The inspection tab's part of the window: probe under the mouse, false colours, regions, sweeps and files. Rays and
/// paths run on threads of their own; only the picture's luminances are read from the renderer.
class WindowInspection {
 public:
  WindowInspection() = default;
  ~WindowInspection();
  WindowInspection(const WindowInspection&) = delete;
  WindowInspection& operator=(const WindowInspection&) = delete;

  /// `mouse`: in window units.
  void update(WindowSession* session, const WindowPicture& picture, const Rect& rect, glm::vec2 mouse, double now_s);
  void fill_facts(const WindowSession& session, InspectionFacts* facts) const;
  void carry_out(const InspectionActions& actions, WindowSession* session);
  /// Over the picture, behind the panels: between ImGui::NewFrame and Render.
  void draw_overlay(const WindowSession& session, const Rect& picture);

 private:
  /// The scene as the path tracer sees it.
  struct Traced {
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const Environment> environment;
    std::shared_ptr<const PathScene> paths;
  };
  /// A sweep or an export in work.
  struct Job {
    std::string what;
    bool exports = false;
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    std::atomic<float> share{0.0f};
    std::atomic<bool> cancel{false};
    std::future<Measurement> result;
  };
  struct RegionJob {
    std::vector<InspectedRegion> regions;
    std::vector<InspectionFacts::Region> values;
  };

  void take_scene(WindowSession* session, const WindowPicture& picture);
  void read_picture(WindowSession* session, const WindowPicture& picture, double now_s);
  void forget_probe();
  void probe(const WindowSession& session, const WindowPicture& picture, const Rect& rect, glm::vec2 mouse);
  void measure_regions(const WindowSession& session, const WindowPicture& picture);
  void start_job(WindowSession* session, bool exports);
  void finish_job(WindowSession* session);
  void update_texture(const InspectionView& view);
  void draw_probe(const Rect& picture) const;

  std::uint64_t revision_ = ~std::uint64_t{0};
  std::future<Traced> tracing_;
  std::optional<Traced> traced_;
  FrameRequest seen_;
  Image picture_;
  double read_s_ = -1e9;
  int read_frames_ = 0;
  glm::ivec2 probed_px_{-1};
  std::vector<std::pair<std::string, std::string>> probe_;
  std::future<RegionJob> region_job_;
  RegionJob regions_;
  FrameRequest regions_of_;
  InspectionSetup regions_setup_, probed_setup_;
  std::unique_ptr<Job> job_;
  std::vector<float> sweep_x_, sweep_y_;
  bool sweep_of_ghost_ = false;  ///< `sweep_y_` are arc minutes, else cd/m2
  std::string sweep_title_, status_, sun_;
  std::vector<std::pair<std::string, std::string>> worst_;
  Texture colors_;
  bool colors_stale_ = true;
  InspectionView colors_of_;
};

}  // namespace maquette
