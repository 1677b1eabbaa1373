#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace maquette {

/// Latitude-longitude radiance, OpenEXR LATLONG: row 0 is +Y, column 0 starts at longitude +pi, the centre is +Z.
/// rgb[y * width + x], linear Rec.709, finite and non-negative after loading.
struct Environment {
  std::string name;
  int width = 0;
  int height = 0;
  std::vector<glm::vec3> rgb;
  std::uint64_t hash = 0;  ///< of its texels; 0 where it was made in memory (content_key() is right for both)
  std::vector<std::string> warnings;  ///< repaired texels (NaN, inf, negative), downsampling of a huge map, ...
};

/// Loads .hdr or .exr, or `builtin:clear-sky`, `builtin:studio`. Throws Error (unreadable, not an image, zero size).
/// NaN, infinite or negative texels are replaced by the mean of their valid neighbours (0 without any) and reported in
/// warnings.
Environment load_environment(const std::string& source);
std::vector<std::string> builtin_environment_names();

/// Made of its size and texels: by this key what is derived from an environment is cached.
std::uint64_t content_key(const Environment& environment);

/// Unit direction of a point of the map; x in [0, width], y in [0, height], texel centres at half-integers.
glm::dvec3 direction_from_latlong(double x, double y, int width, int height);
glm::dvec2 latlong_from_direction(const glm::dvec3& direction, int width, int height);
/// Bilinear between texel centres; longitude wraps, poles clamp. Reference version in double.
glm::dvec3 evaluate_environment(const Environment& environment, const glm::dvec3& direction);

}  // namespace maquette
