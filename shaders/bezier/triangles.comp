// Triangles to their reflections: those that show nothing are dropped, edges that a straight line does not show to the tolerance are
// halved. Whether an edge is halved depends on its two ends alone, so neighbours agree and no cracks open.
// SCENE 1: triangles of the scene, their vertices projected before. SCENE 0: pieces from the pass before.
layout(local_size_x = 64) in;
#include "bezier/project.glsl"
layout(binding = 4) uniform usamplerBuffer t_indices;
layout(binding = 5) uniform samplerBuffer t_vertices;
layout(std430, binding = 2) readonly buffer Projections { vec4 b_projected[]; };
layout(std430, binding = 3) buffer Counters { uint b_counters[16]; };  // 0: drawn, 1 and 2: pieces, 7: dropped
layout(std430, binding = 4) writeonly buffer Drawn { vec4 b_drawn[]; };   // 4 a triangle: three clip positions | heights, number
layout(std430, binding = 5) readonly buffer Pieces { vec4 b_pieces[]; };  // 4 a piece: three of (m, x.x) | x.y of each, number
layout(std430, binding = 6) writeonly buffer Next { vec4 b_next[]; };
#if SCENE
layout(std430, binding = 7) readonly buffer Triangles { uint b_triangles[]; };
#endif
uniform int u_count;
uniform int u_next_counter;
uniform int u_drawn_capacity;
uniform int u_piece_capacity;
uniform float u_tolerance_px;
uniform int u_last;  // 1: halve no more

struct Corner {
  vec3 world;
  Projected v;
};

vec2 on_screen(vec4 clip) { return (0.5 * clip.xy / clip.w + 0.5) * vec2(u_frame.size.xy); }

bool beyond(Corner a, Corner b, int axis) {
  return (a.v.x[axis] > 1.0 && b.v.x[axis] > 1.0) || (a.v.x[axis] < -1.0 && b.v.x[axis] < -1.0);
}

/// An edge that shows nothing may be as crooked as it likes.
bool is_hidden(Corner a, Corner b) {
  return (a.v.status == kReflectionBehind && b.v.status == kReflectionBehind) || beyond(a, b, 0) || beyond(a, b, 1);
}

bool needs_halving(Corner a, Corner b, Projected middle) {
  bool behind_a = a.v.status == kReflectionBehind, behind_b = b.v.status == kReflectionBehind;
  if (a.v.status == kReflectionLost || b.v.status == kReflectionLost || behind_a != behind_b) return true;
  if (a.v.clip.w <= 0.0 || b.v.clip.w <= 0.0 || middle.clip.w <= 0.0) return true;
  vec2 p = on_screen(a.v.clip), d = on_screen(b.v.clip) - p, m = on_screen(middle.clip) - p;
  float t = clamp(dot(m, d) / max(dot(d, d), 1e-12), 0.0, 1.0);
  return length(m - t * d) > u_tolerance_px;
}

/// Short edges are straight enough; what looks short and is not has its ends on two sides of something.
bool may_bend(Corner a, Corner b) {
  if (a.v.clip.w <= 0.0 || b.v.clip.w <= 0.0 || a.v.status > kReflectionOutside || b.v.status > kReflectionOutside) return true;
  vec2 d = on_screen(a.v.clip) - on_screen(b.v.clip);
  return dot(d, d) > 36.0 * u_tolerance_px * u_tolerance_px;
}

Projected middle_of(Corner a, Corner b) { return estimate_near(0.5 * (a.world + b.world), 0.5 * (a.v.x + b.v.x)); }

void draw(Corner a, Corner b, Corner c, float number) {
  uint at = atomicAdd(b_counters[0], 1u);
  if (at >= uint(u_drawn_capacity)) return;
  b_drawn[4u * at] = a.v.clip;
  b_drawn[4u * at + 1u] = b.v.clip;
  b_drawn[4u * at + 2u] = c.v.clip;
  b_drawn[4u * at + 3u] = vec4(a.v.height, b.v.height, c.v.height, number);
}

void keep_piece(vec3 a, vec2 xa, vec3 b, vec2 xb, vec3 c, vec2 xc, float number) {
  uint at = atomicAdd(b_counters[u_next_counter], 1u);
  if (at >= uint(u_piece_capacity)) return;
  b_next[4u * at] = vec4(a, xa.x);
  b_next[4u * at + 1u] = vec4(b, xb.x);
  b_next[4u * at + 2u] = vec4(c, xc.x);
  b_next[4u * at + 3u] = vec4(xa.y, xb.y, xc.y, number);
}

Corner fetch_corner(int vertex) {
  vec4 a = b_projected[2 * vertex], b = b_projected[2 * vertex + 1];
  Corner c;
  c.world = texelFetch(t_vertices, 4 * vertex).xyz;
  c.v.clip = a;
  c.v.x = b.xy;
  c.v.height = b.z;
  c.v.status = int(b.w);
  return c;
}

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= u_count) return;
  Corner corner[3];
  float number;
#if SCENE
  int triangle = int(b_triangles[i]);
  number = float(triangle + 1);
  for (int k = 0; k < 3; ++k) corner[k] = fetch_corner(int(texelFetch(t_indices, 3 * triangle + k).x));
#else
  vec4 rest = b_pieces[4 * i + 3];
  number = rest.w;
  for (int k = 0; k < 3; ++k) {
    vec4 p = b_pieces[4 * i + k];
    corner[k].world = p.xyz;
    corner[k].v = project_near(p.xyz, vec2(p.w, rest[k]));
  }
#endif
  bool all_behind = true, some_lost = false, bends = false;
  for (int k = 0; k < 3; ++k) {
    all_behind = all_behind && corner[k].v.status == kReflectionBehind;
    some_lost = some_lost || corner[k].v.status == kReflectionLost;
    bends = bends || may_bend(corner[k], corner[(k + 1) % 3]);
  }
  if (all_behind) return;
  for (int k = 0; k < 2; ++k)
    if (beyond(corner[0], corner[1], k) && beyond(corner[1], corner[2], k) && beyond(corner[0], corner[2], k)) return;
  int halved = 0;
  vec2 middle[3] = vec2[3](vec2(0.0), vec2(0.0), vec2(0.0));  // parameters, of the edge that begins at the corner
  if (u_last == 0 && bends) {
    for (int k = 0; k < 3; ++k) {
      Corner a = corner[k], b = corner[(k + 1) % 3];
      if (is_hidden(a, b) || !may_bend(a, b)) continue;
      Projected m = middle_of(a, b);
      middle[k] = m.x;
      if (needs_halving(a, b, m)) halved |= 1 << k;
    }
  }
  if (halved == 0) {
    // A corner without a reflection point has no place in the picture: the piece around it is left out, and counted.
    if (some_lost)
      atomicAdd(b_counters[7], 1u);
    else
      draw(corner[0], corner[1], corner[2], number);
    return;
  }
  // Turned so that the edge ab is halved, and, of two halved edges, bc as well.
  int turn = halved == 2 || halved == 6 ? 1 : (halved == 4 || halved == 5 ? 2 : 0);
  Corner a = corner[turn], b = corner[(turn + 1) % 3], c = corner[(turn + 2) % 3];
  vec2 xab = middle[turn], xbc = middle[(turn + 1) % 3], xca = middle[(turn + 2) % 3];
  vec3 ab = 0.5 * (a.world + b.world), bc = 0.5 * (b.world + c.world), ca = 0.5 * (c.world + a.world);
  if (halved == 7) {
    keep_piece(a.world, a.v.x, ab, xab, ca, xca, number);
    keep_piece(ab, xab, b.world, b.v.x, bc, xbc, number);
    keep_piece(ca, xca, bc, xbc, c.world, c.v.x, number);
    keep_piece(ab, xab, bc, xbc, ca, xca, number);
  } else if (halved == 1 || halved == 2 || halved == 4) {
    keep_piece(a.world, a.v.x, ab, xab, c.world, c.v.x, number);
    keep_piece(ab, xab, b.world, b.v.x, c.world, c.v.x, number);
  } else {
    keep_piece(ab, xab, b.world, b.v.x, bc, xbc, number);
    keep_piece(a.world, a.v.x, ab, xab, bc, xbc, number);
    keep_piece(a.world, a.v.x, bc, xbc, c.world, c.v.x, number);
  }
}
