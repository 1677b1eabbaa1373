#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/frame/frame.h"
#include "render/frame/plan.h"

namespace maquette {

struct FrameStats {
  double frame_ms = 0.0;
  FramePlan plan;
  FrameStatus status;                ///< that the plan was made with
  std::vector<PassTime> passes;      ///< of the plan, those that were carried out
  std::vector<SkippedPass> skipped;  ///< and those that were not needed
  std::map<std::string, std::size_t> gpu_bytes;
  std::size_t visible_pixels = 0;
  std::size_t shaded_pixels = 0;
  std::size_t shading_samples = 0;
  int accumulated_frames = 1;  ///< frames averaged in the picture: grows while nothing moves
  std::map<std::string, double> technique;
  std::map<int, std::string> fits;  ///< by node: the patches that stand for a curved mirror, and how far they are off
  std::optional<double> estimated_error;  ///< relative RMSE of the picture so far, where the mode itself knows it
};

/// Called with every frame that a Renderer draws, so that tests can hold all of them against their plan. Null: nobody
/// looks.
inline std::function<void(const FrameStats&)> frame_observer;

}  // namespace maquette
