#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scenes/environment.h"
#include "scenes/scene.h"

/// Measured error against samples of one mode, and what an error budget asks of it.
namespace maquette {

struct BudgetPoint {
  int samples = 0;  ///< 0: the mode takes none
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

/// The fewest samples that keep the budget: log-log between the measured ones around it, at most to the last. Nothing
/// when no measured point keeps it or the mode takes no samples; `why` then says so in one line.
std::optional<BudgetPoint> choose_samples(const BudgetCurve& curve, double budget, std::string* why);

/// Curves of a report are kept in the cache for the window, by the scene as it looks (its materials after overrides)
/// and its environment.
std::uint64_t curves_key(const Scene& scene, const Environment& environment);
void store_curves(std::uint64_t key, const BudgetCurves& curves);
BudgetCurves load_curves(std::uint64_t key);

}  // namespace maquette
