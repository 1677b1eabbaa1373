#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/environment/environment_tables.h"

namespace maquette {

/// The texels of an environment that are a sun, drawn apart from the rest of the sky: a handful of texels need a few
/// samples a point, not a share of all that grows with their power.
struct Sun {
  /// A texel is of the sun where its packed luminance is above this; between the dimmest of it and the brightest
  /// other, so that rounding decides nothing.
  float least_luminance = 0.0f;
  double solid_angle_sr = 0.0;  ///< that it would have if it were as bright as its brightest texel all over
  bool compact = true;          ///< one sun: all texels within 2 degrees of the first
  /// Directions and texels in proportion to the texels' light, any aligned run of 2^k well spread. `radiance` is what
  /// one sample is worth, already divided by its density; `pdf` that density over the texel's bilinear weight.
  std::vector<EnvironmentSample> samples;
  std::shared_ptr<const Environment> rest;  ///< the environment with these texels black
};

/// Mean luminance of the texels of suns (more than kSunDensity of all light, 1/sr), weighted by their own light, in
/// stored units; 0 without any.
float mean_sun_luminance(const Environment& environment, double luminance_integral);

/// Texels of more than kSunDensity (shaders/shared/constants.glsl). Empty where there are none, and where they are so
/// many, or so near a pole, that a few samples would not do.
std::optional<Sun> find_sun(const Environment& environment, double luminance_integral, int bias, std::size_t samples);

}  // namespace maquette
