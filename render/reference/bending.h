#pragma once

#include "render/reference/surface.h"

namespace maquette {

/// What glass makes of a ray that met it: mirrored or passed on, by chance.
struct BentRay {
  glm::vec3 direction{0.0f};  ///< world, unit
  glm::vec3 weight{0.0f};     ///< of the radiance that comes from there; 0: nothing does
  bool passed = false;        ///< to the other side
};

/// Linear polarisation of what a path gathers: Stokes parameters over the first one, Q positive for a field along
/// `axis` (unit, across the ray). All 0: unpolarised. The circular part, that total reflection makes, is left out.
struct Polarisation {
  float q = 0.0f, u = 0.0f;
  glm::vec3 axis{1.0f, 0.0f, 0.0f};
};

/// Solid glass (refraction, total internal reflection) or a thin rough pane at `p`, for a ray of unit `direction`.
/// `alpha`: GGX roughness, 0 for smooth; `u` picks the facet, `choice` in [0, 1) mirrors or passes; solid glass changes
/// the polarisation, so that faces in a row reflect what theory says. Source: Walter et al. 2007, "Microfacet Models
/// for Refraction through Rough Surfaces", with facets drawn from the visible ones (Heitz 2018), so that what is left
/// of the weight is G2 / G1. A rough pane passes its mirrored lobe on to the other side. Differs: Fresnel is exact, a
/// pane's with all bounces between its faces; polarisation by Mueller's matrices of an interface (Collett 2005, "Field
/// Guide to Polarization").
BentRay bend_at_glass(const SurfacePoint& p, const glm::vec3& direction, float alpha, const glm::vec2& u, float choice,
                      Polarisation* polarisation);

}  // namespace maquette
