#include "render/slf/response.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "render/reference/scattering.h"

namespace maquette {

namespace {

constexpr double kPi = 3.14159265358979323846;

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

LightResponse compute_response(const SurfacePoint& point, const Lumisphere& lumisphere, int samples) {
  const int bins = lumisphere.count();
  struct Incident {
    glm::vec3 direction;
    float weight;
  };
  std::vector<std::vector<Incident>> incident(static_cast<std::size_t>(bins));
  for (int k = 0; k < bins; ++k)
    for (int i = 0; i < samples * samples; ++i) {
      const glm::vec2 uv((static_cast<float>(i % samples) + 0.5f) / static_cast<float>(samples),
                         (static_cast<float>(i / samples) + 0.5f) / static_cast<float>(samples));
      const Lumisphere::Sample s = lumisphere.draw(k, uv);
      if (s.weight > 0.0f) incident[static_cast<std::size_t>(k)].push_back({s.direction, s.weight});
    }
  // The quadrature's weights sum to 1 in each bin, so that a white furnace stays exact.
  for (auto& bin : incident) {
    float sum = 0.0f;
    for (const Incident& s : bin) sum += s.weight;
    for (Incident& s : bin) s.weight /= sum;
  }
  LightResponse response;
  response.channels.fill(Eigen::MatrixXf::Zero(bins, bins));
  tbb::parallel_for(0, bins, [&](int j) {
    SurfacePoint p = point;
    p.wo = lumisphere.direction(j);
    for (int k = 0; k < bins; ++k) {
      glm::vec3 sum(0.0f);
      for (const Incident& s : incident[static_cast<std::size_t>(k)])
        sum += evaluate_brdf(p, prepare_brdf(p, s.direction)) * s.weight;
      sum *= static_cast<float>(lumisphere.projected(k));
      for (int c = 0; c < 3; ++c)
        response.channels[static_cast<std::size_t>(c)](j, k) = std::isfinite(sum[c]) ? sum[c] : 0.0f;
    }
  });
  return response;
}

double peak_half_width(const SurfacePoint& point) {
  constexpr int kSteps = 721;
  const double view = 0.25 * kPi;
  std::vector<double> values;
  for (int i = 0; i < kSteps; ++i) values.push_back(value_at(point, view, -0.49 * kPi + 0.98 * kPi * i / (kSteps - 1)));
  std::vector<double> sorted = values;
  std::nth_element(sorted.begin(), sorted.begin() + kSteps / 2, sorted.end());
  const double median = sorted[kSteps / 2];
  const auto top = static_cast<int>(std::max_element(values.begin(), values.end()) - values.begin());
  const double peak = values[static_cast<std::size_t>(top)];
  if (!(peak > kPeak * median)) return kPi;
  int low = top, high = top;
  while (low > 0 && values[static_cast<std::size_t>(low)] > 0.5 * (peak + median)) --low;
  while (high + 1 < kSteps && values[static_cast<std::size_t>(high)] > 0.5 * (peak + median)) ++high;
  return 0.5 * (high - low) * 0.98 * kPi / (kSteps - 1);
}

int lumisphere_side_for(double width) { return static_cast<int>(std::ceil(kBinsAPeak / std::max(width, 1e-3))); }

int response_samples(const SurfacePoint& point) {
  const double width = peak_half_width(point);
  return width > 0.3 ? 4 : width > 0.1 ? 8 : 16;
}

}  // namespace maquette
