#include "scenes/environment_builtin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "scenes/angles.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {
namespace {

constexpr int kBuiltinWidth = 1024;
constexpr int kHeight = 512;

double smoothstep(double a, double b, double x) {
  const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// --- clear sky -------------------------------------------------------------------------------------------------------

constexpr double kTurbidity = 2.3;
constexpr double kSunAzimuthDeg = 50.0;              ///< from +Z towards +X
constexpr double kSunDiameterDeg = 0.533;            ///< mean angular diameter of the sun
constexpr int kSunSupersamples = 32;                 ///< a side, only in texels that the disc may touch
const glm::dvec3 kGroundAlbedo(0.16, 0.155, 0.145);  ///< asphalt and dry grass from afar

/// Coefficients of the Perez sky for Y, x, y. Source: Preetham et al. 1999, Appendix A.2.
struct Perez {
  double a, b, c, d, e;
};

double perez(const Perez& p, double cos_theta, double gamma) {
  const double cos_gamma = std::cos(gamma);
  return (1.0 + p.a * std::exp(p.b / std::max(cos_theta, 0.01))) *
         (1.0 + p.c * std::exp(p.d * gamma) + p.e * cos_gamma * cos_gamma);
}

/// CIE xyY to linear Rec.709; negative components (outside the gamut) become 0.
glm::dvec3 rgb_from_xyy(double x, double y, double luminance) {
  const glm::dvec3 xyz(x / y * luminance, luminance, (1.0 - x - y) / y * luminance);
  // Source: IEC 61966-2-1, XYZ (D65) to linear RGB.
  const glm::dvec3 rgb(3.2406 * xyz.x - 1.5372 * xyz.y - 0.4986 * xyz.z,
                       -0.9689 * xyz.x + 1.8758 * xyz.y + 0.0415 * xyz.z,
                       0.0557 * xyz.x - 0.2040 * xyz.y + 1.0570 * xyz.z);
  return glm::max(rgb, glm::dvec3(0.0));
}

/// Skylight in cd/m2. Source: Preetham, Shirley, Smits 1999, "A Practical Analytic Model for Daylight", Appendix A.2.
struct PreethamSky {
  double elevation_deg;
  double theta_s = radians(90.0 - elevation_deg);
  glm::dvec3 sun{std::cos(radians(elevation_deg)) * std::sin(radians(kSunAzimuthDeg)), std::sin(radians(elevation_deg)),
                 std::cos(radians(elevation_deg)) * std::cos(radians(kSunAzimuthDeg))};
  std::array<Perez, 3> distribution{};  ///< Y, x, y
  std::array<double, 3> scale{};        ///< zenith value (cd/m2, x, y) over the Perez value there

  explicit PreethamSky(double sun_elevation_deg) : elevation_deg(sun_elevation_deg) {
    const double t = kTurbidity;
    distribution = {
        {{0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703},
         {-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989, -0.0033 * t + 0.0452},
         {-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
          -0.0109 * t + 0.0529}}};
    const double chi = (4.0 / 9.0 - t / 120.0) * (std::numbers::pi - 2.0 * theta_s);
    const double s = theta_s, s2 = s * s, s3 = s2 * s;
    std::array<double, 3> zenith{};
    zenith[0] = 1000.0 * ((4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192);
    zenith[1] = t * t * (0.00166 * s3 - 0.00375 * s2 + 0.00209 * s) +
                t * (-0.02903 * s3 + 0.06377 * s2 - 0.03202 * s + 0.00394) +
                (0.11693 * s3 - 0.21196 * s2 + 0.06052 * s + 0.25886);
    zenith[2] = t * t * (0.00275 * s3 - 0.00610 * s2 + 0.00317 * s) +
                t * (-0.04214 * s3 + 0.08970 * s2 - 0.04153 * s + 0.00516) +
                (0.15346 * s3 - 0.26756 * s2 + 0.06670 * s + 0.26688);
    for (std::size_t i = 0; i < 3; ++i) scale[i] = zenith[i] / perez(distribution[i], 1.0, theta_s);
  }

  glm::dvec3 radiance(const glm::dvec3& direction) const {
    const double gamma = std::acos(std::clamp(glm::dot(direction, sun), -1.0, 1.0));
    std::array<double, 3> value{};
    for (std::size_t i = 0; i < 3; ++i) value[i] = scale[i] * perez(distribution[i], direction.y, gamma);
    return rgb_from_xyy(value[1], value[2], value[0]);
  }
};

/// Direct normal illuminance in lx. Source: IESNA Lighting Handbook, 9th ed., Ch. 8: E = 127.5 klx exp(-c m), c = 0.21
/// for a clear sky, air mass m = 1 / sin(elevation).
double sun_illuminance_lx(double elevation_deg) {
  return 127500.0 * std::exp(-0.21 / std::sin(radians(elevation_deg)));
}

/// Mean radiance of the disc over its true solid angle, slightly warm, cd/m2.
glm::dvec3 sun_radiance(double elevation_deg) {
  const double solid_angle = 2.0 * std::numbers::pi * (1.0 - std::cos(radians(kSunDiameterDeg / 2.0)));
  const glm::dvec3 tint(1.10, 0.985, 0.85);
  return tint * (sun_illuminance_lx(elevation_deg) / solid_angle / luminance(tint));
}

/// Share of the texel's solid angle inside the sun's disc.
double sun_coverage(const glm::dvec3& sun, int x, int y) {
  const double radius = radians(kSunDiameterDeg / 2.0);
  const glm::dvec3 centre = direction_from_latlong(x + 0.5, y + 0.5, kBuiltinWidth, kHeight);
  if (glm::dot(centre, sun) < std::cos(radius + 1.5 * std::numbers::pi / kHeight)) return 0.0;
  int inside = 0;
  for (int i = 0; i < kSunSupersamples * kSunSupersamples; ++i) {
    const double sx = x + (i % kSunSupersamples + 0.5) / kSunSupersamples;
    const double sy = y + (i / kSunSupersamples + 0.5) / kSunSupersamples;
    inside += glm::dot(direction_from_latlong(sx, sy, kBuiltinWidth, kHeight), sun) > std::cos(radius);
  }
  return static_cast<double>(inside) / (kSunSupersamples * kSunSupersamples);
}

double texel_solid_angle(int y) {
  return 2.0 * std::numbers::pi / kBuiltinWidth *
         (std::cos(std::numbers::pi * y / kHeight) - std::cos(std::numbers::pi * (y + 1) / kHeight));
}

/// Height of a distant ridge above the horizon in radians: a sum of a few sines, so that it is deterministic and
/// periodic.
double ridge_rad(double longitude) {
  return radians(1.5 + 0.8 * std::sin(3.0 * longitude + 0.7) + 0.45 * std::sin(7.0 * longitude + 2.1) +
                 0.22 * std::sin(17.0 * longitude + 4.0) + 0.10 * std::sin(41.0 * longitude + 1.0));
}

// --- studio ----------------------------------------------------------------------------------------------------------

/// A soft box: a rectangular light in the room, brightest in the middle.
struct SoftBox {
  glm::dvec3 centre{};  ///< m, seen from the origin
  glm::dvec3 half_u{};  ///< m
  glm::dvec3 half_v{};
  double luminance;  ///< cd/m2
  double softness;   ///< share of the half size over which the edge fades
  glm::dvec3 tint{};
};

const std::array<SoftBox, 7>& soft_boxes() {
  static const std::array<SoftBox, 7> kBoxes = {{
      // Three strips over the length of the car; the middle one is the signature highlight of roof and bonnet.
      {{0.0, 3.2, 0.0}, {0.42, 0, 0}, {0, 0, 5.0}, 9000.0, 0.18, {1.0, 0.99, 0.97}},
      {{-2.3, 3.0, 0.0}, {0.20, 0.06, 0}, {0, 0, 4.6}, 7000.0, 0.25, {0.97, 0.99, 1.0}},
      {{2.3, 3.0, 0.0}, {0.20, -0.06, 0}, {0, 0, 4.6}, 7000.0, 0.25, {0.97, 0.99, 1.0}},
      // A large box on each side draws the shoulder line; the right one is a stop lower.
      {{-4.6, 1.5, 0.6}, {0, 0, 2.6}, {0.25, 0.75, 0}, 3200.0, 0.35, {1.0, 0.98, 0.95}},
      {{4.8, 1.4, -0.8}, {0, 0, 2.2}, {-0.25, 0.65, 0}, 1500.0, 0.35, {0.94, 0.97, 1.0}},
      // Slim uprights front and back for the ends.
      {{1.9, 1.5, 5.2}, {0.28, 0, -0.10}, {0, 1.3, 0}, 4200.0, 0.25, {1.0, 0.99, 0.97}},
      {{-1.6, 1.6, -5.4}, {0.45, 0, -0.13}, {0, 1.1, 0}, 2600.0, 0.30, {0.96, 0.98, 1.0}},
  }};
  return kBoxes;
}

/// The box's luminance along `direction` relative to its maximum, 0 outside.
double soft_box_profile(const SoftBox& box, const glm::dvec3& direction) {
  const glm::dvec3 normal = glm::cross(box.half_u, box.half_v);
  const double denominator = glm::dot(direction, normal);
  if (std::abs(denominator) < 1e-12) return 0.0;
  const double t = glm::dot(box.centre, normal) / denominator;
  if (t <= 0.0) return 0.0;
  const glm::dvec3 offset = t * direction - box.centre;
  const double u = std::abs(glm::dot(offset, box.half_u)) / glm::dot(box.half_u, box.half_u);
  const double v = std::abs(glm::dot(offset, box.half_v)) / glm::dot(box.half_v, box.half_v);
  if (u >= 1.0 || v >= 1.0) return 0.0;
  // The long side fades over the same length in metres as the short one.
  const double fade_v = box.softness * glm::length(box.half_u) / glm::length(box.half_v);
  const double fade_u = box.softness * std::min(1.0, glm::length(box.half_v) / glm::length(box.half_u));
  const double edges = (1.0 - smoothstep(1.0 - fade_u, 1.0, u)) * (1.0 - smoothstep(1.0 - fade_v, 1.0, v));
  return edges * (1.0 - 0.22 * u * u);
}

/// Walls and floor: the floor is a light cyclorama, brightest under the lights, that rises into a dark surround.
glm::dvec3 studio_room(const glm::dvec3& direction) {
  const double elevation = std::asin(std::clamp(direction.y, -1.0, 1.0));
  const glm::dvec3 wall(66.0, 70.0, 78.0);
  const glm::dvec3 ceiling(26.0, 27.0, 30.0);
  const glm::dvec3 far_floor(230.0, 233.0, 238.0);
  const glm::dvec3 near_floor(620.0, 612.0, 600.0);
  const glm::dvec3 above = glm::mix(wall, ceiling, smoothstep(0.0, 0.9, elevation));
  const glm::dvec3 floor = glm::mix(far_floor, near_floor, smoothstep(radians(-8.0), radians(-70.0), elevation));
  // The cove between floor and wall has no edge: it fades over 16 degrees.
  return glm::mix(floor, above, smoothstep(radians(-9.0), radians(7.0), elevation));
}

glm::dvec3 studio_radiance(const glm::dvec3& direction) {
  glm::dvec3 radiance = studio_room(direction);
  for (const SoftBox& box : soft_boxes()) {
    const double share = soft_box_profile(box, direction);
    radiance = glm::mix(radiance, box.luminance * box.tint, share);
  }
  return radiance;
}

/// Radiance at the texel centres, or its mean over 4 x 4 points in texels that differ from a neighbour by over 3 %.
template <class Radiance>
Environment rasterise(const Radiance& radiance) {
  constexpr int kSide = 4;
  Environment environment;
  environment.width = kBuiltinWidth;
  environment.height = kHeight;
  environment.rgb.resize(static_cast<std::size_t>(kBuiltinWidth) * kHeight);
  const auto index = [](int x, int y) {
    return static_cast<std::size_t>(std::clamp(y, 0, kHeight - 1)) * kBuiltinWidth +
           static_cast<std::size_t>((x + kBuiltinWidth) % kBuiltinWidth);
  };
  parallel_for(0, kHeight, [&](int y) {
    for (int x = 0; x < kBuiltinWidth; ++x)
      environment.rgb[index(x, y)] =
          glm::vec3(radiance(direction_from_latlong(x + 0.5, y + 0.5, kBuiltinWidth, kHeight)));
  });
  const std::vector<glm::vec3> centres = environment.rgb;
  parallel_for(0, kHeight, [&](int y) {
    for (int x = 0; x < kBuiltinWidth; ++x) {
      const float here = centres[index(x, y)].y;
      const bool smooth = std::ranges::all_of(
          std::array{index(x - 1, y), index(x + 1, y), index(x, y - 1), index(x, y + 1)},
          [&](std::size_t i) { return std::abs(centres[i].y - here) <= 0.03f * std::min(here, centres[i].y); });
      if (smooth) continue;
      glm::dvec3 sum(0.0);
      for (int i = 0; i < kSide * kSide; ++i) {
        const glm::dvec2 offset((i % kSide + 0.5) / kSide, (i / kSide + 0.5) / kSide);
        sum += radiance(direction_from_latlong(x + offset.x, y + offset.y, kBuiltinWidth, kHeight));
      }
      environment.rgb[index(x, y)] = glm::vec3(sum / static_cast<double>(kSide * kSide));
    }
  });
  return environment;
}

/// Horizontal irradiance of the upper half, without the sun.
glm::dvec3 sky_irradiance(const PreethamSky& sky) {
  glm::dvec3 sum(0.0);
  for (int y = 0; y < kHeight / 2; y += 4) {
    for (int x = 0; x < kBuiltinWidth; x += 8) {
      const glm::dvec3 d = direction_from_latlong(x + 4.0, y + 2.0, kBuiltinWidth, kHeight);
      for (int k = 0; k < 4; ++k) sum += sky.radiance(d) * d.y * texel_solid_angle(y + k) * 8.0;
    }
  }
  return sum;
}

}  // namespace

Environment make_clear_sky(double sun_elevation_deg) {
  const PreethamSky sky(sun_elevation_deg);
  const glm::dvec3 sun = sun_radiance(sun_elevation_deg);
  const double solid_angle = 2.0 * std::numbers::pi * (1.0 - std::cos(radians(kSunDiameterDeg / 2.0)));
  const glm::dvec3 ground = kGroundAlbedo / std::numbers::pi * (sky_irradiance(sky) + sun * solid_angle * sky.sun.y);
  const glm::dvec3 ridge = 0.28 * ground * glm::dvec3(0.72, 0.95, 0.85);
  Environment environment = rasterise([&](const glm::dvec3& d) {
    const double elevation = std::asin(std::clamp(d.y, -1.0, 1.0));
    const glm::dvec3 haze =
        elevation > radians(-20.0) ? sky.radiance(glm::normalize(glm::dvec3(d.x, 0.035, d.z))) : glm::dvec3(0.0);
    // Aerial perspective: distant objects take the colour of the horizon. Edges fade over two texels: otherwise a long
    // lens would show the grid as stairs along the ridge.
    constexpr double kFade_rad = 1.0 * std::numbers::pi / kHeight;
    const glm::dvec3 plain = glm::mix(ground, haze, 0.45 * std::exp(std::min(elevation, 0.0) / radians(2.5)));
    const glm::dvec3 land = glm::mix(plain, glm::mix(ridge, haze, 0.5), smoothstep(-kFade_rad, kFade_rad, elevation));
    const double edge = ridge_rad(std::atan2(d.x, d.z));
    if (elevation < edge - kFade_rad) return land;
    const glm::dvec3 above = sky.radiance(glm::normalize(glm::dvec3(d.x, std::max(d.y, 0.0), d.z)));
    return glm::mix(land, above, smoothstep(edge - kFade_rad, edge + kFade_rad, elevation));
  });
  // Normalised so that the grid has exactly the disc's energy, whatever the rounding of its coverage.
  double covered = 0.0;
  std::vector<std::pair<std::size_t, double>> texels;
  const int sun_row = static_cast<int>(latlong_from_direction(sky.sun, kBuiltinWidth, kHeight).y);
  for (int y = std::max(0, sun_row - 3); y <= sun_row + 3; ++y) {
    for (int x = 0; x < kBuiltinWidth; ++x) {
      const double coverage = sun_coverage(sky.sun, x, y);
      if (coverage == 0.0) continue;
      covered += coverage * texel_solid_angle(y);
      texels.emplace_back(static_cast<std::size_t>(y) * kBuiltinWidth + static_cast<std::size_t>(x), coverage);
    }
  }
  for (const auto& [i, coverage] : texels) environment.rgb[i] += glm::vec3(sun * (coverage * solid_angle / covered));
  return environment;
}

Environment make_studio() { return rasterise(studio_radiance); }

}  // namespace maquette
