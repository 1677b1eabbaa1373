#pragma once

#include "scenes/modelling.h"

/// The exterior form of the built-in car, as a solid: primary surfaces (sides, top, nose, tail, windshield, roof, side
/// glass, rear glass) intersected and joined with rounded edges. Metres; +Z is forward, +X left, y = 0 the road, z = 0
/// halfway between the axles. Symmetric about x = 0.
namespace maquette::builtin {

inline constexpr double kAxleFront_m = 1.33;
inline constexpr double kAxleRear_m = -1.33;
inline constexpr double kWheelRadius_m = 0.335;
inline constexpr double kArchRadius_m = 0.372;

/// Plane chart of a pane: height along `normal` over (x, s), s along the pane upwards, bent by -bow_x x^2 - bow_s s^2.
struct PaneChart {
  modelling::Vec3 origin;
  modelling::Vec3 along;
  modelling::Vec3 normal;
  double bow_x;
  double bow_s;
  double s(const modelling::Vec3& p) const { return glm::dot(p - origin, along); }
  /// Positive outside.
  double height(const modelling::Vec3& p) const {
    const double v = s(p);
    return glm::dot(p - origin, normal) + bow_x * p.x * p.x + bow_s * v * v;
  }
  modelling::Vec3 point(double x, double v) const {
    return origin + modelling::Vec3(x, 0.0, 0.0) + v * along - (bow_x * x * x + bow_s * v * v) * normal;
  }
};

const PaneChart& windshield_chart();
const PaneChart& rear_glass_chart();

/// Signed functions, negative inside; roughly distances in metres.
double lower_body(const modelling::Vec3& p);
double canopy(const modelling::Vec3& p);
double car_body(const modelling::Vec3& p);
/// Side of the canopy alone (the side glass and its continuation).
double canopy_side(const modelling::Vec3& p);
double canopy_roof(const modelling::Vec3& p);

/// Outward normal of car_body.
modelling::Vec3 skin_normal(const modelling::Vec3& p);

/// Height of the belt line (lower edge of the side glass).
double belt_height(double z);
/// x of the left flank at (y, z), found along x.
double flank_x(double y, double z);

/// Outlines on the body, negative inside; they hold for the left half.
double door_outline(const modelling::Vec3& p);
double windshield_outline(const modelling::Vec3& p);
double rear_glass_outline(const modelling::Vec3& p);
double side_glass_outline(const modelling::Vec3& p);
double hood_outline(const modelling::Vec3& p);
double wheel_arches(const modelling::Vec3& p);

/// Left half of the whole skin as one mesh with exact normals, from the sills to the middle of the roof.
Primitive make_half_skin();

}  // namespace maquette::builtin
