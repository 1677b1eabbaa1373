#include "render/metrics/flip_filters.h"

#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>

namespace maquette::flip {
namespace {

/// The two Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b) of a channel, x in degrees.
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> kSensitivities = {
    {{1.0, 0.0047, 0.0, 1e-5}, {1.0, 0.0053, 0.0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};
constexpr double kWidest = 0.04;         // the largest b; it determines the support of all kernels
constexpr double kFeatureWidth = 0.082;  // degrees

std::vector<double> gaussian_taps(int radius, double pixels_per_degree, double b) {
  std::vector<double> taps;
  for (int i = -radius; i <= radius; ++i) {
    const double x = i / pixels_per_degree;
    taps.push_back(std::exp(-std::numbers::pi * std::numbers::pi * x * x / b));
  }
  return taps;
}

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

Kernel scaled(const std::vector<double>& taps, double scale) {
  Kernel kernel;
  for (const double tap : taps) kernel.push_back(static_cast<float>(tap * scale));
  return kernel;
}

/// `shape(x)` at the taps; positive and negative weights are normalised separately, to 1 and -1.
Kernel balanced(int radius, const std::function<double(double)>& shape) {
  std::vector<double> taps;
  double positive = 0.0, negative = 0.0;
  for (int i = -radius; i <= radius; ++i) {
    taps.push_back(shape(i));
    (taps.back() > 0.0 ? positive : negative) += std::abs(taps.back());
  }
  Kernel kernel;
  for (const double tap : taps) {
    const double weight = tap > 0.0 ? positive : negative;
    kernel.push_back(weight > 0.0 ? static_cast<float>(tap / weight) : 0.0f);
  }
  return kernel;
}

}  // namespace

std::array<SpatialFilter, 3> spatial_filters(double pixels_per_degree) {
  const double widest_sigma = std::sqrt(kWidest / (2.0 * std::numbers::pi * std::numbers::pi));
  const int radius = static_cast<int>(std::ceil(3.0 * widest_sigma * pixels_per_degree));
  std::array<SpatialFilter, 3> filters;
  for (std::size_t c = 0; c < 3; ++c) {
    const Sensitivity& s = kSensitivities[c];
    const std::vector<double> first = gaussian_taps(radius, pixels_per_degree, s.b1);
    const std::vector<double> second = gaussian_taps(radius, pixels_per_degree, s.b2);
    const double sum1 = sum(first), sum2 = sum(second);
    // In two dimensions the weight of a Gaussian is the square of its taps' sum.
    const double weight1 = s.a1 * std::sqrt(std::numbers::pi / s.b1) * sum1 * sum1;
    const double weight2 = s.a2 * std::sqrt(std::numbers::pi / s.b2) * sum2 * sum2;
    const double total = weight1 + weight2;
    filters[c].first = scaled(first, std::sqrt(weight1 / total) / sum1);
    if (s.a2 > 0.0) filters[c].second = scaled(second, std::sqrt(weight2 / total) / sum2);
  }
  return filters;
}

Plane apply(const SpatialFilter& filter, const Plane& plane) {
  Plane result = convolve(plane, filter.first, filter.first);
  if (filter.second.empty()) return result;
  const Plane second = convolve(plane, filter.second, filter.second);
  for (std::size_t i = 0; i < result.data.size(); ++i) result.data[i] += second.data[i];
  return result;
}

FeatureFilters feature_filters(double pixels_per_degree) {
  const double sigma = 0.5 * kFeatureWidth * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3.0 * sigma));
  const auto gaussian = [&](double x) { return std::exp(-x * x / (2.0 * sigma * sigma)); };
  FeatureFilters filters;
  filters.gaussian = balanced(radius, gaussian);
  filters.edge = balanced(radius, [&](double x) { return -x * gaussian(x); });
  filters.point = balanced(radius, [&](double x) { return (x * x / (sigma * sigma) - 1.0) * gaussian(x); });
  return filters;
}

}  // namespace maquette::flip
