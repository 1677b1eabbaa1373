#include "render/frame/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "render/math/shared_formulas.h"
#include "scenes/error.h"

namespace maquette {

float CameraView::height_at(float distance_m) const {
  return is_orthographic() ? height_m : 2.0f * std::tan(0.5f * fov_y_rad) * distance_m;
}

bool operator==(const CameraView& a, const CameraView& b) {
  return a.eye == b.eye && a.target == b.target && a.up == b.up && a.fov_y_rad == b.fov_y_rad &&
         a.height_m == b.height_m && a.near_m == b.near_m && a.far_m == b.far_m && a.section == b.section;
}

void require_usable(const CameraView& camera) {
  constexpr float kFarthest_m = 1e12f;  // squares and products of coordinates are finite
  for (const auto& [what, p] : {std::pair{"eye", camera.eye}, std::pair{"target", camera.target}})
    for (int c = 0; c < 3; ++c)
      if (!(std::abs(p[c]) <= kFarthest_m))
        throw Error("camera", std::string("its ") + what + " is farther than 1e12 m from the origin", "move it nearer");
}

namespace {

/// No far piece moves the near plane beyond this: reversed depth in floats resolves 2^-24 of any distance.
constexpr float kNearest_m = 1e-3f;

/// Moves the eye of an orthographic camera near to what is drawn, and sets the range of depths.
void set_depths(const Bounds& bounds, CameraFrame* frame) {
  frame->near_m = std::max(frame->near_m, 0.0f);
  frame->nearest_m = frame->near_m;
  frame->farthest_m = frame->near_m + 1.0f;
  if (bounds.empty()) return;
  const glm::dvec3 forward(frame->forward), half = 0.5 * (glm::dvec3(bounds.max) - glm::dvec3(bounds.min));
  const double middle =
      glm::dot(forward, 0.5 * (glm::dvec3(bounds.max) + glm::dvec3(bounds.min)) - glm::dvec3(frame->eye));
  // A little beyond, so that faces of the bounds are within.
  const double reach = 1.0001 * glm::dot(glm::abs(forward), half) + 1e-6 * bounds.radius();
  const double moved = std::max(middle - 2.0 * reach, 0.0);
  frame->eye = glm::vec3(glm::dvec3(frame->eye) + moved * forward);
  frame->near_m = static_cast<float>(std::max(frame->near_m - moved, 0.0));
  frame->nearest_m = std::max(frame->near_m, static_cast<float>(middle - moved - reach));
  frame->farthest_m = std::max(static_cast<float>(middle - moved + reach), frame->nearest_m + 1e-6f);
}

}  // namespace

CameraFrame make_camera_frame(const CameraView& view, int width, int height, const Bounds& bounds) {
  CameraFrame frame;
  frame.eye = view.eye;
  frame.section = view.section;
  frame.forward = glm::normalize(view.target - view.eye);
  glm::vec3 right = glm::cross(frame.forward, view.up);
  if (glm::dot(right, right) < 1e-12f) right = glm::cross(frame.forward, glm::vec3(0.0f, 0.0f, 1.0f));
  if (glm::dot(right, right) < 1e-12f) right = glm::vec3(1.0f, 0.0f, 0.0f);
  frame.right = glm::normalize(right);
  frame.up = glm::cross(frame.right, frame.forward);
  frame.orthographic = view.is_orthographic();
  frame.half_y = frame.orthographic ? 0.5f * view.height_m : std::tan(0.5f * view.fov_y_rad);
  frame.half_x = frame.half_y * (static_cast<float>(width) / static_cast<float>(height));
  const float extent = bounds.empty() ? 1.0f : bounds.radius() + glm::length(view.eye - bounds.center());
  frame.near_m = view.near_m > 0.0f ? view.near_m : std::max(std::min(extent * 1e-4f, kNearest_m), 1e-30f);
  if (frame.orthographic) set_depths(bounds, &frame);
  return frame;
}

EyeRay CameraFrame::ray_through(const glm::vec2& ndc) const {
  const shared::EyeRay ray = shared::camera_ray(forward, right * half_x, up * half_y, orthographic ? 0.0f : 1.0f, ndc);
  return {eye + ray.origin, ray.direction};
}

glm::vec2 CameraFrame::seen_depths(const EyeRay& ray) const {
  glm::vec2 depths(near_m, std::numeric_limits<float>::max());
  const glm::vec3 normal(section);
  if (normal == glm::vec3(0.0f)) return depths;
  const float outside_m = glm::dot(normal, ray.origin) - section.w, rate = glm::dot(normal, ray.direction);
  if (rate == 0.0f) {
    if (outside_m > 0.0f) depths.y = depths.x;
    return depths;
  }
  const float crossing = -outside_m / rate;
  if (rate < 0.0f)
    depths.x = std::max(depths.x, crossing);
  else
    depths.y = std::max(std::min(depths.y, crossing), depths.x);
  return depths;
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
  projection[0][0] = 1.0f / camera.half_x;
  projection[1][1] = 1.0f / camera.half_y;
  if (camera.orthographic) {
    const float range_m = camera.farthest_m - camera.nearest_m;
    projection[2][2] = 1.0f / range_m;
    projection[3][2] = camera.farthest_m / range_m;
    projection[3][3] = 1.0f;
  } else {
    projection[2][3] = -1.0f;
    projection[3][2] = camera.near_m;
  }
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
