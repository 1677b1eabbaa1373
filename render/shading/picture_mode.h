#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "render/frame/key.h"
#include "render/frame/request.h"
#include "render/scene_state/scene_state.h"
#include "scenes/image.h"

namespace maquette {

/// What a mode that draws whole pictures is handed in one frame.
struct PictureInput {
  const SceneState& scene;
  const FrameRequest& request;
  bool accumulate = false;
  /// In a window: the work goes on on a thread of its own, and a frame shows what there is so far.
  bool interactive = false;
};

/// A mode that draws whole pictures by rays of its own, without the G-buffer: it is no layer of a frame.
class PictureMode {
 public:
  virtual ~PictureMode() = default;
  /// Makes the picture of this frame.
  virtual void draw(const PictureInput& input) = 0;
  /// Linear RGBA, cd/m2; empty before the first.
  virtual const Image& picture() const = 0;
  /// RGB variance of its pixels, where it is known.
  virtual std::optional<Image> variance() const = 0;
  /// Frames in the picture; in a window its paths a pixel.
  virtual int frames() const = 0;
  virtual std::size_t covered_pixels() const = 0;
  virtual std::size_t samples() const = 0;
  /// Relative RMSE of the picture so far, where it is known.
  virtual std::optional<double> estimated_error() const = 0;
  /// How far it is from a picture worth comparing, in [0, 1]; nothing when it is there.
  virtual std::optional<double> progress() const = 0;
  virtual void add_counters(std::map<std::string, double>* counters) const = 0;
};

}  // namespace maquette
