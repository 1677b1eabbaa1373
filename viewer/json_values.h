#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "render/frame/plan.h"
#include "render/metrics/metrics.h"

namespace maquette {

/// JSON has no infinity and no NaN: they become null, like absent values.
nlohmann::ordered_json number(double value);
nlohmann::ordered_json number(const std::optional<double>& value);
nlohmann::ordered_json plan_json(const FramePlan& plan);      ///< [{pass, reason}]
nlohmann::ordered_json left_out_json(const FramePlan& plan);  ///< [{what, why}]
/// What the frame could do: {bakes: {name: {state, progress}}, frames_before, ...}.
nlohmann::ordered_json status_json(const FrameStatus& status);
/// [{pass, why}]: planned, and not needed in the frame.
nlohmann::ordered_json skipped_json(const FramePlan& plan, const std::vector<SkippedPass>& skipped);
/// {node: mode}, `*` for all that no other names.
nlohmann::ordered_json modes_json(const FramePlan& plan);
nlohmann::ordered_json error_json(const ErrorFigures& figures);

}  // namespace maquette
