#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <optional>

#include "render/inspection/pane_optics.h"
#include "render/reference/reference.h"
#include "render/reference/traversal.h"

namespace maquette {

/// What a ray meets first, panes apart.
struct Met {
  bool surface = false;  ///< false: the sky
  int node = -1, material = -1;
  double distance_m = 0.0;
  glm::dvec3 position{0.0};
};

/// A pane as one eye ray sees it, by the geometry that the path tracer follows.
struct PaneSight {
  int node = -1, material = -1;
  glm::dvec3 position{0.0};
  glm::dvec3 normal{0.0, 1.0, 0.0};  ///< unit, shading normal on the eye's side
  double distance_m = 0.0;           ///< from the eye
  double incidence_rad = 0.0;
  double refractive_index = 1.0;
  double inside = 1.0;  ///< internal transmittance of one crossing, by luminance
  PaneOptics optics;    ///< by luminance over the channels
  /// Share of s-polarised light that a vertical polariser (sunglasses) before the eye lets through; p-polarised light
  /// has the rest.
  double s_through_sunglasses = 0.0;
  Met mirrored;  ///< distances from the pane
};

/// What lies along one eye ray.
struct Sight {
  std::optional<PaneSight> pane;  ///< the nearest
  Met behind;                     ///< what is seen through all panes; distance from the eye
};

/// Follows an eye ray, its direction unit, through the scene, from `near` to `far`; mirror images are whole. `up`:
/// unit, of the eye, for sunglasses. Thread-safe.
Sight look_along(const PathScene& scene, const Ray& ray, const glm::dvec3& up);

/// By which factor light changes where only one polarisation, or what sunglasses let through, is counted.
enum class Polarisation { all, s, p, sunglasses };
/// Factor of the light that a pane reflects (`reflected`) or transmits, against that of both polarisations; the light
/// that arrives at the pane is taken as unpolarised. 1 without a pane, but for sunglasses: they let half through.
double polarisation_factor(const std::optional<PaneSight>& pane, Polarisation polarisation, bool reflected);

/// Mean over the outer faces of the panes of a node, seen from `inside_m`.
struct PaneLight {
  double illuminance_lx = 0.0;     ///< of the environment, on the outer face, shadowed by the scene
  double unshadowed_lx = 0.0;      ///< the same without the scene
  double transmitted_share = 0.0;  ///< of it, through the pane
  double rake_deg = 0.0;           ///< of the mean plane, from the vertical
  glm::dvec3 normal{0.0};          ///< mean, outwards, unit
  glm::dvec3 middle{0.0};
  double lowest_m = 0.0;  ///< height of its lowest corner
};
/// Of the illuminance by `environment`. Nothing where the node has no pane.
std::optional<PaneLight> light_on_pane(const PathScene& scene, const Environment& environment, float rotation_rad,
                                       float env_scale, int node, const glm::dvec3& inside_m);

}  // namespace maquette
