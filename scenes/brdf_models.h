#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scenes/brdf.h"

namespace maquette {

/// Reflectance over the cosine of the angle to a facet's normal: [cos index 0..kFresnelCount-1], cos = i / (count - 1).
using FresnelCurve = std::vector<glm::vec3>;
inline constexpr int kFresnelCount = 257;

/// Exact unpolarised reflectance of a dielectric; `eta` is the ratio of indices (far side over near side). 1 for total
/// reflection.
double fresnel_dielectric(double cos_theta, double eta);
/// Exact unpolarised reflectance of a conductor with complex index eta + i k. Source: Born & Wolf, Sec. 14.2.
double fresnel_conductor(double cos_theta, double eta, double k);
/// Per-channel reflectance of a conductor in a medium of index `outside`.
FresnelCurve conductor_curve(const glm::dvec3& eta, const glm::dvec3& k, double outside);

/// A pigment flake: a thin film between two reflecting interfaces, the Airy sum, integrated over the spectrum to linear
/// Rec.709. Source: Airy 1833 (Born & Wolf, Sec. 7.6); as a BRDF: Gondek et al. 1994, "Wavelength dependent reflectance
/// functions".
struct ThinFilm {
  double film_index = 1.4;
  double thickness_nm = 400.0;
  double top_amplitude = 0.3;      ///< of the reflected amplitude at the upper interface, real
  double bottom_amplitude = -0.9;  ///< at the lower interface; its sign is the phase shift
  double outside_index = 1.5;      ///< of the medium in which the angle is measured
};
FresnelCurve thin_film_curve(const ThinFilm& film);

/// Facets of one slope distribution. Walter et al. 2007 (GGX, Eq. 33; Smith masking, Eq. 34).
struct FacetLobe {
  double alpha = 0.3;
  double weight = 0.0;        ///< share of the area covered by these facets
  double alpha_across = 0.0;  ///< > 0: brushed along `alpha`, all azimuths of the brushing mixed; bare facets only
};

/// One paint or trim, from the top: an optional dielectric coat; under it metal or pigment flakes and a diffuse
/// substrate; fibres.
struct LayeredModel {
  glm::dvec3 diffuse{0.0};         ///< reflectance of the substrate
  double diffuse_sigma_rad = 0.0;  ///< Oren & Nayar 1994, Eq. 30, without interreflection
  double coat_index = 0.0;         ///< 0: no coat, facets are in air
  double coat_alpha = 0.012;
  double coat_share = 1.0;  ///< share of the coat's own reflection that remains after pores and grain
  std::vector<FacetLobe> flakes;
  FresnelCurve flake_reflectance;  ///< of all lobes, over the angle inside the coat
  double flake_transmission =
      0.0;  ///< share of the light on flakes that is transmitted to the ground (mica: most; metal: none)
  /// Transmission of the pigment around the flakes for the path in and out along the normal (other angles:
  /// Beer-Lambert).
  glm::dvec3 flake_tint{1.0};
  glm::dvec3 sheen{0.0};  ///< Estevez & Kulla 2017, Eq. 2, with the visibility of Neubelt & Pettineo 2013
  double sheen_roughness = 0.3;
};

/// Fills [theta_h][theta_d][phi_d]. Reciprocal and mirror-symmetric by construction. Parallel; about 20 ms on one core.
std::vector<glm::vec3> tabulate_model(const LayeredModel& model);

}  // namespace maquette
