#include "render/materials/lobes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/materials/brdf_sampler.h"
#include "render/materials/symmetric_brdf.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kSamples = 512, kMedianSamples = 127;

/// Golden-ratio recurrence in two dimensions (Roberts 2018).
glm::vec2 point_of_unit_square(int k) {
  return {static_cast<float>(std::fmod(0.5 + k * 0.7548776662466927, 1.0)),
          static_cast<float>(std::fmod(0.5 + k * 0.5698402909980532, 1.0))};
}

/// Median of each channel of f over cosine-weighted directions.
glm::dvec3 median_of(const BrdfTable& brdf, const glm::dvec3& wo) {
  std::array<std::array<double, kMedianSamples>, 3> values;
  for (int k = 0; k < kMedianSamples; ++k) {
    const glm::dvec2 u(point_of_unit_square(k));
    const double phi = 2.0 * std::numbers::pi * u.y, r = std::sqrt(u.x);
    const glm::dvec3 f = evaluate_brdf(brdf, {r * std::cos(phi), r * std::sin(phi), std::sqrt(1.0 - u.x)}, wo);
    for (int c = 0; c < 3; ++c) values[static_cast<std::size_t>(c)][static_cast<std::size_t>(k)] = f[c];
  }
  glm::dvec3 median{};
  for (int c = 0; c < 3; ++c) {
    auto& channel = values[static_cast<std::size_t>(c)];
    std::nth_element(channel.begin(), channel.begin() + kMedianSamples / 2, channel.end());
    median[c] = channel[kMedianSamples / 2];
  }
  return median;
}

struct LobeSample {
  glm::dvec3 direction{};
  glm::dvec3 whole{}, mirror{};  ///< f cos / pdf
};

double luminance_of(const glm::dvec3& v) { return static_cast<double>(luminance(glm::vec3(v))); }

/// Mean direction of the samples, weighted by `part`. By mirror symmetry it lies in the plane of view and normal.
glm::dvec3 mean_direction(const std::vector<LobeSample>& samples, glm::dvec3 LobeSample::*part) {
  glm::dvec3 sum(0.0);
  double weight = 0.0;
  for (const LobeSample& s : samples) {
    const double y = luminance_of(s.*part);
    sum += y * s.direction;
    weight += y;
  }
  return weight > 0.0 ? glm::dvec3(sum.x, 0.0, sum.z) / weight : glm::dvec3(0.0, 0.0, 2.0 / 3.0);
}

/// Angle about `axis` that contains half of the mirrored light.
double half_angle(const std::vector<LobeSample>& samples, const glm::dvec3& axis) {
  std::vector<glm::dvec2> weighed;  // angle, weight
  double sum = 0.0;
  for (const LobeSample& s : samples) {
    weighed.emplace_back(std::acos(std::clamp(glm::dot(axis, s.direction), -1.0, 1.0)), luminance_of(s.mirror));
    sum += weighed.back().y;
  }
  if (!(sum > 0.0)) return kHalfPi;
  std::sort(weighed.begin(), weighed.end(), [](const glm::dvec2& a, const glm::dvec2& b) { return a.x < b.x; });
  double passed = 0.0;
  for (const glm::dvec2& w : weighed) {
    passed += w.y;
    if (passed >= 0.5 * sum) return w.x;
  }
  return kHalfPi;
}

BrdfLobe lobe_at(const BrdfTable& brdf, const BrdfTables& tables, int i) {
  shared::BrdfSampler sampler(tables);
  const double theta = std::min(i * kHalfPi / (kAlbedoCount - 1), kHalfPi - 1e-3);
  const glm::dvec3 wo(std::sin(theta), 0.0, std::cos(theta));
  const glm::dvec3 floor = median_of(brdf, wo);
  std::vector<LobeSample> samples;
  glm::dvec3 whole(0.0), mirror(0.0);
  for (int k = 0; k < kSamples; ++k) {
    const auto s = sampler.sample_brdf(glm::vec3(wo), point_of_unit_square(k));
    if (!(s.pdf > 0.0f)) continue;
    const glm::dvec3 f = evaluate_brdf(brdf, glm::dvec3(s.wi), wo);
    const double weight = static_cast<double>(s.wi.z / s.pdf);
    samples.push_back({glm::dvec3(s.wi), weight * f, weight * glm::max(f - floor, 0.0)});
    whole += samples.back().whole;
    mirror += samples.back().mirror;
  }
  BrdfLobe lobe;
  lobe.direction = glm::vec3(mean_direction(samples, &LobeSample::whole));
  if (luminance_of(mirror) < 1e-4 * luminance_of(whole)) return lobe;  // only rounding errors
  const glm::dvec3 towards = mean_direction(samples, &LobeSample::mirror);
  lobe.mirror_direction = glm::vec3(towards);
  lobe.mirror_half_angle_rad = static_cast<float>(half_angle(samples, glm::normalize(towards)));
  // Splits the exact albedo in the ratio of the sampled ones.
  for (int c = 0; c < 3; ++c)
    lobe.mirror_albedo[c] =
        whole[c] > 0.0 ? static_cast<float>(mirror[c] / whole[c]) * tables.albedo[static_cast<std::size_t>(i)][c]
                       : 0.0f;
  return lobe;
}

}  // namespace

std::vector<BrdfLobe> compute_lobes(const BrdfTable& brdf, const BrdfTables& tables) {
  std::vector<BrdfLobe> lobes(kAlbedoCount);
  parallel_for(0, kAlbedoCount, [&](int i) { lobes[static_cast<std::size_t>(i)] = lobe_at(brdf, tables, i); });
  return lobes;
}

float mirror_roughness(const std::vector<BrdfLobe>& lobes) {
  constexpr std::size_t kView = 25;
  return std::sqrt(std::tan(std::min(0.5f * lobes[kView].mirror_half_angle_rad, 0.78539816f)));
}

}  // namespace maquette
