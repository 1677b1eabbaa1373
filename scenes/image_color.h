#pragma once

#include <glm/glm.hpp>
#include <optional>

namespace maquette {

/// The CIE xy chromaticities that define an RGB colour space.
struct Primaries {
  glm::dvec2 red{0.64, 0.33};
  glm::dvec2 green{0.30, 0.60};
  glm::dvec2 blue{0.15, 0.06};
  glm::dvec2 white{0.3127, 0.3290};
};

/// Rec.709, up to the rounding of values that files store.
bool is_rec709(const Primaries& primaries);
/// XYZ of linear RGB, Y of (1, 1, 1) is 1; nothing when the values describe no colour space.
std::optional<glm::dmat3> xyz_from_rgb(const Primaries& primaries);
/// Linear Rec.709 of linear RGB, with Bradford adaptation to D65 for another white. `primaries` describe a colour
/// space.
glm::dmat3 rec709_from_rgb(const Primaries& primaries);

/// Applies `matrix` to the first three of each texel's `channels` values.
void convert_colors(const glm::mat3& matrix, std::size_t texel_count, int channels, float* values);

/// Moves a colour with negative components towards the grey of its luminance, until none is negative.
glm::vec3 desaturate_into_gamut(const glm::vec3& rgb, const glm::vec3& luminance_weights);

}  // namespace maquette
