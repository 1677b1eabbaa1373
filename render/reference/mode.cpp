#include "render/reference/mode.h"

#include <algorithm>
#include <chrono>

#include "render/reference/worker.h"
#include "render/shading/shading_mode.h"

namespace maquette {

namespace {

/// In a window: how long a frame waits for the first picture of a new view, and for a better one.
constexpr std::chrono::milliseconds kFirstPatience{200}, kPatience{50};

PictureRequest picture_request(const FrameRequest& request) {
  PictureRequest r;
  r.camera = request.camera;
  r.width = request.width;
  r.height = request.height;
  r.msaa = request.msaa;
  r.seed = request.seed;
  r.paths.transport =
      request.settings.get_string("reference.transport") == "direct" ? Transport::direct : Transport::full;
  r.paths.env_rotation_rad = request.env_rotation_rad;
  r.paths.env_scale = request.env_scale;
  r.paths.max_bounces = request.settings.get_int("reference.bounces");
  r.adaptive = request.settings.get_bool("reference.adaptive");
  return r;
}

/// Deadlines say when to stop for now, not what the picture is.
FrameRequest without_deadline(FrameRequest request) {
  request.deadline.reset();
  return request;
}

class ReferenceMode : public PictureMode {
 public:
  void draw(const PictureInput& input) override {
    if (input.interactive)
      watch(input);
    else
      trace(input);
    request_ = without_deadline(input.request);
    interactive_ = input.interactive;
  }
  const Image& picture() const override { return shown_.mean; }
  std::optional<Image> variance() const override {
    if (!picture_) return std::nullopt;
    return picture_->variance();
  }
  int frames() const override { return frames_; }
  std::size_t covered_pixels() const override { return shown_.counts.covered_pixels; }
  std::size_t samples() const override { return shown_.counts.paths; }
  std::optional<double> estimated_error() const override {
    if (shown_.relative_error > 0.0) return shown_.relative_error;
    return std::nullopt;
  }
  std::optional<double> progress() const override {
    // So few paths are too noisy to be metered.
    constexpr int kFirstPaths = 4;
    if (!interactive_ || shown_.mean.width == 0 || shown_.paths >= kFirstPaths) return std::nullopt;
    return static_cast<double>(shown_.paths) / kFirstPaths;
  }
  void add_counters(std::map<std::string, double>* counters) const override {
    (*counters)["paths"] = static_cast<double>(shown_.counts.paths);
    (*counters)["rays"] = static_cast<double>(shown_.counts.rays);
  }

 private:
  /// Traces as many paths more as are asked for, and waits for them.
  void trace(const PictureInput& input) {
    const Key scene = input.scene.revisions().all();
    if (!scene_ || scene_of_ != scene) {
      const Scene edited = input.scene.edited_scene();
      picture_.reset();
      scene_ = build_path_scene({.scene = edited,
                                 .environment = input.scene.environment().shared_environment(),
                                 .variant = input.request.variant,
                                 .geometry = &input.scene.geometry(),
                                 .library = &library_});
      scene_of_ = scene;
    }
    if (!picture_ || !input.accumulate || !(request_ == without_deadline(input.request))) {
      picture_.emplace(scene_, picture_request(input.request));
      frames_ = 0;
    }
    picture_->add(asked_samples(input.request, "reference.samples"), {}, {}, input.request.deadline);
    ++frames_;
    shown_ = {picture_->mean(), picture_->samples(), picture_->relative_error(), picture_->counts()};
  }
  /// Shows what the worker has, and sees that it works on what is asked.
  void watch(const PictureInput& input) {
    const bool first = !worker_;
    if (first) worker_ = std::make_unique<ReferenceWorker>();
    const Key scene = input.scene.revisions().all();
    const bool other_scene = first || scene_of_ != scene;
    const bool changed = other_scene || !(request_ == without_deadline(input.request));
    if (changed) {
      ReferenceWorker::Job job;
      if (other_scene) {
        job.scene = std::make_shared<const Scene>(input.scene.edited_scene());
        job.geometry = std::make_shared<const FlatGeometry>(input.scene.geometry());
        job.environment = input.scene.environment().shared_environment();
        job.variant = input.request.variant;
      }
      job.picture = picture_request(input.request);
      scene_of_ = scene;
      worker_->submit(std::move(job));
    }
    if (auto newest = worker_->take(changed ? kFirstPatience : kPatience))
      shown_ = std::move(*newest);
    else if (changed)
      shown_.paths = 0;  // the old picture stays until there is one
    if (shown_.mean.width == 0) shown_.mean = Image(input.request.width, input.request.height, 4);
    frames_ = std::max(shown_.paths, 1);
  }

  FrameRequest request_;
  std::optional<Key> scene_of_;  ///< what it traces
  ReferenceWorker::Update shown_;
  int frames_ = 0;
  bool interactive_ = false;
  // In batch:
  std::shared_ptr<const PathScene> scene_;
  MeasuredLibrary library_;
  std::optional<ReferencePicture> picture_;
  // In a window:
  std::unique_ptr<ReferenceWorker> worker_;
};

}  // namespace

std::unique_ptr<PictureMode> make_reference_mode() { return std::make_unique<ReferenceMode>(); }

}  // namespace maquette
