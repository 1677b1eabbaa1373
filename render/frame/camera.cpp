#include "render/frame/camera.h"

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

glm::mat4 clip_from_world(const CameraFrame& camera) {
  glm::mat4 view(1.0f), projection(0.0f);
  for (int c = 0; c < 3; ++c) {
    view[c][0] = camera.right[c];
    view[c][1] = camera.up[c];
    view[c][2] = -camera.forward[c];
  }
  view[3] = glm::vec4(-glm::dot(camera.right, camera.eye), -glm::dot(camera.up, camera.eye),
                      glm::dot(camera.forward, camera.eye), 1.0f);
  projection[0][0] = 1.0f / camera.tan_x;
  projection[1][1] = 1.0f / camera.tan_y;
  projection[2][3] = -1.0f;
  projection[3][2] = camera.near_m;
  return projection * view;
}

bool may_be_seen(const glm::mat4& clip_from_world, const Bounds& bounds) {
  int outside[5] = {};
  for (int k = 0; k < 8; ++k) {
    const glm::vec4 p =
        clip_from_world * glm::vec4(k & 1 ? bounds.max.x : bounds.min.x, k & 2 ? bounds.max.y : bounds.min.y,
                                    k & 4 ? bounds.max.z : bounds.min.z, 1.0f);
    outside[0] += p.x < -p.w;
    outside[1] += p.x > p.w;
    outside[2] += p.y < -p.w;
    outside[3] += p.y > p.w;
    outside[4] += p.w < 0.0f;
  }
  return std::none_of(outside, outside + 5, [](int n) { return n == 8; });
}

}  // namespace maquette
