#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "render/metrics.h"
#include "render/frame/plan.h"

namespace maquette {

/// JSON has no infinity and no NaN: they become null, like absent values.
nlohmann::ordered_json number(double value);
nlohmann::ordered_json number(const std::optional<double>& value);
nlohmann::ordered_json plan_json(const FramePlan& plan);      ///< [{pass, reason}]
nlohmann::ordered_json left_out_json(const FramePlan& plan);  ///< [{what, why}]
nlohmann::ordered_json error_json(const ErrorFigures& figures);

}  // namespace maquette
