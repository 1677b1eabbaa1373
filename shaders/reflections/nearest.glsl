// Of the triangles that are offered for a pixel, the nearest that its mirrored ray meets. A technique says where on screen a triangle may be
// seen; what it claims too much is taken back here, so that no false triangle is shown and no seam is jagged.
#include "reflections/ray_triangle.glsl"
layout(std430, binding = 9) coherent buffer Nearest { uint b_nearest[]; };  // [pixel] triangle + 1 and, in the low bits, effort, 0: none | 1/m: how near
layout(binding = 46) uniform usamplerBuffer t_nearest;  // the same: may lag behind, which costs time and nothing else
layout(std430, binding = 10) coherent buffer Boxes {
  uint b_box_count, b_box_capacity, b_box_unused[2];
  uvec4 b_boxes[];  // 3 each: two corners on screen, px | the third, margin, px, what is offered | reflector, nearest, m
};
const uint kEffortBits = 7u;
/// Pixels that one invocation looks at; larger boxes go to a list, of which every entry has a group of its own.
const int kOwnPixels = 64;
/// What the ends of edges are known to, px.
const float kPlace_px = 0.05;
/// A margin that says that only the box around the corners is known.
const float kBoxOnly = 1e6;

uint offered(int triangle, int effort) { return uint(triangle + 1) << kEffortBits | uint(clamp(effort, 0, 127)); }

void offer(ivec2 pixel, SceneTriangle triangle, float nearest_m, uint own, int reflector) {
  int at = 2 * (pixel.y * textureSize(t_ray_direction, 0).x + pixel.x);
  // The second word is that of a triangle which is or was the nearest: what is farther need not be held against the first.
  float hint = uintBitsToFloat(texelFetch(t_nearest, at + 1).x);
  if (nearest_m * hint > 1.0) return;
  vec4 direction = texelFetch(t_ray_direction, pixel, 0);
  if (int(direction.w) != reflector + 1) return;
  vec3 origin = texelFetch(t_ray_origin, pixel, 0).xyz;
  float along_m = distance_to(origin, direction.xyz, triangle);
  if (along_m < 0.0 || along_m * hint > 1.0) return;
  uint held = b_nearest[at];
  // Every exchange that fails has made the entry nearer.
  for (;;) {
    if (held >> kEffortBits == own >> kEffortBits) return;
    float other_m = held == 0u ? 1e30 : distance_to(origin, direction.xyz, fetch_triangle(int(held >> kEffortBits) - 1));
    if (other_m < along_m || (other_m == along_m && held < own)) return;
    uint before = atomicCompSwap(b_nearest[at], held, own);
    if (before == held) break;
    held = before;
  }
  b_nearest[at + 1] = floatBitsToUint(1.0 / along_m);
}

/// Where a triangle may be seen: as far from its three corners on screen as the margin says.
struct Box {
  ivec2 low, high;  // pixels, both within
  vec3 x, y, rest;  // of the three edges: x px.x + y px.y + rest is negative beyond the margin
};

Box make_box(vec2 p, vec2 q, vec2 r, float margin_px) {
  Box box;
  bool box_only = margin_px >= kBoxOnly;
  float around = box_only ? margin_px - kBoxOnly : margin_px;
  vec2 size = vec2(textureSize(t_ray_direction, 0));
  box.low = ivec2(ceil(clamp(min(min(p, q), r) - around - 0.5, vec2(0.0), size)));
  box.high = ivec2(floor(clamp(max(max(p, q), r) + around - 0.5, vec2(-1.0), size - 1.0)));
  vec2 e = q - p, f = r - q, g = p - r;
  float turn = e.x * g.y - e.y * g.x > 0.0 ? -1.0 : 1.0;
  box.x = -turn * vec3(e.y, f.y, g.y);
  box.y = turn * vec3(e.x, f.x, g.x);
  box.rest = turn * vec3(e.y * p.x - e.x * p.y, f.y * q.x - f.x * q.y, g.y * r.x - g.x * r.y) + around * vec3(length(e), length(f), length(g));
  if (box_only) {
    box.x = box.y = vec3(0.0);
    box.rest = vec3(1.0);
  }
  return box;
}

void offer_box(Box box, float nearest_m, uint own, int reflector, ivec2 first, ivec2 stride) {
  SceneTriangle triangle = fetch_triangle(int(own >> kEffortBits) - 1);
  for (int y = box.low.y + first.y; y <= box.high.y; y += stride.y) {
    vec3 row = box.rest + box.y * (float(y) + 0.5);
    for (int x = box.low.x + first.x; x <= box.high.x; x += stride.x) {
      vec3 inside = row + box.x * (float(x) + 0.5);
      if (min(min(inside.x, inside.y), inside.z) >= 0.0) offer(ivec2(x, y), triangle, nearest_m, own, reflector);
    }
  }
}

/// What is small at once; what is large goes to the list. `nearest_m`: no point of it is nearer along a mirrored ray.
void offer_triangle(vec2 p, vec2 q, vec2 r, float margin_px, float nearest_m, uint own, int reflector) {
  Box box = make_box(p, q, r, margin_px);
  ivec2 extent = box.high - box.low + 1;
  if (extent.x <= 0 || extent.y <= 0) return;
  if (extent.x * extent.y > kOwnPixels) {
    uint slot = atomicAdd(b_box_count, 1u);
    if (slot < b_box_capacity) {
      b_boxes[3u * slot] = floatBitsToUint(vec4(p, q));
      b_boxes[3u * slot + 1u] = uvec4(floatBitsToUint(vec3(r, margin_px)), own);
      b_boxes[3u * slot + 2u] = uvec4(uint(reflector), floatBitsToUint(nearest_m), 0u, 0u);
      return;
    }
  }
  offer_box(box, nearest_m, own, reflector, ivec2(0), ivec2(1));
}
