// Writes the nearest hit of each pixel to the images that all techniques share.
layout(local_size_x = 8, local_size_y = 8) in;
#include "shared/bindings.glsl"
#include "reflections/ray_triangle.glsl"
#include "reflections/tiles.glsl"
layout(std430, binding = kBufferNearest) readonly buffer Nearest { uvec2 b_nearest[]; };  // as reflections/resolve.comp has them
layout(binding = kUnitFocus) uniform sampler2D t_focus;  // 1/m, of the mirrored ray
layout(binding = kImageTriangle, r32ui) uniform writeonly uimage2D o_triangle;
layout(binding = kImageEffort, rg8ui) uniform writeonly uimage2D o_effort;
layout(binding = kImageLowConfidence, r8ui) uniform writeonly uimage2D o_low_confidence;
layout(std430, binding = kBufferHitCounters) buffer Counters { uint b_low_confidence_count; };
layout(binding = kUnitTriangleGroups) uniform usamplerBuffer t_group;  // of each triangle
layout(std430, binding = kBufferSeenGroups) writeonly buffer Seen { uint b_seen[]; };  // [group]
uniform int u_group_count;  // 0: groups are not needed
uniform uint u_shortest;  // bit k: for reflector k the technique has found only shortest paths
uniform int u_channel;    // of the effort: 0: steps, 1: root
uniform vec3 u_low;       // box of what can be mirrored, m
uniform vec3 u_high;

/// Distance at which the ray leaves the box of all that can be mirrored.
float exit_distance(vec3 origin, vec3 direction) {
  vec3 d = mix(direction, vec3(1e-20), lessThan(abs(direction), vec3(1e-20)));
  vec3 t = max((u_low - origin) / d, (u_high - origin) / d);
  return max(min(min(t.x, t.y), t.z), 0.0);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = textureSize(t_ray_direction, 0);
  if (any(greaterThanEqual(pixel, size))) return;
  uint found = b_nearest[pixel.y * size.x + pixel.x].x;
  uint triangle = found >> kEffortBits, effort = found & ((1u << kEffortBits) - 1u);
  imageStore(o_triangle, pixel, uvec4(triangle));
  imageStore(o_effort, pixel, u_channel == 0 ? uvec4(effort, 0u, 0u, 0u) : uvec4(0u, effort, 0u, 0u));
  if (u_group_count > 0 && triangle != 0u) b_seen[texelFetch(t_group, int(triangle) - 1).x] = 1u;
  vec4 direction = texelFetch(t_ray_direction, pixel, 0);
  int reflector = int(direction.w) - 1;
  if (reflector < 0 || (u_shortest >> uint(reflector) & 1u) == 0u) return;
  // A shortest path ends before the ray's caustic. Objects beyond it are seen by other kinds of paths, which the search does not find, so the
  // confidence in this hit is low.
  vec3 origin = texelFetch(t_ray_origin, pixel, 0).xyz;
  float focus = texelFetch(t_focus, pixel, 0).x;
  float hit_m = triangle != 0u ? distance_to(origin, direction.xyz, fetch_triangle(int(triangle) - 1)) : exit_distance(origin, direction.xyz);
  if (hit_m * focus <= 1.0) return;
  imageStore(o_low_confidence, pixel, uvec4(1u));
  atomicAdd(b_low_confidence_count, 1u);
}
