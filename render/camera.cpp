#include "render/camera.h"

#include <algorithm>
#include <cmath>

namespace maquette {

bool operator==(const CameraView& a, const CameraView& b) {
  return a.eye == b.eye && a.target == b.target && a.up == b.up && a.fov_y_rad == b.fov_y_rad && a.near_m == b.near_m &&
         a.far_m == b.far_m;
}

CameraFrame make_camera_frame(const CameraView& view, int width, int height, const Bounds& bounds) {
  CameraFrame frame;
  frame.eye = view.eye;
  frame.forward = glm::normalize(view.target - view.eye);
  glm::vec3 right = glm::cross(frame.forward, view.up);
  if (glm::dot(right, right) < 1e-12f) right = glm::cross(frame.forward, glm::vec3(0.0f, 0.0f, 1.0f));
  if (glm::dot(right, right) < 1e-12f) right = glm::vec3(1.0f, 0.0f, 0.0f);
  frame.right = glm::normalize(right);
  frame.up = glm::cross(frame.right, frame.forward);
  frame.tan_y = std::tan(0.5f * view.fov_y_rad);
  frame.tan_x = frame.tan_y * (static_cast<float>(width) / static_cast<float>(height));
  const float extent = bounds.empty() ? 1.0f : bounds.radius() + glm::length(view.eye - bounds.center());
  frame.near_m = view.near_m > 0.0f ? view.near_m : std::max(extent * 1e-4f, 1e-30f);
  return frame;
}

}  // namespace maquette
