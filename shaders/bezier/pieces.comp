// Pieces of reflected triangles: edges whose image deviates from a straight line by more than the tolerance are halved. This depends only on
// the two ends of an edge, so neighbours agree and there are no cracks.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "bezier/corners.glsl"
layout(std430, binding = kBufferBezierCounters) buffer Counters { uint b_counters[16]; };  // 1 and 2: pieces, 7: dropped, 8: pieces offered
layout(std430, binding = kBufferPieces) readonly buffer Pieces { vec4 b_pieces[]; };       // 4 a piece: three of (m, x.x) | x.y of each, number
layout(std430, binding = kBufferNextPieces) writeonly buffer Next { vec4 b_next[]; };
uniform int u_count;
uniform int u_next_counter;
uniform int u_piece_capacity;
uniform float u_tolerance_px;
uniform float u_short_px;
uniform float u_margin_px;
uniform int u_last;  // 1: halve no more

const int kCornerSteps = 8;  // from a start that the previous pass has found
const float kUnknown = 1e30;
const int kMiddleSteps = 2;  // enough to measure the deviation of an edge, and as a start for the next pass

/// An invisible edge need not be subdivided.
bool is_hidden(Corner a, Corner b) {
  return (a.v.status == kReflectionBehind && b.v.status == kReflectionBehind) || beyond(a, b);
}

/// Distance in pixels of an edge's middle from the straight line between its ends; kUnknown where an end has no image.
float bend_px(Corner a, Corner b, Projected middle) {
  if (a.v.status == kReflectionLost || b.v.status == kReflectionLost) return kUnknown;
  if (!a.v.in_front || !b.v.in_front || !middle.in_front) return kUnknown;
  vec2 d = b.v.at - a.v.at, m = middle.at - a.v.at;
  // Where an edge meets the surface its image has a kink, anywhere between its ends.
  if ((a.v.status == kReflectionBehind) != (b.v.status == kReflectionBehind) && dot(d, d) > 16.0 * u_tolerance_px * u_tolerance_px) return kUnknown;
  float t = clamp(dot(m, d) / max(dot(d, d), 1e-12), 0.0, 1.0);
  return length(m - t * d);
}

void keep_piece(uint at, vec3 a, vec2 xa, vec3 b, vec2 xb, vec3 c, vec2 xc, float number) {
  b_next[4u * at] = vec4(a, xa.x);
  b_next[4u * at + 1u] = vec4(b, xb.x);
  b_next[4u * at + 2u] = vec4(c, xc.x);
  b_next[4u * at + 3u] = vec4(xa.y, xb.y, xc.y, number);
}

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= u_count) return;
  vec4 rest = b_pieces[4 * i + 3];
  if (rest.w < 0.5) return;  // reserved by a piece whose parts did not all fit
  Corner corner[3];
  for (int k = 0; k < 3; ++k) {
    vec4 p = b_pieces[4 * i + k];
    corner[k].world = p.xyz;
    corner[k].v = project_near(p.xyz, vec2(p.w, rest[k]), kCornerSteps);
  }
  float shift = 0.0;
#if GHOST
  for (int k = 0; k < 3; ++k) {
    mat2x3 d = screen_derivative(corner[k].world - u_patches[u_patch].origin.xyz, corner[k].v.x);
    shift = max(shift, ghost_shift(d[0], d[1], corner[k].v.along_m));
  }
#endif
  if (shows_nothing(corner, u_margin_px + shift)) return;
  int halved = 0;
  float bend = 0.0;
  vec2 middle[3] = vec2[3](vec2(0.0), vec2(0.0), vec2(0.0));  // parameters, of the edge that begins at the corner
  if (u_last == 0) {
    for (int k = 0; k < 3; ++k) {
      Corner a = corner[k], b = corner[(k + 1) % 3];
      if (is_hidden(a, b) || !may_bend(a, b, u_short_px)) continue;
      Projected m = project_near(0.5 * (a.world + b.world), 0.5 * (a.v.x + b.v.x), kMiddleSteps);
      middle[k] = m.x;
      float b_px = bend_px(a, b, m);
      bend = max(bend, b_px);
      if (b_px > u_tolerance_px) halved |= 1 << k;
    }
  }
  uint parts = uint(bitCount(halved)) + 1u, slot = 0u;
  if (halved != 0) slot = atomicAdd(b_counters[u_next_counter], parts);
  if (halved == 0 || slot + parts > uint(u_piece_capacity)) {
    for (uint k = slot; halved != 0 && k < min(slot + parts, uint(u_piece_capacity)); ++k) b_next[4u * k + 3u] = vec4(0.0);
    // A corner without a reflection point has no position on screen: its piece is left out, and counted.
    if (max(max(corner[0].v.status, corner[1].v.status), corner[2].v.status) == kReflectionLost) {
      atomicAdd(b_counters[7], 1u);
    } else {
      atomicAdd(b_counters[8], 1u);
      offer_corners(corner, (u_last == 0 && halved == 0 ? kEndError_px + kBulge * bend : kBoxOnly + u_margin_px) + shift, int(rest.w) - 1);
    }
    return;
  }
  // Corners rotated so that the edge ab is halved, and bc as well if two edges are.
  int first = halved == 2 || halved == 6 ? 1 : (halved == 4 || halved == 5 ? 2 : 0);
  Corner a = corner[first], b = corner[(first + 1) % 3], c = corner[(first + 2) % 3];
  vec2 xab = middle[first], xbc = middle[(first + 1) % 3], xca = middle[(first + 2) % 3];
  vec3 ab = 0.5 * (a.world + b.world), bc = 0.5 * (b.world + c.world), ca = 0.5 * (c.world + a.world);
  if (halved == 7) {
    keep_piece(slot, a.world, a.v.x, ab, xab, ca, xca, rest.w);
    keep_piece(slot + 1u, ab, xab, b.world, b.v.x, bc, xbc, rest.w);
    keep_piece(slot + 2u, ca, xca, bc, xbc, c.world, c.v.x, rest.w);
    keep_piece(slot + 3u, ab, xab, bc, xbc, ca, xca, rest.w);
  } else if (halved == 1 || halved == 2 || halved == 4) {
    keep_piece(slot, a.world, a.v.x, ab, xab, c.world, c.v.x, rest.w);
    keep_piece(slot + 1u, ab, xab, b.world, b.v.x, c.world, c.v.x, rest.w);
  } else {
    keep_piece(slot, ab, xab, b.world, b.v.x, bc, xbc, rest.w);
    keep_piece(slot + 1u, a.world, a.v.x, ab, xab, bc, xbc, rest.w);
    keep_piece(slot + 2u, a.world, a.v.x, bc, xbc, c.world, c.v.x, rest.w);
  }
}
