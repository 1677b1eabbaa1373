#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace maquette {

/// The vehicle's axes in the scene, unit: x rearward, y to the right, z up.
struct VehicleAxes {
  glm::dvec3 rearward{0.0, 0.0, -1.0};
  glm::dvec3 right{-1.0, 0.0, 0.0};
  glm::dvec3 up{0.0, 1.0, 0.0};
};
/// From three signed axes of the scene, as `-z,-x,+y` (the default: the vehicle drives towards +Z). Throws UsageError
/// where they are not three different axes or form no right-handed vehicle system.
VehicleAxes vehicle_axes(const std::string& text);

/// Where the driver's eye is.
struct EyePlace {
  std::string point = "V1";       ///< `V1`, `V2`, or `x,y,z` in millimetres from the R-point, vehicle axes
  bool right_hand_drive = false;  ///< V1 and V2 are then on the other side of the R-point
};
/// Eye in metres in the scene. V1 = (68, -5, 665) and V2 = (68, -5, 589) mm at 25 degrees of seat back. Source:
/// 78/318/EEC, Annex IV. Throws UsageError for an unknown point.
glm::dvec3 eye_from_r_point(const glm::dvec3& r_point_m, const VehicleAxes& axes, const EyePlace& place);

/// Both eyes of a head whose middle is `eye_m`: left, right, 65 mm apart.
std::vector<glm::dvec3> both_eyes(const glm::dvec3& eye_m, const VehicleAxes& axes);
/// `columns` x `rows` eyes, row by row from the top left as the driver sees them, in the plane across the vehicle
/// through `eye_m`, `width_m` and `height_m` in all. One column or row is in the middle.
std::vector<glm::dvec3> eye_grid(const glm::dvec3& eye_m, const VehicleAxes& axes, int columns, int rows,
                                 double width_m, double height_m);

}  // namespace maquette
