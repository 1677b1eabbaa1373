#include "shared/bindings.glsl"
#include "shared/frame_block.glsl"
#include "shared/surface_geometry.glsl"
layout(std140, binding = kBlockFrame) uniform Frame { FrameConstants u_frame; };

/// Ray through a point of the shading grid (in grid units, y down), not normalised: depth 1 along the viewing axis.
vec3 ray_through(vec2 point) {
  vec2 ndc = 2.0 * point / vec2(u_frame.size.xy) - 1.0;
  return camera_ray(u_frame.forward.xyz, u_frame.right.xyz, u_frame.up.xyz, vec2(ndc.x, -ndc.y));
}

#ifdef REFLECTED
// The G-buffer is that of the surfaces in reflections: each pixel has its own mirrored ray, and depth is measured along it.
layout(binding = kUnitRayOrigin) uniform sampler2D t_ray_origin;        // m; w: depth of the pane
layout(binding = kUnitRayDirection) uniform sampler2D t_ray_direction;  // unit; w: reflector + 1, 0 where none is seen, below 0 where it is not followed
vec3 view_origin(ivec2 pixel) { return texelFetch(t_ray_origin, pixel, 0).xyz; }
vec3 view_ray(ivec2 pixel) { return texelFetch(t_ray_direction, pixel, 0).xyz; }
#else
vec3 view_origin(ivec2 pixel) { return u_frame.eye.xyz; }
vec3 view_ray(ivec2 pixel) { return ray_through(vec2(pixel) + 0.5); }
#endif

/// World direction to the environment's own frame (its rotation undone) and back. Positive rotation is from +Z towards +X.
vec3 environment_from_world(vec3 d) {
  return vec3(u_frame.environment.x * d.x - u_frame.environment.y * d.z, d.y,
              u_frame.environment.y * d.x + u_frame.environment.x * d.z);
}
vec3 world_from_environment(vec3 d) {
  return vec3(u_frame.environment.x * d.x + u_frame.environment.y * d.z, d.y,
              -u_frame.environment.y * d.x + u_frame.environment.x * d.z);
}
