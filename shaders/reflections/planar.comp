// Offers triangles for a plane mirror, projected from the mirrored eye: those of the clusters that may be in the mirror's window.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "reflections/nearest.glsl"
layout(std430, binding = kBufferPlanarTriangles) readonly buffer Triangles { uint b_triangles[]; };
uniform mat4 u_clip_from_world;  // mirrors first
uniform vec4 u_plane;            // towards the eye
uniform vec4 u_window;           // visible part of the mirror: lower and upper corner, px
uniform int u_reflector;
uniform int u_first;
uniform int u_count;
uniform float u_margin_px;
uniform float u_px_rad;  // angle of a pixel in the middle of the picture

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= u_count) return;
  int triangle = int(b_triangles[u_first + i]);
  vec2 size = vec2(textureSize(t_ray_direction, 0)), at[3];
  float highest = -1e30, nearest = 1e30;
  for (int k = 0; k < 3; ++k) {
    vec4 p = vec4(texelFetch(t_vertices, 4 * int(texelFetch(t_indices, 3 * triangle + k).x)).xyz, 1.0);
    vec4 clip = u_clip_from_world * p;
    highest = max(highest, dot(u_plane, p));
    nearest = min(nearest, clip.w);
    at[k] = (0.5 * vec2(clip.x, -clip.y) / clip.w + 0.5) * size;
  }
  if (highest <= 0.0) return;
  // The path length is at least clip.w; away from the axis pixels cover smaller angles.
  float margin_px = u_margin_px + 2.0 * kGhostSlack * ghost_offset(nearest) / (nearest * u_px_rad);
  vec2 low = min(min(at[0], at[1]), at[2]) - margin_px, high = max(max(at[0], at[1]), at[2]) + margin_px;
  uint own = offered(triangle, 0);
  if (nearest <= 1e-6)  // around the mirrored eye
    offer_triangle(u_window.xy, u_window.zw, u_window.xy, kBoxOnly, 0.0, own, u_reflector);
  else if (all(greaterThanEqual(high, u_window.xy)) && all(lessThanEqual(low, u_window.zw)))
    offer_triangle(at[0], at[1], at[2], margin_px, 0.0, own, u_reflector);
}
