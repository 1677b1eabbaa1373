#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/environment/environment_tables.h"

namespace maquette {

/// The texels of an environment that are a sun, sampled apart from the rest of the sky: a few texels need only a few
/// samples a point, not a share of all samples that grows with their power.
struct Sun {
  /// A texel belongs to the sun when its packed luminance is above this. It lies between the dimmest sun texel and the
  /// brightest other texel, so that rounding does not matter.
  float least_luminance = 0.0f;
  double solid_angle_sr = 0.0;  ///< solid angle of a uniform sun as bright as the brightest texel
  bool compact = true;          ///< one sun: all texels within 2 degrees of the first
  /// Directions and texels in proportion to the texels' light; any aligned run of 2^k is well distributed. `radiance`
  /// is the contribution of one sample, already divided by its density; `pdf` is that density over the texel's bilinear
  /// weight.
  std::vector<EnvironmentSample> samples;
  std::shared_ptr<const Environment> rest;  ///< the environment with these texels black
};

/// Mean luminance of the texels of suns (more than kSunDensity of all light, 1/sr), weighted by their own light, in
/// stored units; 0 without suns.
float mean_sun_luminance(const Environment& environment, double luminance_integral);

/// Finds the texels of more than kSunDensity (shaders/shared/constants.glsl). Empty when there are none, when they are
/// too many for a few samples, or when they are too near a pole.
std::optional<Sun> find_sun(const Environment& environment, double luminance_integral, int bias, std::size_t samples);

}  // namespace maquette
