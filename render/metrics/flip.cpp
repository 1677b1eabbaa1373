#include "render/metrics/flip.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <mutex>
#include <numbers>
#include <utility>
#include <vector>

#include "render/metrics/flip_filters.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {
namespace {

// Source of all constants: Andersson et al. 2020, Section 4.
constexpr float kColorExponent = 0.7f;    // q_c
constexpr float kFeatureExponent = 0.5f;  // q_f
constexpr float kKneeIn = 0.4f;           // p_c
constexpr float kKneeOut = 0.95f;         // p_t

/// Linear Rec.709 to CIE XYZ with white D65, from the primaries. Source: IEC 61966-2-1.
const glm::mat3 kXyzFromRgb(0.4124564f, 0.2126729f, 0.0193339f, 0.3575761f, 0.7151522f, 0.1191920f, 0.1804375f,
                            0.0721750f, 0.9503041f);
const glm::vec3 kWhite = kXyzFromRgb * glm::vec3(1.0f);
const glm::mat3 kRgbFromXyz = glm::inverse(kXyzFromRgb);

/// Linearised CIELAB, in which filters may be applied. Source: Andersson et al. 2020, Eq. 1 (YCxCz).
glm::vec3 opponent_from_rgb(const glm::vec3& rgb) {
  const glm::vec3 n = (kXyzFromRgb * rgb) / kWhite;
  return {116.0f * n.y - 16.0f, 500.0f * (n.x - n.y), 200.0f * (n.y - n.z)};
}

glm::vec3 rgb_from_opponent(const glm::vec3& v) {
  const float y = (v.x + 16.0f) / 116.0f;
  return kRgbFromXyz * (glm::vec3(y + v.y / 500.0f, y, y - v.z / 200.0f) * kWhite);
}

float lab_curve(float t) {
  constexpr float kDelta = 6.0f / 29.0f;
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0f * kDelta * kDelta) + 4.0f / 29.0f;
}

/// CIELAB with chroma reduced in the dark. Source: Andersson et al. 2020, Eq. 5 (Hunt's effect).
glm::vec3 hunt_lab_from_rgb(const glm::vec3& rgb) {
  const glm::vec3 n = (kXyzFromRgb * rgb) / kWhite;
  const float x = lab_curve(n.x), y = lab_curve(n.y), z = lab_curve(n.z);
  const float lightness = 116.0f * y - 16.0f;
  return {lightness, 0.01f * lightness * 500.0f * (x - y), 0.01f * lightness * 200.0f * (y - z)};
}

/// City block distance in lightness, Euclidean in chroma. Source: Abasi et al. 2020; Andersson et al. 2020, Eq. 6.
float hyab(const glm::vec3& a, const glm::vec3& b) {
  const glm::vec3 d = a - b;
  return std::abs(d.x) + std::sqrt(d.y * d.y + d.z * d.z);
}

/// The largest possible distance of two displayed colours (green and blue), to the power of q_c.
float largest_color_error() {
  static const float kLargest =
      std::pow(hyab(hunt_lab_from_rgb(glm::vec3(0.0f, 1.0f, 0.0f)), hunt_lab_from_rgb(glm::vec3(0.0f, 0.0f, 1.0f))),
               kColorExponent);
  return kLargest;
}

/// Most of [0, 1] is given to the lower part of the range. Source: Andersson et al. 2020, Section 4.1.3.
float redistribute(float error) {
  const float largest = largest_color_error(), knee = kKneeIn * largest;
  const float mapped =
      error < knee ? kKneeOut / knee * error : kKneeOut + (error - knee) / (largest - knee) * (1.0f - kKneeOut);
  return std::clamp(mapped, 0.0f, 1.0f);
}

struct Filters {
  explicit Filters(double pixels_per_degree)
      : spatial(flip::spatial_filters(pixels_per_degree)), feature(flip::feature_filters(pixels_per_degree)) {}
  std::array<flip::SpatialFilter, 3> spatial;
  flip::FeatureFilters feature;
};

/// What the metric compares: filtered colours, and the strength of edges and points.
struct Perceived {
  Planes lab;
  Plane edges, points;
};

Plane length(const Plane& x, const Plane& y) {
  Plane result(x.width, x.height);
  for (std::size_t i = 0; i < result.data.size(); ++i)
    result.data[i] = std::sqrt(x.data[i] * x.data[i] + y.data[i] * y.data[i]);
  return result;
}

Perceived perceive(Planes rgb, const Filters& filters) {
  Plane lightness(rgb[0].width, rgb[0].height);
  const std::size_t count = lightness.data.size();
  Planes& opponent = rgb;  // in place: large pictures have many planes
  for (std::size_t i = 0; i < count; ++i) {
    const glm::vec3 v = opponent_from_rgb({rgb[0].data[i], rgb[1].data[i], rgb[2].data[i]});
    for (int c = 0; c < 3; ++c) opponent[static_cast<std::size_t>(c)].data[i] = v[c];
    lightness.data[i] = (v.x + 16.0f) / 116.0f;
  }
  Perceived seen;
  for (std::size_t c = 0; c < 3; ++c) seen.lab[c] = flip::apply(filters.spatial[c], std::exchange(opponent[c], {}));
  for (std::size_t i = 0; i < count; ++i) {
    const glm::vec3 filtered = rgb_from_opponent({seen.lab[0].data[i], seen.lab[1].data[i], seen.lab[2].data[i]});
    const glm::vec3 lab = hunt_lab_from_rgb(glm::clamp(filtered, glm::vec3(0.0f), glm::vec3(1.0f)));
    for (int c = 0; c < 3; ++c) seen.lab[static_cast<std::size_t>(c)].data[i] = lab[c];
  }
  const flip::FeatureFilters& f = filters.feature;
  seen.edges = length(convolve(lightness, f.edge, f.gaussian), convolve(lightness, f.gaussian, f.edge));
  seen.points = length(convolve(lightness, f.point, f.gaussian), convolve(lightness, f.gaussian, f.point));
  return seen;
}

/// Source: Andersson et al. 2020, Eqs. 7 to 10.
Image difference(const Perceived& a, const Perceived& b) {
  Image map(a.edges.width, a.edges.height, 1);
  for (std::size_t i = 0; i < map.data.size(); ++i) {
    const float distance = hyab({a.lab[0].data[i], a.lab[1].data[i], a.lab[2].data[i]},
                                {b.lab[0].data[i], b.lab[1].data[i], b.lab[2].data[i]});
    const float color = redistribute(std::pow(distance, kColorExponent));
    const float feature =
        std::pow(std::max(std::abs(a.edges.data[i] - b.edges.data[i]), std::abs(a.points.data[i] - b.points.data[i])) /
                     std::numbers::sqrt2_v<float>,
                 kFeatureExponent);
    map.data[i] = std::pow(color, 1.0f - std::min(feature, 1.0f));
  }
  return map;
}

/// Rational tone curve of HDR-FLIP. Source: Narkowicz 2016 (ACES fit) times the exposure bias 0.6; Andersson et al.
/// 2021, Section 3.
constexpr double kCurve[] = {0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};
constexpr double kShownAt = 0.85;
constexpr int kMaxExposures = 48;

float film(float x) {
  const auto k = [](int i) { return static_cast<float>(kCurve[i]); };
  return std::clamp((k(0) * x * x + k(1) * x + k(2)) / (k(3) * x * x + k(4) * x + k(5)), 0.0f, 1.0f);
}

/// The x with film(x) = kShownAt: positive root of a quadratic.
double shown_at() {
  const double a = kCurve[0] - kShownAt * kCurve[3], b = kCurve[1] - kShownAt * kCurve[4],
               c = kCurve[2] - kShownAt * kCurve[5];
  return (-b + std::sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
}

Planes planes_of(const Image& image, const auto& value) {
  Planes planes = {Plane(image.width, image.height), Plane(image.width, image.height),
                   Plane(image.width, image.height)};
  const auto stride = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < planes[0].data.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) planes[c].data[i] = value(image.data[i * stride + c]);
  return planes;
}

}  // namespace

Image flip_ldr_map(const Image& image, const Image& reference, double pixels_per_degree) {
  const Filters filters(pixels_per_degree);
  const auto shown = [](float v) { return std::clamp(v, 0.0f, 1.0f); };
  return difference(perceive(planes_of(image, shown), filters), perceive(planes_of(reference, shown), filters));
}

FlipExposures flip_exposures(const Image& reference) {
  std::vector<float> luminances;
  for (std::size_t i = 0; i < reference.data.size(); i += static_cast<std::size_t>(reference.channels)) {
    const float* p = &reference.data[i];
    const float y = luminance(glm::vec3(p[0], p[1], p[2]));
    if (y > 0.0f && std::isfinite(y)) luminances.push_back(y);
  }
  FlipExposures exposures;
  if (luminances.empty()) {
    exposures.black = true;
    return exposures;
  }
  std::sort(luminances.begin(), luminances.end());
  const std::size_t middle = luminances.size() / 2;
  const double median =
      luminances.size() % 2 == 1
          ? static_cast<double>(luminances[middle])
          : 0.5 * (static_cast<double>(luminances[middle - 1]) + static_cast<double>(luminances[middle]));
  exposures.start_ev = std::log2(shown_at() / static_cast<double>(luminances.back()));
  exposures.stop_ev = std::log2(shown_at() / median);
  const double count = std::ceil(exposures.stop_ev - exposures.start_ev);
  exposures.count = static_cast<int>(std::clamp(count, 2.0, static_cast<double>(kMaxExposures)));
  return exposures;
}

Image flip_hdr_map(const Image& image, const Image& reference, double pixels_per_degree) {
  FlipExposures exposures = flip_exposures(reference);
  if (exposures.black) exposures = flip_exposures(image);
  Image map(reference.width, reference.height, 1);
  if (exposures.black) return map;
  const Filters filters(pixels_per_degree);
  std::mutex mutex;
  const auto add_exposure = [&](int i) {
    const double ev = exposures.start_ev + (exposures.stop_ev - exposures.start_ev) * i / (exposures.count - 1);
    const auto scale = static_cast<float>(std::exp2(ev));
    // Beyond 1e4 the curve is saturated; larger values would overflow when squared.
    const auto shown = [scale](float v) { return film(std::clamp(v * scale, 0.0f, 1e4f)); };
    const Image one =
        difference(perceive(planes_of(image, shown), filters), perceive(planes_of(reference, shown), filters));
    const std::lock_guard lock(mutex);
    for (std::size_t k = 0; k < map.data.size(); ++k) map.data[k] = std::max(map.data[k], one.data[k]);
  };
  // An exposure takes a hundred bytes a pixel: of large pictures one at a time, whose filters take all cores.
  constexpr std::size_t kLarge = std::size_t{1} << 21;
  if (map.data.size() > kLarge)
    for (int i = 0; i < exposures.count; ++i) add_exposure(i);
  else
    parallel_for(0, exposures.count, add_exposure);
  return map;
}

}  // namespace maquette
