// Scene triangles whose vertices have been projected: those that show nothing are dropped, small ones are drawn as they are, the others
// become the first pieces of what is halved (bezier/pieces.comp).
layout(local_size_x = 64) in;
#include "bezier/project.glsl"
layout(binding = 4) uniform usamplerBuffer t_indices;
layout(binding = 5) uniform samplerBuffer t_vertices;
layout(std430, binding = 2) readonly buffer Projections { vec4 b_projected[]; };
layout(std430, binding = 3) buffer Counters { uint b_counters[16]; };  // 0: small, 1: pieces
layout(std430, binding = 4) writeonly buffer Drawn { vec4 b_drawn[]; };  // 4 a triangle: three clip positions | heights, number
layout(std430, binding = 6) writeonly buffer Next { vec4 b_next[]; };    // 4 a piece: three of (m, x.x) | x.y of each, number
layout(std430, binding = 7) readonly buffer Triangles { uint b_triangles[]; };
uniform int u_count;
uniform int u_drawn_capacity;
uniform int u_piece_capacity;
uniform float u_tolerance_px;
uniform float u_margin_px;

Corner fetch_corner(int vertex) {
  vec4 b = b_projected[2 * vertex + 1];
  Corner c;
  c.v.clip = b_projected[2 * vertex];
  c.v.x = b.xy;
  c.v.height = b.z;
  c.v.status = int(b.w);
  return c;
}

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= u_count) return;
  int triangle = int(b_triangles[i]);
  ivec3 v = ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x, texelFetch(t_indices, 3 * triangle + 2).x);
  Corner c[3] = Corner[3](fetch_corner(v.x), fetch_corner(v.y), fetch_corner(v.z));
  if (shows_nothing(c, u_margin_px)) return;
  bool bends = may_bend(c[0], c[1], u_tolerance_px) || may_bend(c[1], c[2], u_tolerance_px) || may_bend(c[2], c[0], u_tolerance_px);
  uint slot = atomicAdd(b_counters[bends ? 1 : 0], 1u);
  if (bends) {
    if (slot >= uint(u_piece_capacity)) return;
    for (int k = 0; k < 3; ++k) b_next[4u * slot + uint(k)] = vec4(texelFetch(t_vertices, 4 * v[k]).xyz, c[k].v.x.x);
    b_next[4u * slot + 3u] = vec4(c[0].v.x.y, c[1].v.x.y, c[2].v.x.y, float(triangle + 1));
  } else {
    if (slot >= uint(u_drawn_capacity)) return;
    for (int k = 0; k < 3; ++k) b_drawn[4u * slot + uint(k)] = c[k].v.clip;
    b_drawn[4u * slot + 3u] = vec4(c[0].v.height, c[1].v.height, c[2].v.height, float(triangle + 1));
  }
}
