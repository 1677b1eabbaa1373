#pragma once

#include <string>

#include "viewer/report/data.h"

namespace maquette::report {

/// Errors whose time is tabulated for each technique.
inline constexpr double kRelativeTargets[] = {0.5, 0.2, 0.1, 0.05, 0.02, 0.01};
inline constexpr double kFlipTargets[] = {0.2, 0.1, 0.05, 0.02};

/// Everything, with the Pareto fronts and the times to an error. Ends with a newline.
std::string report_json_text(const Report& report);
/// One line a point. RFC 4180.
std::string report_csv_text(const Report& report);

}  // namespace maquette::report
