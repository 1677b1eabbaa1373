#pragma once

#include <glm/glm.hpp>

#include "scenes/scene.h"

namespace maquette {

struct CameraView {
  glm::vec3 eye{0.0f, 0.0f, 3.0f};
  glm::vec3 target{0.0f};
  glm::vec3 up{0.0f, 1.0f, 0.0f};
  float fov_y_rad = 0.8f;
  float height_m = 0.0f;  ///< of what an orthographic camera shows; 0: perspective
  float near_m = 0.0f;    ///< 0: derived from the scene bounds
  float far_m = 0.0f;
  float aspect = 0.0f;  ///< width over height that the view was framed for; 0: any
  /// Section plane: the eye sees points p with dot(xyz, p) <= w, metres, xyz unit; 0: all. What casts shadows, what
  /// lights and what is mirrored stays whole.
  glm::vec4 section{0.0f};

  bool is_orthographic() const { return height_m > 0.0f; }
  /// Of what is seen at a distance along the viewing axis, m.
  float height_at(float distance_m) const;
};
bool operator==(const CameraView& a, const CameraView& b);

/// Throws Error where an eye or target is so far away, or no number at all, that no ray starts there.
void require_usable(const CameraView& camera);

struct EyeRay {
  glm::vec3 origin{0.0f};
  glm::vec3 direction{0.0f};  ///< not normalised: its parameter is the depth along the viewing axis, m
};

/// The camera as all modes use it.
struct CameraFrame {
  glm::vec3 eye{0.0f};
  glm::vec3 forward{0.0f}, right{0.0f}, up{0.0f};  ///< unit
  float half_x = 1.0f, half_y = 1.0f;  ///< half the picture at depth 1 m, or of an orthographic camera everywhere, m
  bool orthographic = false;
  float near_m = 0.0f;  ///< along `forward`
  /// Depths of what is drawn, m; of orthographic cameras only.
  float nearest_m = 0.0f, farthest_m = 1.0f;
  glm::vec4 section{0.0f};  ///< of the view

  /// `ndc`: y up.
  EyeRay ray_through(const glm::vec2& ndc) const;
  /// Depths x to y of what is seen along a ray: beyond the near plane, on the seen side of the section plane; empty
  /// where x >= y.
  glm::vec2 seen_depths(const EyeRay& ray) const;
};
/// `bounds`: of what is drawn, to derive a near plane that the view does not give. The eye of an orthographic camera is
/// moved along the axis to just before the bounds: the picture is the same, and depths keep their precision.
CameraFrame make_camera_frame(const CameraView& view, int width, int height, const Bounds& bounds);

/// Reversed depth: 1 at the near plane, 0 at infinity, so that float resolves near and far equally well. Of
/// orthographic cameras linear, 1 at the nearest and 0 at the farthest point of the bounds.
glm::mat4 clip_from_world(const CameraFrame& camera);
/// Conservative: false when a box is outside one of the frustum's side planes (in clip space; the far plane is at
/// infinity).
bool may_be_seen(const glm::mat4& clip_from_world, const Bounds& bounds);

}  // namespace maquette
