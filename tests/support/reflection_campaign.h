#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace maquette {

/// Results of a run of random reflections. Inside: the reflection point lies on the patch, away from its border.
struct BezierCampaign {
  std::size_t cases = 0;        ///< tested triples of patch, eye and object
  std::size_t inside = 0;       ///< of them with a reflection on the patch
  std::size_t uncertified = 0;  ///< concave side beyond a caustic: marked, not tested
  std::size_t wrong = 0;        ///< not the point of the exhaustive search, or no point, or one too many
  std::size_t law_broken = 0;   ///< law of reflection not within 1e-4 rad, evaluated in double
  std::size_t several = 0;      ///< certified, but the exhaustive search found more than one
  std::size_t not_finite = 0;
  double worst_law_rad = 0.0;
  std::vector<std::size_t> steps;  ///< histogram over the inside cases
  std::string failures;            ///< the first few, a line each
  int steps_quantile(double q) const;
};

/// `cases` triples from `seed`: half of them on the convex side, half on the concave one; patches of 0.2 to 20 m
/// radius, the eye 0.05 to 10 m away, at all angles including grazing ones. Two thirds have their object on a reflected
/// ray, the others anywhere.
BezierCampaign run_bezier_campaign(std::size_t cases, std::uint64_t seed);

}  // namespace maquette
