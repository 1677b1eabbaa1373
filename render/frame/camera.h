#pragma once

#include <glm/glm.hpp>

#include "scenes/scene.h"

namespace maquette {

struct CameraView {
  glm::vec3 eye{0.0f, 0.0f, 3.0f};
  glm::vec3 target{0.0f};
  glm::vec3 up{0.0f, 1.0f, 0.0f};
  float fov_y_rad = 0.8f;
  float near_m = 0.0f;  ///< 0: derived from the scene bounds
  float far_m = 0.0f;
  float aspect = 0.0f;  ///< width over height that the view was framed for; 0: any
};
bool operator==(const CameraView& a, const CameraView& b);

/// The camera as all modes use it: the ray of a pixel is forward + ndc_x right tan_x + ndc_y up tan_y.
struct CameraFrame {
  glm::vec3 eye{0.0f};
  glm::vec3 forward{0.0f}, right{0.0f}, up{0.0f};  ///< unit
  float tan_x = 1.0f, tan_y = 1.0f;                ///< of half the field of view
  float near_m = 0.0f;                             ///< along `forward`
};
/// `bounds`: of what is drawn, to derive a near plane that the view does not give.
CameraFrame make_camera_frame(const CameraView& view, int width, int height, const Bounds& bounds);

/// Reversed depth: 1 at the near plane, 0 at infinity, so that float resolves near and far equally well.
glm::mat4 clip_from_world(const CameraFrame& camera);
/// Conservative: false when a box is outside one of the frustum's side planes (in clip space; the far plane is at
/// infinity).
bool may_be_seen(const glm::mat4& clip_from_world, const Bounds& bounds);

}  // namespace maquette
