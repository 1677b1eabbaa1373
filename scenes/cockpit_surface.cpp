#include "scenes/cockpit_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/angles.h"
#include "scenes/parallel.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

/// Bulge around a wheel: 0 far away, highest at the edge of the arch.
double flare(double y, double z) {
  const double dz = std::abs(z) - kAxleFront_m, dy = y - kWheelRadius_m;
  const double r = std::sqrt(dz * dz + dy * dy), t = (r - 0.36) / 0.15;
  return std::exp(-t * t) * smoother(0.05, 0.45, y);
}

double lower_side(double x, double y, double z) {
  static const Curve kPlan{{-2.3, 0.80}, {-1.9, 0.868}, {-1.33, 0.905}, {-0.7, 0.895}, {0.0, 0.882},
                           {0.7, 0.882}, {1.33, 0.888}, {1.8, 0.862},   {2.3, 0.79}};
  static const Curve kSection{{0.05, 0.075}, {0.2, 0.030}, {0.30, 0.014}, {0.42, 0.022}, {0.56, 0.020},
                              {0.68, 0.002}, {0.76, 0.0},  {0.86, 0.022}, {0.95, 0.055}, {1.05, 0.10}};
  return x - (kPlan(z) - kSection(y) + 0.030 * flare(y, z));
}

double lower_top(double x, double y, double z) {
  static const Curve kProfile{{-2.3, 1.005}, {-1.9, 1.015}, {-1.5, 1.02}, {-0.9, 1.012}, {0.0, 0.985}, {0.5, 0.965},
                              {0.85, 0.937}, {1.2, 0.885},  {1.6, 0.805}, {1.95, 0.71},  {2.25, 0.60}};
  const double across = x / 0.8, ridge = smoother(0.48, 0.34, x) * smoother(0.6, 1.0, z);
  return y - (kProfile(z) - 0.045 * across * across - 0.02 * across * across * across * across + 0.010 * ridge);
}

double lower_front(double x, double y, double z) {
  static const Curve kSection{{0.05, 0.14},  {0.16, 0.075}, {0.28, 0.012}, {0.40, 0.0},
                              {0.52, 0.012}, {0.64, 0.055}, {0.76, 0.13},  {0.9, 0.25}};
  const double across = x / 0.9, a2 = across * across;
  return z - (2.20 - 0.15 * a2 - 0.17 * a2 * a2 - kSection(y));
}

double lower_rear(double x, double y, double z) {
  static const Curve kSection{{0.05, 0.20}, {0.2, 0.09},  {0.34, 0.015}, {0.5, 0.0}, {0.62, 0.012},
                              {0.76, 0.05}, {0.88, 0.06}, {0.98, 0.04},  {1.1, 0.0}};
  const double across = x / 0.9, a2 = across * across;
  return -z - (2.14 - 0.10 * a2 - 0.14 * a2 * a2 - kSection(y));
}

}  // namespace

const PaneChart& windshield_chart() {
  // Rake of 60 degrees from the vertical in the middle of the pane.
  static const PaneChart kChart{{0.0, 1.125, 0.42},
                                {0.0, std::cos(radians(60.0)), -std::sin(radians(60.0))},
                                {0.0, std::sin(radians(60.0)), std::cos(radians(60.0))},
                                0.24,
                                0.12};
  return kChart;
}

const PaneChart& rear_glass_chart() {
  static const PaneChart kChart{{0.0, 1.175, -1.46},
                                {0.0, std::cos(radians(66.0)), std::sin(radians(66.0))},
                                {0.0, std::sin(radians(66.0)), -std::cos(radians(66.0))},
                                0.22,
                                0.10};
  return kChart;
}

double canopy_side(const Vec3& p) {
  static const Curve kPlan{{-2.2, -0.21}, {-1.6, -0.10}, {-1.0, -0.03}, {-0.3, 0.003}, {0.3, 0.0}, {0.9, -0.035}};
  const double rise = p.y - 0.92;
  return std::abs(p.x) - (0.803 + kPlan(p.z) - 0.34 * rise - 0.28 * rise * rise);
}

double canopy_roof(const Vec3& p) {
  static const Curve kProfile{{-1.9, 1.12},   {-1.5, 1.225}, {-1.1, 1.306}, {-0.7, 1.355},
                              {-0.35, 1.370}, {0.0, 1.352},  {0.3, 1.305}};
  return p.y - (kProfile(p.z) - 0.12 * p.x * p.x);
}

double lower_body(const Vec3& p) {
  const double x = std::abs(p.x);
  const double flank = smooth_max(lower_side(x, p.y, p.z), lower_top(x, p.y, p.z), 0.16);
  const double nose = smooth_max(flank, lower_front(x, p.y, p.z), 0.22);
  return smooth_max(smooth_max(nose, lower_rear(x, p.y, p.z), 0.12), 0.15 - p.y, 0.06);
}

double canopy(const Vec3& p) {
  const double ends =
      smooth_max(smooth_max(windshield_chart().height(p), canopy_roof(p), 0.10), rear_glass_chart().height(p), 0.10);
  // The floor rises behind the rear glass, whose surface continues inside the boot: near the tail it would dent the
  // skin.
  const double floor = 0.86 + 0.12 * smoother(-1.7, -2.0, p.z);
  return std::max(smooth_max(ends, canopy_side(p), 0.11), floor - p.y);
}

double car_body(const Vec3& p) {
  return smooth_min(lower_body(p), canopy(p), mix(0.07, 0.03, smoother(-1.3, -0.6, p.z)));
}

Vec3 skin_normal(const Vec3& p) {
  const double h = 1e-5, f = car_body(p);
  return glm::normalize(
      Vec3(car_body(p + Vec3(h, 0, 0)) - f, car_body(p + Vec3(0, h, 0)) - f, car_body(p + Vec3(0, 0, h)) - f));
}

double belt_height(double z) {
  static const Curve kBelt{{-2.0, 1.0}, {-1.3, 0.985}, {-0.6, 0.957}, {0.2, 0.930}, {0.8, 0.912}};
  return kBelt(z);
}

double flank_x(double y, double z) {
  double inside = 0.3, outside = 1.1;
  for (int i = 0; i < 40; ++i) {
    const double x = 0.5 * (inside + outside);
    (lower_body({x, y, z}) < 0.0 ? inside : outside) = x;
  }
  return 0.5 * (inside + outside);
}

double door_outline(const Vec3& p) {
  static const Curve kFront{{0.15, 0.72}, {0.4, 0.73}, {0.7, 0.70}, {0.95, 0.60}};
  static const Curve kBack{{0.15, -0.50}, {0.4, -0.56}, {0.7, -0.65}, {0.95, -0.67}};
  const double ends = std::max(p.z - kFront(p.y), kBack(p.y) - p.z);
  return smooth_max(ends, std::max(p.y - (belt_height(p.z) - 0.012), 0.235 - p.y), 0.05);
}

double windshield_outline(const Vec3& p) {
  const double s = windshield_chart().s(p);
  return smooth_max(smooth_max(canopy_side(p) + 0.070, s - 0.365, 0.06),
                    std::max(-0.46 - s, windshield_chart().height(p) - 0.1), 0.04);
}

double rear_glass_outline(const Vec3& p) {
  const double s = rear_glass_chart().s(p);
  return smooth_max(smooth_max(canopy_side(p) + 0.085, s - 0.33, 0.10),
                    std::max(-0.36 - s, rear_glass_chart().height(p) - 0.1), 0.06);
}

double side_glass_outline(const Vec3& p) {
  const double front = smooth_max(windshield_chart().height(p) + 0.060, p.z - 0.46, 0.05), top = canopy_roof(p) + 0.062;
  // The tail of the side glass narrows to a point above the rear wheel.
  const double tail = glm::dot(Vec2(p.z + 1.36, p.y - 1.02), glm::normalize(Vec2(-0.42, 0.9)));
  const double upper = smooth_max(smooth_max(front, top, 0.05), tail, 0.10);
  return smooth_max(upper, std::max(belt_height(p.z) + 0.004 - p.y, 0.35 - p.x), 0.03);
}

double hood_outline(const Vec3& p) {
  static const Curve kEdge{{0.6, 0.76}, {0.9, 0.765}, {1.3, 0.74}, {1.7, 0.68}, {2.2, 0.55}};
  const double nose = p.z - (2.055 - 0.22 * p.x * p.x / 0.49 * 0.7), cowl = 0.80 - 0.20 * p.x * p.x - p.z;
  return smooth_max(smooth_max(p.x - kEdge(p.z), nose, 0.08), std::max(cowl, 0.5 - p.y), 0.03);
}

double wheel_arches(const Vec3& p) {
  const double front = std::hypot(p.z - kAxleFront_m, p.y - kWheelRadius_m);
  const double rear = std::hypot(p.z - kAxleRear_m, p.y - kWheelRadius_m);
  return std::max(std::min(front, rear) - kArchRadius_m, 0.6 - p.x);
}

namespace {

constexpr int kFrontTurn = 54, kMiddle = 104, kRearTurn = 46;
constexpr int kStations = kFrontTurn + kMiddle + kRearTurn;
constexpr int kBodyRows = 71, kFineRows = 58;
constexpr double kSpineFront_m = 1.25, kSpineRear_m = -1.50, kSpineHeight_m = 0.38;

struct Ray {
  Vec3 origin{};
  Vec3 direction{};
};

/// Rays fan out from a spine within planes across the car; these planes are rotated at the ends of the spine.
Ray skin_ray(int station, int row) {
  // Up to the cant rail in steps of about 2 cm, over the roof in steps of 4 cm.
  const double elevation =
      row <= kFineRows ? radians(mix(-17.0, 58.0, static_cast<double>(row) / kFineRows))
                       : radians(mix(58.0, 90.0, static_cast<double>(row - kFineRows) / (kBodyRows - kFineRows)));
  double heading = std::numbers::pi / 2.0, z = 0.0;
  if (station < kFrontTurn) {
    heading = std::numbers::pi / 2.0 * station / kFrontTurn;
    z = kSpineFront_m;
  } else if (station <= kFrontTurn + kMiddle) {
    z = mix(kSpineFront_m, kSpineRear_m, static_cast<double>(station - kFrontTurn) / kMiddle);
  } else {
    heading = std::numbers::pi / 2.0 * (1.0 + static_cast<double>(station - kFrontTurn - kMiddle) / kRearTurn);
    z = kSpineRear_m;
  }
  const double c = std::cos(elevation);
  return {{0.0, kSpineHeight_m, z}, {c * std::sin(heading), std::sin(elevation), c * std::cos(heading)}};
}

double distance_to_skin(const Ray& ray, double guess) {
  const auto f = [&](double r) { return car_body(ray.origin + r * ray.direction); };
  double step = 0.02, a = std::max(guess - step, 0.05), b = guess + step, fa = f(a), fb = f(b);
  while (fa > 0.0 && a > 0.02) {
    b = a, fb = fa;
    a = std::max(a - step, 0.02), fa = f(a);
    step *= 1.5;
  }
  while (fb < 0.0) {
    a = b, fa = fb;
    b += step, fb = f(b);
    step *= 1.5;
  }
  // Illinois variant of false position.
  int side = 0;
  double r = b;
  for (int i = 0; i < 12; ++i) {
    r = (fa * b - fb * a) / (fa - fb);
    const double fr = f(r);
    if (std::abs(fr) < 1e-7) break;
    if (fr < 0.0) {
      a = r, fa = fr;
      if (side == -1) fb *= 0.5;
      side = -1;
    } else {
      b = r, fb = fr;
      if (side == 1) fa *= 0.5;
      side = 1;
    }
  }
  return r;
}

}  // namespace

Primitive make_half_skin() {
  Primitive skin;
  constexpr std::size_t kColumn = kBodyRows + 1, kCount = (kStations + 1) * kColumn;
  skin.positions.resize(kCount);
  skin.normals.resize(kCount);
  skin.uvs[0].resize(kCount);
  parallel_for(0, kStations + 1, [&](int i) {
    double r = 0.9;
    for (int j = 0; j <= kBodyRows; ++j) {
      const Ray ray = skin_ray(i, j);
      r = distance_to_skin(ray, r);
      Vec3 p = ray.origin + r * ray.direction;
      if (i == 0 || i == kStations || j == kBodyRows) p.x = 0.0;
      Vec3 n = skin_normal(p);
      if (p.x == 0.0) n = glm::normalize(Vec3(0.0, n.y, n.z));
      const std::size_t at = static_cast<std::size_t>(i) * kColumn + static_cast<std::size_t>(j);
      skin.positions[at] = glm::vec3(p);
      skin.normals[at] = glm::vec3(n);
      skin.uvs[0][at] = glm::vec2(static_cast<float>(p.z), static_cast<float>(r));
    }
  });
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    const glm::vec3 area = glm::cross(skin.positions[b] - skin.positions[a], skin.positions[c] - skin.positions[a]);
    if (glm::dot(area, area) < 1e-18f) return;
    for (const std::size_t k : {a, b, c}) skin.indices.push_back(static_cast<std::uint32_t>(k));
  };
  for (std::size_t i = 0; i < static_cast<std::size_t>(kStations); ++i) {
    for (std::size_t j = 0; j < static_cast<std::size_t>(kBodyRows); ++j) {
      const std::size_t a = i * kColumn + j, b = a + kColumn;
      add(a, b, b + 1);
      add(a, b + 1, a + 1);
    }
  }
  return skin;
}

}  // namespace maquette::builtin
