#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "render/bake/background_worker.h"
#include "render/frame/camera.h"
#include "render/reference/reference.h"
#include "scenes/image.h"

namespace maquette {

/// The pixels of a picture that a smaller reference is traced through: every `factor`-th of a middle part, their
/// centres exactly.
struct PixelGrid {
  int factor = 1;             ///< odd
  int x = 0, y = 0;           ///< first pixel of the part
  int width = 1, height = 1;  ///< of the grid
  int pixel_x(int column) const { return x + column * factor + factor / 2; }
  int pixel_y(int row) const { return y + row * factor + factor / 2; }
};
/// About `columns` wide, over nearly all of the picture.
PixelGrid make_pixel_grid(int width, int height, int columns);
/// The camera whose picture of the grid's size has its rays through the grid's pixels.
CameraView grid_camera(const CameraView& camera, const PixelGrid& grid, int height);

/// What was traced so far: two pictures of independent seeds.
struct GridReference {
  PixelGrid grid;
  Image halves[2];
  int paths = 0;         ///< a pixel, both halves
  double seconds = 0.0;  ///< that they took, on few cores
};

struct MeteredError {
  double error = 0.0;            ///< relative RMSE over the grid's surface pixels
  double low = 0.0, high = 0.0;  ///< 95 % interval, of the choice of pixels and of the reference's noise
  int pixels = 0;
  Image map;  ///< of the grid: relative error of each pixel, with the noise that it has; -1 where nothing is compared
};
/// Nothing when no surface is seen or the reference is black. The square of the error is the mean of the products of
/// the differences to both halves: without bias from the reference's noise.
std::optional<MeteredError> meter_error(const Image& picture, const GridReference& reference);

/// Relative RMSE that a picture of this many paths a pixel would have by its noise alone, over the grid's surface
/// pixels; from the difference of the halves.
double reference_noise(const GridReference& reference, double paths);
/// Paths a pixel that the reference would trace of a whole picture in this time, on all cores.
double reference_paths(const GridReference& reference, double seconds, int width, int height);

/// Traces references of the resting view on a thread of its own with few cores: coarse first, then finer. Deterministic
/// for a view but for how far it comes.
class ErrorMeter {
 public:
  using SceneMaker = std::function<std::shared_ptr<const PathScene>()>;
  struct View {
    CameraView camera;
    int width = 1, height = 1;
    PathOptions paths;
    std::uint64_t scene_revision = 0;
    bool operator==(const View&) const;
  };

  ErrorMeter()
      : worker_([this](const Job& job, const BackgroundTask<GridReference>& task) {
          trace(job, task);
          return std::nullopt;
        }) {}

  /// Begins with a view and says so, unless it is at it already. `make_scene` runs on the thread when the scene's
  /// revision is a new one.
  bool watch(const View& view, const SceneMaker& make_scene);
  /// Ends the work at once; results are forgotten. Does not wait.
  void cancel();
  /// The newest result of the view being watched; `version` grows with each.
  std::shared_ptr<const GridReference> newest(std::uint64_t* version);
  /// What went wrong, when `newest` was asked last; empty: nothing.
  const std::string& problem() const { return problem_; }
  bool watching() const { return watched_.has_value(); }

 private:
  struct Job {
    View view;
    SceneMaker make_scene;
  };
  void trace(const Job& job, const BackgroundTask<GridReference>& task);

  std::optional<View> watched_;
  std::shared_ptr<const GridReference> newest_;
  std::uint64_t version_ = 0;
  std::string problem_;
  // Of the worker's thread alone:
  std::shared_ptr<const PathScene> scene_;
  std::uint64_t scene_revision_ = 0;
  BackgroundWorker<Job, GridReference> worker_;  // last: it uses all of the above
};

}  // namespace maquette
