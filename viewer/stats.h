#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/gl/context.h"
#include "render/metrics/metrics.h"
#include "render/renderer.h"
#include "viewer/options.h"

namespace maquette {

/// What `render` measured, for --stats.
struct RenderReport {
  std::vector<FrameStats> frames;         ///< the measured ones, at least one
  double total_s = 0.0;                   ///< from the first to the last of them
  double preparation_s = 0.0;             ///< what an accumulation's shaders and bakes took before
  std::optional<double> estimated_error;  ///< relative RMSE, from the frames themselves
  std::optional<ErrorFigures> error;      ///< against --reference
};

/// Median of the values (the mean of the middle two). Throws nothing; 0 without values.
double median(std::vector<double> values);

/// The JSON object of design: `scene`, `mode`, `size`, `timing_ms`, ... (docs/vocabulary.md), indented, with a final
/// newline.
std::string stats_json(const SceneOptions& options, const FrameRequest& request, const DeviceInfo& device,
                       const RenderReport& report);

}  // namespace maquette
