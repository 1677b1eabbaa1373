#pragma once

#include <optional>
#include <string>
#include <vector>

#include "viewer/report/data.h"

/// Curves, Pareto fronts and times to an error, from the measured points.
namespace maquette::report {

enum class Metric { relative_rmse, flip };
std::string metric_name(Metric metric);
/// `Estimator error`.
std::string error_title(Scope scope);

/// One technique's points of one camera and scope, or their mean over cameras.
struct CurvePoint {
  double time_ms = 0.0;
  double error = 0.0;
  double time_low_ms = 0.0, time_high_ms = 0.0, error_low = 0.0, error_high = 0.0;
  std::string quality;
  bool below_noise = false;
  int samples = 0;
};
struct Curve {
  std::string technique;
  std::vector<CurvePoint> points;  ///< in the order of the quality steps
};

/// Curves with at least one point, in the order of the report's techniques. Points without the metric are left out.
std::vector<Curve> curves_of(const Report& report, const std::string& camera, Scope scope, Metric metric);
/// Geometric mean of time and error over all cameras, at the qualities that every camera has.
std::vector<Curve> mean_curves(const Report& report, Scope scope, Metric metric);

/// Time and error of the points that no other point beats in both, fastest first.
struct FrontPoint {
  std::string technique, quality;
  double time_ms = 0.0, error = 0.0;
};
/// Errors within the reference's noise count as equal: of those the fastest alone is in the front.
std::vector<FrontPoint> pareto_front(const std::vector<Curve>& curves);

/// Time at which the best error so far falls to `target`: interpolated log-log between the two points around it. The
/// first point's time if its error is low enough already; nothing if no point's is, or if `target` is not above
/// `floor`.
std::optional<double> time_to_error(const Curve& curve, double target, double floor = 0.0);
double best_error(const Curve& curve);
/// Largest error of a point that the reference's noise hides: what is smaller cannot be ranked. 0: nothing is hidden.
double noise_floor(const std::vector<Curve>& curves);

}  // namespace maquette::report
