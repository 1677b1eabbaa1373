#include "render/inspection/light_on_pane.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/luminance.h"

namespace maquette {

namespace {

double texel_solid_angle(const Environment& e, int y) {
  return 2.0 * std::numbers::pi / e.width *
         (std::cos(std::numbers::pi * y / e.height) - std::cos(std::numbers::pi * (y + 1) / e.height));
}

/// Environment rotation turns it about +Y, positive from +Z towards +X.
glm::dvec3 rotated(const glm::dvec3& d, double rotation_rad) {
  const double s = std::sin(rotation_rad), c = std::cos(rotation_rad);
  return {c * d.x + s * d.z, d.y, -s * d.x + c * d.z};
}

double luminance_at(const Environment& e, int x, int y) {
  return luminance(glm::dvec3(e.rgb[static_cast<std::size_t>(y) * static_cast<std::size_t>(e.width) +
                                    static_cast<std::size_t>((x + e.width) % e.width)]));
}

}  // namespace

glm::dvec3 direction_of(double elevation_deg, double azimuth_deg) {
  const double e = elevation_deg * std::numbers::pi / 180.0, a = azimuth_deg * std::numbers::pi / 180.0;
  return {std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a)};
}

SunPlace find_sun(const Environment& e, double rotation_rad) {
  constexpr double kOutshines = 100.0;
  constexpr int kReach = 3;  // texels
  double peak = 0.0, sum = 0.0;
  int at_x = 0, at_y = 0;
  for (int y = 0; y < e.height; ++y)
    for (int x = 0; x < e.width; ++x) {
      const double l = luminance_at(e, x, y);
      sum += l * texel_solid_angle(e, y);
      if (l > peak) {
        peak = l;
        at_x = x;
        at_y = y;
      }
    }
  SunPlace sun;
  if (!(peak > kOutshines * sum / (4.0 * std::numbers::pi))) return sun;
  glm::dvec3 middle(0.0);
  for (int y = std::max(at_y - kReach, 0); y <= std::min(at_y + kReach, e.height - 1); ++y)
    for (int x = at_x - kReach; x <= at_x + kReach; ++x)
      if (const double l = luminance_at(e, x, y); l > 0.1 * peak)
        middle += l * texel_solid_angle(e, y) * direction_from_latlong(x + 0.5, y + 0.5, e.width, e.height);
  sun.found = true;
  sun.direction = rotated(glm::normalize(middle), rotation_rad);
  sun.elevation_deg = std::asin(std::clamp(sun.direction.y, -1.0, 1.0)) * 180.0 / std::numbers::pi;
  sun.azimuth_deg = std::atan2(sun.direction.x, sun.direction.z) * 180.0 / std::numbers::pi;
  return sun;
}

double illuminance_lx(const Environment& e, double rotation_rad, double env_scale, const glm::dvec3& normal,
                      const std::function<bool(const glm::dvec3&)>& visible) {
  double sum = 0.0;
  for (int y = 0; y < e.height; ++y) {
    double row = 0.0;
    for (int x = 0; x < e.width; ++x) {
      const glm::dvec3 d = rotated(direction_from_latlong(x + 0.5, y + 0.5, e.width, e.height), rotation_rad);
      const double cosine = glm::dot(d, normal), l = luminance_at(e, x, y);
      if (cosine > 0.0 && l > 0.0 && (!visible || visible(d))) row += l * cosine;
    }
    sum += row * texel_solid_angle(e, y);
  }
  return sum * env_scale;
}

std::vector<DistantLight> distant_lights(const Environment& e, double rotation_rad, double env_scale) {
  constexpr int kRows = 180;
  const int block = std::max(1, e.height / kRows);
  std::vector<DistantLight> lights;
  for (int y0 = 0; y0 < e.height; y0 += block)
    for (int x0 = 0; x0 < e.width; x0 += block) {
      glm::dvec3 middle(0.0);
      double sum = 0.0;
      for (int y = y0; y < std::min(y0 + block, e.height); ++y)
        for (int x = x0; x < std::min(x0 + block, e.width); ++x) {
          const double light = luminance_at(e, x, y) * texel_solid_angle(e, y);
          middle += light * direction_from_latlong(x + 0.5, y + 0.5, e.width, e.height);
          sum += light;
        }
      if (sum > 0.0) lights.push_back({rotated(glm::normalize(middle), rotation_rad), sum * env_scale});
    }
  return lights;
}

}  // namespace maquette
