#include "render/inspection/pane_optics.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "render/inspection/pane_formulas.h"

namespace maquette {

namespace {

double inner_root(double incidence_rad, double n) {
  const double s = std::sin(incidence_rad);
  return std::sqrt(n * n - s * s);
}

}  // namespace

PaneOptics pane_optics(double incidence_rad, double refractive_index, double inside) {
  const double c = std::cos(incidence_rad);
  const glm::dvec2 face = pane_double::fresnel_sp(c, refractive_index);
  const pane_double::PolarisedPane pane = pane_double::fresnel_pane_sp(c, refractive_index, inside);
  return {{face.x, face.y}, {pane.reflected.x, pane.reflected.y}, {pane.transmitted.x, pane.transmitted.y}};
}

double ghost_offset_m(double incidence_rad, double refractive_index, double thickness_m) {
  return thickness_m * std::sin(2.0 * incidence_rad) / inner_root(incidence_rad, refractive_index);
}

double ghost_angle_rad(const GhostView& v) {
  // The front face is y = 0; the eye looks towards +x and down, the first image meets the face at the origin. The
  // second one is that of an eye ray turned by an angle at which it passes through the object.
  const glm::dvec3 up(0.0, 1.0, 0.0), back(-std::sin(v.wedge_rad), std::cos(v.wedge_rad), 0.0);
  const double s = std::sin(v.incidence_rad), c = std::cos(v.incidence_rad);
  const bool far = std::isinf(v.object_m);
  const glm::dvec3 eye(-v.eye_m * s, v.eye_m * c, 0.0), to_object(s, c, 0.0);
  const glm::dvec3 object = to_object * (far ? 0.0 : v.object_m);
  // How far the ray of the eye that is turned by `angle` passes beside the object: m, or for a far one an angle.
  const auto miss = [&](double angle) {
    const double turned = v.incidence_rad + angle;
    const glm::dvec3 direction(std::sin(turned), -std::cos(turned), 0.0);
    const double t = -eye.y / direction.y;
    const pane_double::GhostRay ghost =
        pane_double::pane_ghost(direction, up, back, up, v.refractive_index, v.thickness_m);
    if (!ghost.valid) return std::numeric_limits<double>::quiet_NaN();
    const glm::dvec3 from = eye + direction * t + ghost.offset;
    const glm::dvec3 way = far ? to_object : object - from;
    return ghost.direction.x * way.y - ghost.direction.y * way.x;
  };
  // Secant steps: nearly linear over the few minutes of arc in question.
  double a = 0.0, b = -ghost_angle_first_order_rad(v), at_a = miss(a), at_b = miss(b);
  if (b == 0.0) {
    b = 1e-6;
    at_b = miss(b);
  }
  for (int i = 0; i < 20 && at_b != at_a && std::abs(b - a) > 1e-14; ++i) {
    const double next = b - at_b * (b - a) / (at_b - at_a);
    a = b;
    at_a = at_b;
    b = next;
    at_b = miss(b);
  }
  return std::isfinite(at_b) ? -b : std::numeric_limits<double>::quiet_NaN();
}

double ghost_angle_first_order_rad(const GhostView& v) {
  const double turned = 2.0 * v.wedge_rad * inner_root(v.incidence_rad, v.refractive_index) / std::cos(v.incidence_rad);
  const double offset = ghost_offset_m(v.incidence_rad, v.refractive_index, v.thickness_m);
  if (std::isinf(v.object_m)) return -turned;
  return (offset - turned * v.object_m) / (v.object_m + v.eye_m);
}

double wedge_without_ghost_rad(const GhostView& v) {
  const double s = std::sin(v.incidence_rad), c = std::cos(v.incidence_rad);
  return v.thickness_m * s * c * c / ((v.refractive_index * v.refractive_index - s * s) * v.object_m);
}

double secondary_image_angle_rad(double incidence_rad, double refractive_index, double thickness_m, double wedge_rad,
                                 double radius_m) {
  const double root = inner_root(incidence_rad, refractive_index);
  const double curved = std::isinf(radius_m) ? 0.0 : thickness_m * std::sin(incidence_rad) / (radius_m * root);
  return 2.0 * (wedge_rad * root / std::cos(incidence_rad) - curved);
}

double flat_veil_cdm2(double illuminance_lx, double transmittance, double reflectance, double pane_reflectance) {
  return illuminance_lx * transmittance * reflectance * std::numbers::inv_pi * pane_reflectance;
}

double contrast_kept(double seen_cdm2, double veil_cdm2) {
  const double sum = seen_cdm2 + veil_cdm2;
  return sum > 0.0 ? seen_cdm2 / sum : 0.0;
}

}  // namespace maquette
