// Draws the vertices as points where the patch shows them: without edges nothing can tear (the robust case of the thesis). The nearest at a
// pixel is found in three rounds: its distance; clearing what is farther; its triangle.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
layout(binding = kUnitRayDirection) uniform sampler2D t_ray_direction;  // w: reflector + 1
layout(binding = kUnitProjected) uniform usamplerBuffer t_projected;    // as bezier/vertices.comp writes it
layout(std430, binding = kBufferBezierCounters) buffer Counters { uint b_counters[16]; };
layout(std430, binding = kBufferPatchVertices) readonly buffer Vertices { uvec2 b_vertices[]; };      // vertex, start
layout(std430, binding = kBufferTriangleOfVertex) readonly buffer Triangles { uint b_triangles[]; };  // [vertex] a triangle that it is a corner of
layout(std430, binding = kBufferNearest) coherent buffer Nearest { uvec2 b_nearest[]; };              // triangle + 1 and effort | complement of m: how far
#include "reflections/tiles.glsl"
uniform int u_count;
uniform int u_round;
uniform int u_reflector;
uniform int u_point_px;  // side of the square that a point covers

const uint kInside = 0u;

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= u_count) return;
  int vertex = int(b_vertices[i].x);
  uvec4 a = texelFetch(t_projected, 2 * vertex), b = texelFetch(t_projected, 2 * vertex + 1);
  if ((b.x & 3u) != kInside || (b.x & 4u) == 0u) return;
  if (u_round == 0) atomicAdd(b_counters[0], 1u);
  ivec2 size = textureSize(t_ray_direction, 0);
  vec2 corner = clamp(uintBitsToFloat(a.xy) - 0.5 * float(u_point_px - 1), vec2(-1e6), vec2(1e6));
  uint far = ~floatBitsToUint(unpackHalf2x16(b.x).y);
  for (int k = 0; k < u_point_px * u_point_px; ++k) {
    ivec2 pixel = ivec2(floor(corner)) + ivec2(k % u_point_px, k / u_point_px);
    if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, size))) continue;
    if (int(texelFetch(t_ray_direction, pixel, 0).w) - 1 != u_reflector) continue;
    int at = pixel.y * size.x + pixel.x;
    if (u_round == 0) atomicMax(b_nearest[at].y, far);
    if (u_round > 0 && b_nearest[at].y != far) continue;
    if (u_round == 1) b_nearest[at].x = 0u;
    if (u_round == 2) atomicMax(b_nearest[at].x, (b_triangles[vertex] + 1u) << kEffortBits | (b.x >> 3u & 127u));
  }
}
