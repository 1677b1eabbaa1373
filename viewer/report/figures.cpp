#include "viewer/report/figures.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "viewer/stats.h"

namespace maquette::report {

std::string scope_name(Scope scope) {
  static constexpr const char* kNames[] = {"estimator", "model", "reflection"};
  return kNames[static_cast<std::size_t>(scope)];
}

Scope scope_from_name(const std::string& name) {
  for (const Scope scope : kScopes)
    if (scope_name(scope) == name) return scope;
  throw std::out_of_range(name + " is no scope");
}

std::string error_title(Scope scope) {
  std::string title = scope_name(scope) + " error";
  title.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(title.front())));
  return title;
}
std::string metric_name(Metric metric) { return metric == Metric::flip ? "flip" : "relative_rmse"; }

Spread spread_of(std::vector<double> values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {median(values), *low, *high};
}

namespace {

std::optional<Spread> error_of(const Point& point, Metric metric) {
  if (metric == Metric::relative_rmse) return point.relative_rmse;
  if (!point.figures.flip) return std::nullopt;
  return Spread{*point.figures.flip, *point.figures.flip, *point.figures.flip};
}

/// Log-log charts cannot show zero.
constexpr double kLeastError = 1e-9;

}  // namespace

std::vector<Curve> curves_of(const Report& report, const std::string& camera, Scope scope, Metric metric) {
  std::vector<Curve> curves;
  for (const TechniqueEntry& technique : report.techniques) {
    Curve curve{technique.name, {}};
    std::vector<const Point*> points;
    for (const Point& point : report.points)
      if (point.camera == camera && point.scope == scope && point.technique == technique.name) points.push_back(&point);
    std::sort(points.begin(), points.end(), [](const Point* a, const Point* b) { return a->step < b->step; });
    for (const Point* point : points) {
      const std::optional<Spread> error = error_of(*point, metric);
      if (!error || !(error->median > kLeastError)) continue;
      curve.points.push_back({point->time_ms.median, error->median, point->time_ms.low, point->time_ms.high, error->low,
                              error->high, point->quality, point->below_noise, point->samples});
    }
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  }
  return curves;
}

std::vector<Curve> mean_curves(const Report& report, Scope scope, Metric metric) {
  std::vector<std::vector<Curve>> all;
  for (const CameraEntry& camera : report.cameras) all.push_back(curves_of(report, camera.name, scope, metric));
  std::vector<Curve> means;
  if (all.empty()) return means;
  const auto find_point = [](const std::vector<Curve>& curves, const std::string& technique,
                             const std::string& quality) -> const CurvePoint* {
    for (const Curve& curve : curves)
      for (const CurvePoint& point : curve.points)
        if (curve.technique == technique && point.quality == quality) return &point;
    return nullptr;
  };
  for (const Curve& first : all.front()) {
    Curve mean{first.technique, {}};
    for (const CurvePoint& point : first.points) {
      double time = 0.0, error = 0.0;
      bool everywhere = true;
      CurvePoint result;
      for (const std::vector<Curve>& curves : all) {
        const CurvePoint* other = find_point(curves, first.technique, point.quality);
        everywhere = everywhere && other != nullptr;
        if (!everywhere) break;
        time += std::log(other->time_ms);
        error += std::log(other->error);
        result.below_noise |= other->below_noise;
      }
      if (!everywhere) continue;
      const auto count = static_cast<double>(all.size());
      result.time_ms = result.time_low_ms = result.time_high_ms = std::exp(time / count);
      result.error = result.error_low = result.error_high = std::exp(error / count);
      result.quality = point.quality;
      result.samples = point.samples;
      mean.points.push_back(result);
    }
    if (!mean.points.empty()) means.push_back(std::move(mean));
  }
  return means;
}

std::vector<FrontPoint> pareto_front(const std::vector<Curve>& curves) {
  std::vector<FrontPoint> all;
  for (const Curve& curve : curves)
    for (const CurvePoint& point : curve.points)
      all.push_back({curve.technique, point.quality, point.time_ms, point.error});
  const double floor = noise_floor(curves);
  std::sort(all.begin(), all.end(), [](const FrontPoint& a, const FrontPoint& b) {
    return a.time_ms != b.time_ms ? a.time_ms < b.time_ms : a.error < b.error;
  });
  std::vector<FrontPoint> front;
  for (FrontPoint& point : all)
    if (front.empty() || std::max(point.error, floor) < std::max(front.back().error, floor))
      front.push_back(std::move(point));
  return front;
}

std::optional<double> time_to_error(const Curve& curve, double target, double floor) {
  if (target <= floor) return std::nullopt;
  std::vector<CurvePoint> points = curve.points;
  std::sort(points.begin(), points.end(),
            [](const CurvePoint& a, const CurvePoint& b) { return a.time_ms < b.time_ms; });
  const CurvePoint* best = nullptr;
  for (const CurvePoint& point : points) {
    if (best != nullptr && point.error >= best->error) continue;
    if (point.error <= target) {
      if (best == nullptr) return point.time_ms;
      const double share = std::log(best->error / target) / std::log(best->error / point.error);
      return best->time_ms * std::pow(point.time_ms / best->time_ms, share);
    }
    best = &point;
  }
  return std::nullopt;
}

double noise_floor(const std::vector<Curve>& curves) {
  double floor = 0.0;
  for (const Curve& curve : curves)
    for (const CurvePoint& point : curve.points)
      if (point.below_noise) floor = std::max(floor, point.error);
  return floor;
}

double best_error(const Curve& curve) {
  double best = std::numeric_limits<double>::infinity();
  for (const CurvePoint& point : curve.points) best = std::min(best, point.error);
  return best;
}

}  // namespace maquette::report
