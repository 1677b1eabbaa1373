#pragma once

#include "render/renderer.h"
#include "scenes/scene.h"

/// Moves of the camera by mouse and keys. Plain functions; all keep `up`, and all but fit_aspect keep the field of
/// view.
namespace maquette {

/// Rotates the eye about the target: yaw about `up`, pitch about the camera's right, never over the pole.
void orbit(CameraView* camera, float yaw_rad, float pitch_rad);
/// Rotates the view about the eye: yaw about `up`, pitch about the camera's right, never over the pole.
void look_around(CameraView* camera, float yaw_rad, float pitch_rad);
/// Moves eye and target so that points at the target's distance follow the mouse by (dx, dy) pixels, y down.
void pan(CameraView* camera, float dx_px, float dy_px, float height_px);
/// Moves the eye towards the target: one step is a tenth of the distance; never reaches it. An orthographic picture is
/// enlarged as much.
void dolly(CameraView* camera, float steps);
/// Moves eye and target by `motion` metres: x right, y up, z forward.
void fly(CameraView* camera, const glm::vec3& motion);
/// Puts the target at `distance_m` along the view without moving the picture: the pivot of the next orbit.
void set_target_distance(CameraView* camera, float distance_m);
/// Moves the eye back along the view until the bounding sphere fits in width and height.
void frame_bounds(CameraView* camera, const Bounds& bounds, float aspect);
/// Widens a view that was made for a wider picture, once, so that nothing is cut off at the sides.
void fit_aspect(CameraView* camera, float aspect);
/// Parallel rays or perspective: what is as far away as the target keeps its size.
void set_orthographic(CameraView* camera, bool orthographic);

}  // namespace maquette
