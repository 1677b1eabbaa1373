#include "shared/bindings.glsl"
#include "shared/frame_block.glsl"
#include "shared/surface_geometry.glsl"
layout(std140, binding = kBlockFrame) uniform Frame { FrameConstants u_frame; };

/// Ray through a point of the shading grid (in grid units, y down).
EyeRay ray_through(vec2 point) {
  vec2 ndc = 2.0 * point / vec2(u_frame.size.xy) - 1.0;
  return camera_ray(u_frame.forward.xyz, u_frame.right.xyz, u_frame.up.xyz, u_frame.eye.w, vec2(ndc.x, -ndc.y));
}
/// Position relative to the eye, m, of what a point of the shading grid shows at a depth.
vec3 position_through(vec2 point, float depth) {
  EyeRay ray = ray_through(point);
  return ray.origin + ray.direction * depth;
}
/// From where the ray through a world point starts to that point, m.
vec3 from_eye(vec3 world) {
  vec3 d = world - u_frame.eye.xyz;
  return u_frame.eye.w > 0.0 ? d : u_frame.forward.xyz * dot(u_frame.forward.xyz, d);
}
/// Width of a pixel at a depth, m.
float pixel_width(float depth) { return (u_frame.eye.w > 0.0 ? depth : 1.0) * u_frame.forward.w; }
/// Angle between the rays of neighbouring pixels, rad.
float pixel_angle() { return u_frame.eye.w * u_frame.forward.w; }

#ifdef REFLECTED
// The G-buffer is that of the surfaces in reflections: each pixel has its own mirrored ray, and depth is measured along it.
layout(binding = kUnitRayOrigin) uniform sampler2D t_ray_origin;        // m; w: depth of the pane
layout(binding = kUnitRayDirection) uniform sampler2D t_ray_direction;  // unit; w: reflector + 1, 0 where none is seen, below 0 where it is not followed
vec3 view_origin(ivec2 pixel) { return texelFetch(t_ray_origin, pixel, 0).xyz; }
vec3 view_ray(ivec2 pixel) { return texelFetch(t_ray_direction, pixel, 0).xyz; }
#else
vec3 view_origin(ivec2 pixel) { return u_frame.eye.xyz + ray_through(vec2(pixel) + 0.5).origin; }
vec3 view_ray(ivec2 pixel) { return ray_through(vec2(pixel) + 0.5).direction; }
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
