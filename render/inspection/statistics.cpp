#include "render/inspection/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace maquette {

namespace {

/// 0.975 quantile of Student's t. Source: Abramowitz and Stegun 1964, Eq. 26.7.5 from the normal quantile; the first
/// few degrees of freedom, where the expansion is coarse, from the tables there.
double student_quantile(std::size_t degrees) {
  constexpr double kTable[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228};
  if (degrees >= 1 && degrees <= std::size(kTable)) return kTable[degrees - 1];
  constexpr double z = 1.959963985;
  const double v = static_cast<double>(degrees), z3 = z * z * z;
  return z + (z3 + z) / (4.0 * v) + (5.0 * z3 * z * z + 16.0 * z3 + 3.0 * z) / (96.0 * v * v);
}

}  // namespace

RegionStatistics region_statistics(std::vector<double> values, double threshold) {
  RegionStatistics r;
  r.count = values.size();
  if (values.empty()) return r;
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  r.min = values.front();
  r.max = values.back();
  r.median = 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  r.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double square = 0.0;
  for (const double v : values) square += (v - r.mean) * (v - r.mean);
  r.sigma = std::sqrt(square / n);
  r.share_over = static_cast<double>(values.end() - std::upper_bound(values.begin(), values.end(), threshold)) / n;
  return r;
}

Interval confidence_interval(const std::vector<double>& estimates) {
  if (estimates.size() < 2)
    return {estimates.empty() ? 0.0 : estimates.front(), std::numeric_limits<double>::infinity()};
  const auto n = static_cast<double>(estimates.size());
  const double mean = std::accumulate(estimates.begin(), estimates.end(), 0.0) / n;
  double square = 0.0;
  for (const double e : estimates) square += (e - mean) * (e - mean);
  return {mean, student_quantile(estimates.size() - 1) * std::sqrt(square / (n - 1.0) / n)};
}

}  // namespace maquette
