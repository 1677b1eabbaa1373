// Scene triangles whose vertices have been projected: invisible ones are dropped, those with straight edges are offered unchanged, the others
// become the first pieces to be subdivided (bezier/pieces.comp).
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "bezier/corners.glsl"
layout(binding = kUnitProjected) uniform usamplerBuffer t_projected;  // as bezier/vertices.comp writes it
layout(std430, binding = kBufferBezierCounters) buffer Counters { uint b_counters[16]; };  // 0: triangles offered, 1: pieces
layout(std430, binding = kBufferNextPieces) writeonly buffer Next { vec4 b_next[]; };      // 4 a piece: three of (m, x.x) | x.y of each, number
layout(std430, binding = kBufferBezierTriangles) readonly buffer Triangles { uint b_triangles[]; };
uniform int u_count;
uniform int u_piece_capacity;
uniform float u_tolerance_px;
uniform float u_margin_px;

struct Vertex {
  Corner corner;
  vec3 by_x, by_y;  // px/m
};

Vertex fetch_vertex(int vertex) {
  uvec4 a = texelFetch(t_projected, 2 * vertex), b = texelFetch(t_projected, 2 * vertex + 1);
  Vertex u;
  u.corner.world = texelFetch(t_vertices, 4 * vertex).xyz;
  u.corner.v.at = uintBitsToFloat(a.xy);
  u.corner.v.x = uintBitsToFloat(a.zw);
  u.corner.v.status = int(b.x & 3u);
  u.corner.v.in_front = (b.x & 4u) != 0u;
  u.corner.v.steps = int(b.x >> 3u & 127u);
  u.corner.v.along_m = unpackHalf2x16(b.x).y;
  vec2 d = unpackHalf2x16(b.y), e = unpackHalf2x16(b.z), f = unpackHalf2x16(b.w);
  u.by_x = vec3(d, e.x);
  u.by_y = vec3(e.y, f);
  return u;
}

/// Distance in pixels of an edge's curved image from a straight line: a quarter of the distance by which the tangent at one end misses the other
/// end. Exact for a quadratic curve.
float bend_px(Vertex a, Vertex b) {
  vec3 d = b.corner.world - a.corner.world;
  vec2 along = b.corner.v.at - a.corner.v.at;
  vec2 from_a = along - vec2(dot(a.by_x, d), dot(a.by_y, d)), from_b = along - vec2(dot(b.by_x, d), dot(b.by_y, d));
  return 0.25 * sqrt(max(dot(from_a, from_a), dot(from_b, from_b)));
}

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= u_count) return;
  int triangle = int(b_triangles[i]);
  ivec3 v = ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x, texelFetch(t_indices, 3 * triangle + 2).x);
  Vertex p = fetch_vertex(v.x), q = fetch_vertex(v.y), r = fetch_vertex(v.z);
  Corner c[3] = Corner[3](p.corner, q.corner, r.corner);
  float shift = max(max(ghost_shift(p.by_x, p.by_y, p.corner.v.along_m), ghost_shift(q.by_x, q.by_y, q.corner.v.along_m)),
                    ghost_shift(r.by_x, r.by_y, r.corner.v.along_m));
  if (shows_nothing(c, u_margin_px + shift)) return;
  bool in_front = c[0].v.in_front && c[1].v.in_front && c[2].v.in_front && max(max(c[0].v.status, c[1].v.status), c[2].v.status) <= kReflectionOutside;
  float bend = max(max(bend_px(p, q), bend_px(q, r)), bend_px(r, p));
  if (in_front && bend <= u_tolerance_px) {
    atomicAdd(b_counters[0], 1u);
    offer_corners(c, kEndError_px + kBulge * bend + shift, triangle);
    return;
  }
  uint slot = atomicAdd(b_counters[1], 1u);
  if (slot >= uint(u_piece_capacity)) {
    offer_corners(c, kBoxOnly + u_margin_px + shift, triangle);
    return;
  }
  for (int k = 0; k < 3; ++k) b_next[4u * slot + uint(k)] = vec4(c[k].world, c[k].v.x.x);
  b_next[4u * slot + 3u] = vec4(c[0].v.x.y, c[1].v.x.y, c[2].v.x.y, float(triangle + 1));
}
