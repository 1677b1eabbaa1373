#include "ui/camera_control.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace maquette {

namespace {

constexpr float kPoleMargin_rad = 0.02f;

struct Basis {
  glm::vec3 forward{}, right{}, up{};
};

Basis basis_of(const CameraView& camera) {
  Basis basis;
  basis.forward = glm::normalize(camera.target - camera.eye);
  const glm::vec3 side = glm::cross(basis.forward, camera.up);
  basis.right = glm::dot(side, side) > 1e-12f ? glm::normalize(side) : glm::vec3(1.0f, 0.0f, 0.0f);
  basis.up = glm::cross(basis.right, basis.forward);
  return basis;
}

/// `forward` rotated by yaw and pitch, short of the poles of `camera.up`.
glm::vec3 rotated(const CameraView& camera, float yaw_rad, float pitch_rad) {
  const Basis basis = basis_of(camera);
  const glm::vec3 up = glm::normalize(camera.up);
  const float elevation = std::asin(std::clamp(glm::dot(basis.forward, up), -1.0f, 1.0f));
  const float limit = glm::half_pi<float>() - kPoleMargin_rad;
  // A camera that starts beyond the limit may only move back.
  const float wanted = std::clamp(elevation + pitch_rad, std::min(-limit, elevation), std::max(limit, elevation));
  const glm::quat rotation = glm::angleAxis(yaw_rad, up) * glm::angleAxis(wanted - elevation, basis.right);
  return glm::normalize(rotation * basis.forward);
}

}  // namespace

void orbit(CameraView* camera, float yaw_rad, float pitch_rad) {
  const float distance = glm::length(camera->target - camera->eye);
  camera->eye = camera->target - distance * rotated(*camera, yaw_rad, pitch_rad);
}

void look_around(CameraView* camera, float yaw_rad, float pitch_rad) {
  const float distance = glm::length(camera->target - camera->eye);
  camera->target = camera->eye + distance * rotated(*camera, yaw_rad, pitch_rad);
}

void pan(CameraView* camera, float dx_px, float dy_px, float height_px) {
  const Basis basis = basis_of(*camera);
  const float distance = glm::length(camera->target - camera->eye);
  const float metres = camera->height_at(distance) / std::max(height_px, 1.0f);
  const glm::vec3 shift = metres * (dy_px * basis.up - dx_px * basis.right);
  camera->eye += shift;
  camera->target += shift;
}

void dolly(CameraView* camera, float steps) {
  const float factor = std::pow(0.9f, std::clamp(steps, -40.0f, 40.0f));
  if (camera->is_orthographic()) {
    camera->height_m = std::clamp(factor * camera->height_m, 1e-15f, 1e15f);
    return;
  }
  const glm::vec3 eye = camera->target + factor * (camera->eye - camera->target);
  // Not so near that eye and target become equal in float.
  const float distance = glm::length(eye - camera->target);
  if (distance > 1e-5f * glm::length(camera->target) && distance > 1e-15f) camera->eye = eye;
}

void fly(CameraView* camera, const glm::vec3& motion) {
  const Basis basis = basis_of(*camera);
  const glm::vec3 shift = motion.x * basis.right + motion.y * glm::normalize(camera->up) + motion.z * basis.forward;
  camera->eye += shift;
  camera->target += shift;
}

void set_target_distance(CameraView* camera, float distance_m) {
  if (!(distance_m > 0.0f) || !std::isfinite(distance_m)) return;
  const glm::vec3 target = camera->eye + distance_m * basis_of(*camera).forward;
  if (target != camera->eye) camera->target = target;
}

void frame_bounds(CameraView* camera, const Bounds& bounds, float aspect) {
  if (bounds.empty()) return;
  const glm::vec3 forward = basis_of(*camera).forward;
  const float half_y = 0.5f * camera->fov_y_rad;
  const float half_x = std::atan(std::tan(half_y) * std::max(aspect, 1e-3f));
  const float radius = std::max(bounds.radius(), 1e-6f);
  camera->target = bounds.center();
  if (camera->is_orthographic()) {
    camera->height_m = 2.0f * radius / std::min(1.0f, std::max(aspect, 1e-3f));
    camera->eye = camera->target - 2.0f * radius * forward;
    return;
  }
  camera->eye = camera->target - forward * (radius / std::sin(std::min(half_x, half_y)));
}

void fit_aspect(CameraView* camera, float aspect) {
  if (camera->aspect > aspect) {
    const float growth = camera->aspect / std::max(aspect, 0.1f);
    camera->fov_y_rad = 2.0f * std::atan(std::tan(0.5f * camera->fov_y_rad) * growth);
    camera->height_m *= growth;
  }
  camera->aspect = 0.0f;
}

void set_orthographic(CameraView* camera, bool orthographic) {
  if (camera->is_orthographic() == orthographic) return;
  const float distance = glm::length(camera->target - camera->eye);
  if (orthographic) {
    camera->height_m = camera->height_at(distance);
  } else {
    const glm::vec3 forward = basis_of(*camera).forward;
    const float wanted = 0.5f * camera->height_m / std::tan(0.5f * camera->fov_y_rad);
    camera->height_m = 0.0f;
    const glm::vec3 eye = camera->target - wanted * forward;
    if (eye != camera->target) camera->eye = eye;
  }
}

}  // namespace maquette
