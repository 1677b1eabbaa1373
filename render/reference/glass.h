#pragma once

#include "render/reference/surface.h"

namespace maquette {

/// A ray that leaves glass after a hit: reflected or transmitted, chosen at random.
struct GlassSample {
  glm::vec3 direction{0.0f};  ///< world, unit
  glm::vec3 weight{0.0f};     ///< factor of the radiance from that direction; 0: the path ends
  bool passed = false;        ///< transmitted to the other side
};

/// Linear polarisation of the light that a path gathers: Stokes parameters over the first one, with Q positive for a
/// field along `axis` (unit, perpendicular to the ray). All 0: unpolarised. The circular part, which total internal
/// reflection creates, is left out.
struct Polarisation {
  float q = 0.0f, u = 0.0f;
  glm::vec3 axis{1.0f, 0.0f, 0.0f};
};

/// Samples solid glass (refraction, total internal reflection) or a thin rough pane at `p`, for a ray of unit
/// `direction`. `alpha`: GGX roughness, 0 for smooth; `u` samples the microfacet; `choice` in [0, 1) selects reflection
/// or transmission. Solid glass changes the polarisation, so that several faces in a row reflect as much as theory
/// says. Source: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", with visible normals
/// (Heitz 2018), so that the remaining weight is G2 / G1. A rough pane transmits its reflected lobe, mirrored to the
/// other side. Differs: Fresnel is exact, and a pane's includes all bounces between its faces; polarisation by the
/// Mueller matrices of an interface (Collett 2005, "Field Guide to Polarization").
GlassSample sample_glass(const SurfacePoint& p, const glm::vec3& direction, float alpha, const glm::vec2& u,
                         float choice, Polarisation* polarisation);

}  // namespace maquette
