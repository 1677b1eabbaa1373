#include "scenes/image_color.h"

#include <algorithm>
#include <cmath>

#include "scenes/parallel.h"

namespace maquette {
namespace {

constexpr double kStoredPrecision = 1e-5;  // files store chromaticities as float or with few digits

bool equal(const glm::dvec2& a, const glm::dvec2& b) {
  return std::abs(a.x - b.x) < kStoredPrecision && std::abs(a.y - b.y) < kStoredPrecision;
}

glm::dvec3 xyz_of(const glm::dvec2& xy) { return {xy.x / xy.y, 1.0, (1.0 - xy.x - xy.y) / xy.y}; }

/// XYZ under one white to XYZ under another.
/// Source: Lam 1985 (Bradford), as given in ICC.1:2010 Annex E.
glm::dmat3 adapt_white(const glm::dvec2& from, const glm::dvec2& to) {
  const glm::dmat3 cones =
      glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296));
  const glm::dvec3 gain = (cones * xyz_of(to)) / (cones * xyz_of(from));
  return glm::inverse(cones) * glm::dmat3(gain.x, 0, 0, 0, gain.y, 0, 0, 0, gain.z) * cones;
}

}  // namespace

bool is_rec709(const Primaries& p) {
  constexpr Primaries kRec709;
  return equal(p.red, kRec709.red) && equal(p.green, kRec709.green) && equal(p.blue, kRec709.blue) &&
         equal(p.white, kRec709.white);
}

std::optional<glm::dmat3> xyz_from_rgb(const Primaries& p) {
  const auto column = [](const glm::dvec2& xy) { return glm::dvec3(xy, 1.0 - xy.x - xy.y); };
  const glm::dmat3 directions(column(p.red), column(p.green), column(p.blue));
  const double determinant = glm::determinant(directions);
  // Also false for NaN.
  if (!(std::abs(determinant) > 1e-6 && p.white.y > 1e-3 && p.white.y <= 1.0)) return std::nullopt;
  const glm::dvec3 scale = glm::inverse(directions) * xyz_of(p.white);
  // A white outside the triangle of the primaries would need a negative one.
  const auto fine = [](double s) { return s > 1e-6 && s < 1e6; };
  if (!fine(scale.x) || !fine(scale.y) || !fine(scale.z)) return std::nullopt;
  return glm::dmat3(directions[0] * scale.x, directions[1] * scale.y, directions[2] * scale.z);
}

glm::dmat3 rec709_from_rgb(const Primaries& primaries) {
  constexpr Primaries kRec709;
  const glm::dmat3 rec709_from_xyz = glm::inverse(*xyz_from_rgb(kRec709));
  const glm::dmat3 xyz = *xyz_from_rgb(primaries);
  if (equal(primaries.white, kRec709.white)) return rec709_from_xyz * xyz;
  return rec709_from_xyz * adapt_white(primaries.white, kRec709.white) * xyz;
}

void convert_colors(const glm::mat3& matrix, std::size_t texel_count, int channels, float* values) {
  parallel_ranges<std::size_t>(0, texel_count, 4096, [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      float* value = values + i * static_cast<std::size_t>(channels);
      const glm::vec3 rgb = matrix * glm::vec3(value[0], value[1], value[2]);
      for (int c = 0; c < 3; ++c) value[c] = rgb[c];
    }
  });
}

glm::vec3 desaturate_into_gamut(const glm::vec3& rgb, const glm::vec3& luminance_weights) {
  const float lowest = std::min({rgb.x, rgb.y, rgb.z});
  const float y = glm::dot(rgb, luminance_weights);
  if (!(lowest < 0.0f) || !(y > 0.0f)) return rgb;
  return glm::max(glm::vec3(y) + (rgb - y) * (y / (y - lowest)), glm::vec3(0.0f));
}

}  // namespace maquette
