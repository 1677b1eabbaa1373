#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/environment.h"

namespace maquette {

/// Where the brightest small light of an environment stands, as the scene sees it.
struct SunPlace {
  bool found = false;          ///< false: nothing outshines the mean by 100 times
  double elevation_deg = 0.0;  ///< above the horizon
  double azimuth_deg = 0.0;    ///< from +Z towards +X, in (-180, 180]
  glm::dvec3 direction{0.0, 1.0, 0.0};
};
/// The luminance-weighted direction of the texels about the brightest one.
SunPlace find_sun(const Environment& environment, double rotation_rad);

/// Unit direction of an elevation and an azimuth from +Z towards +X, degrees.
glm::dvec3 direction_of(double elevation_deg, double azimuth_deg);

/// Illuminance of a surface by the environment, lx: the integral of luminance times cosine, texel by texel. `normal`:
/// unit; `visible`: of a unit direction to the environment, null: all of it.
double illuminance_lx(const Environment& environment, double rotation_rad, double env_scale, const glm::dvec3& normal,
                      const std::function<bool(const glm::dvec3&)>& visible = {});

/// A piece of the environment, small enough to count as one direction.
struct DistantLight {
  glm::dvec3 direction{0.0, 1.0, 0.0};  ///< unit, its middle by luminance, rotated
  double illuminance_lx = 0.0;          ///< of a surface that faces it
};
/// Blocks of texels of about a degree, black ones left out.
std::vector<DistantLight> distant_lights(const Environment& environment, double rotation_rad, double env_scale);

}  // namespace maquette
