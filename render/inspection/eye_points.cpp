#include "render/inspection/eye_points.h"

#include <cstdio>

#include "scenes/error.h"

namespace maquette {

namespace {

constexpr double kEyeDistance_m = 0.065;
const glm::dvec3 kV1_mm(68.0, -5.0, 665.0), kV2_mm(68.0, -5.0, 589.0);

glm::dvec3 offset_of(const EyePlace& place) {
  const glm::dvec3 mirrored(1.0, place.right_hand_drive ? -1.0 : 1.0, 1.0);
  if (place.point == "V1" || place.point == "v1") return kV1_mm * mirrored;
  if (place.point == "V2" || place.point == "v2") return kV2_mm * mirrored;
  glm::dvec3 v{};
  char rest = 0;
  if (std::sscanf(place.point.c_str(), "%lf,%lf,%lf%c", &v.x, &v.y, &v.z, &rest) == 3) return v;
  throw UsageError("--eye-point", "\"" + place.point + "\" is neither V1, V2 nor x,y,z",
                   "write millimetres from the R-point: rearward, right, up");
}

}  // namespace

VehicleAxes vehicle_axes(const std::string& text) {
  const auto fail = [&]() -> glm::dvec3 {
    throw UsageError("--vehicle-axes", "\"" + text + "\" is not of the form -z,-x,+y",
                     "name the scene's axes of rearward, right and up, which are three and right-handed");
  };
  std::vector<glm::dvec3> axes;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::string word = text.substr(begin, end - begin);
    const double sign = word.starts_with('-') ? -1.0 : 1.0;
    if (word.starts_with('-') || word.starts_with('+')) word.erase(0, 1);
    if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') fail();
    glm::dvec3 axis(0.0);
    axis[word[0] - 'x'] = sign;
    axes.push_back(axis);
    begin = end + 1;
  }
  if (axes.size() != 3 || glm::dot(glm::cross(axes[0], axes[1]), axes[2]) < 0.5) fail();
  return {axes[0], axes[1], axes[2]};
}

glm::dvec3 eye_from_r_point(const glm::dvec3& r_point_m, const VehicleAxes& axes, const EyePlace& place) {
  const glm::dvec3 o = 1e-3 * offset_of(place);
  return r_point_m + o.x * axes.rearward + o.y * axes.right + o.z * axes.up;
}

std::vector<glm::dvec3> both_eyes(const glm::dvec3& eye_m, const VehicleAxes& axes) {
  const glm::dvec3 half = 0.5 * kEyeDistance_m * axes.right;
  return {eye_m - half, eye_m + half};
}

std::vector<glm::dvec3> eye_grid(const glm::dvec3& eye_m, const VehicleAxes& axes, int columns, int rows,
                                 double width_m, double height_m) {
  const auto at = [](int i, int count) { return count > 1 ? static_cast<double>(i) / (count - 1) - 0.5 : 0.0; };
  std::vector<glm::dvec3> eyes;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      eyes.push_back(eye_m + at(column, columns) * width_m * axes.right - at(row, rows) * height_m * axes.up);
  return eyes;
}

}  // namespace maquette
