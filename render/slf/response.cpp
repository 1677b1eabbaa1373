#include "render/slf/response.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "render/reference/scattering.h"
#include "scenes/linear_algebra.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// A peak is what rises above so many times the median of the lobe.
constexpr double kPeak = 4.0;
/// GGX of alpha 0.25 has a peak of 0.32 rad half width: 16 bins a side resolve it (math notes: measured at 0.3).
constexpr double kBinsAPeak = 5.15;

double value_at(SurfacePoint point, double wo_rad, double wi_rad) {
  point.wo = glm::vec3(std::sin(wo_rad), 0.0, std::cos(wo_rad));
  const glm::vec3 wi(-std::sin(wi_rad), 0.0, std::cos(wi_rad));
  return static_cast<double>(luminance(evaluate_brdf(point, prepare_brdf(point, wi))));
}

}  // namespace

namespace {

/// [out][coefficient] towards `views`.
LightResponse integrate(const SurfacePoint& point, const DirectionSpline& spline, std::span<const glm::vec3> views,
                        int samples) {
  const Lumisphere& lumisphere = spline.lumisphere();
  const int bins = lumisphere.count();
  struct Incident {
    glm::vec3 direction{};
    float weight;
    std::array<DirectionSpline::Share, 9> shares;
  };
  std::vector<Incident> incident;
  for (int k = 0; k < bins; ++k)
    for (const DirectionSpline::BinSample& s : spline.bin_samples(k, samples))
      incident.push_back(
          {s.direction, s.weight * static_cast<float>(lumisphere.projected(k)), spline.shares(s.direction)});
  LightResponse response;
  response.channels.fill(Eigen::MatrixXf::Zero(static_cast<Eigen::Index>(views.size()), bins));
  parallel_for(std::size_t{0}, views.size(), [&](std::size_t j) {
    SurfacePoint p = point;
    p.wo = views[j];
    std::vector<glm::vec3> sums(static_cast<std::size_t>(bins), glm::vec3(0.0f));
    for (const Incident& s : incident) {
      const glm::vec3 value = evaluate_brdf(p, prepare_brdf(p, s.direction)) * s.weight;
      for (const DirectionSpline::Share& share : s.shares)
        sums[static_cast<std::size_t>(share.bin)] += value * share.weight;
    }
    for (int k = 0; k < bins; ++k)
      for (int c = 0; c < 3; ++c) {
        const float sum = sums[static_cast<std::size_t>(k)][c];
        response.channels[static_cast<std::size_t>(c)](static_cast<Eigen::Index>(j), k) =
            std::isfinite(sum) ? sum : 0.0f;
      }
  });
  return response;
}

}  // namespace

LightResponse compute_response(const SurfacePoint& point, const DirectionSpline& spline, int samples) {
  LightResponse response = integrate(point, spline, spline.views(), samples);
  const Eigen::MatrixXf light = spline.from_means(samples);
  for (Eigen::MatrixXf& channel : response.channels) channel = times(times(spline.fit(), channel), light);
  return response;
}

LightResponse compute_response_of_coefficients(const SurfacePoint& point, const DirectionSpline& spline, int samples) {
  return integrate(point, spline,
                   std::span(spline.views()).first(static_cast<std::size_t>(spline.lumisphere().count())), samples);
}

double peak_half_width(const SurfacePoint& point) {
  constexpr int kSteps = 721;
  const double view = 0.25 * std::numbers::pi;
  std::vector<double> values;
  for (int i = 0; i < kSteps; ++i)
    values.push_back(value_at(point, view, -0.49 * std::numbers::pi + 0.98 * std::numbers::pi * i / (kSteps - 1)));
  std::vector<double> sorted = values;
  std::nth_element(sorted.begin(), sorted.begin() + kSteps / 2, sorted.end());
  const double median = sorted[kSteps / 2];
  const auto top = static_cast<int>(std::max_element(values.begin(), values.end()) - values.begin());
  const double peak = values[static_cast<std::size_t>(top)];
  if (!(peak > kPeak * median)) return std::numbers::pi;
  int low = top, high = top;
  while (low > 0 && values[static_cast<std::size_t>(low)] > 0.5 * (peak + median)) --low;
  while (high + 1 < kSteps && values[static_cast<std::size_t>(high)] > 0.5 * (peak + median)) ++high;
  return 0.5 * (high - low) * 0.98 * std::numbers::pi / (kSteps - 1);
}

int lumisphere_side_for(double width) { return static_cast<int>(std::ceil(kBinsAPeak / std::max(width, 1e-3))); }

int response_samples(const SurfacePoint& point) {
  const double width = peak_half_width(point);
  return width > 0.3 ? 4 : width > 0.1 ? 8 : 16;
}

}  // namespace maquette
