#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scenes/environment.h"
#include "scenes/scene.h"

/// Measured error against samples of one mode, and the samples for an error budget.
namespace maquette {

struct BudgetPoint {
  int samples = 0;  ///< 0: the mode does not sample
  double time_ms = 0.0;
  double error = 0.0;  ///< relative RMSE
};
struct BudgetCurve {
  std::string source;  ///< where it was measured, for the user
  std::vector<BudgetPoint> points;
};
/// By mode and scope, see curve_name.
using BudgetCurves = std::map<std::string, BudgetCurve>;
std::string curve_name(const std::string& mode, bool all_light);

/// The fewest samples that keep the budget: interpolated log-log between measured points, not extrapolated. Nothing
/// when no measured point keeps it or the mode does not sample; `why` then says so in one line.
std::optional<BudgetPoint> samples_for_budget(const BudgetCurve& curve, double budget, std::string* why);

/// Curves of a report are stored in the cache for the window. Their key: the scene with its materials after overrides,
/// and its environment.
std::uint64_t curves_key(const Scene& scene, const Environment& environment);
void store_curves(std::uint64_t key, const BudgetCurves& curves);
BudgetCurves load_curves(std::uint64_t key);

}  // namespace maquette
