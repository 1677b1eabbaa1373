// From scene triangles to boxes on screen that contain their whole reflection in one triangle of a mirror.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/cubic.glsl"
#include "shared/triangle_mirror.glsl"
#include "triangle/facets.glsl"
#define LARGE 1
#define OWN_TILES 64
#include "reflections/nearest.glsl"
layout(binding = kUnitKeptPairs) uniform usamplerBuffer t_kept;  // mirror triangle, triangle
layout(std430, binding = kBufferPairCounters) buffer Counters { uint b_kept_count, b_boxes_made, b_roots, b_footprints; };
uniform int u_count;

/// Barycentrics outside the triangle beyond which a projected vertex is ignored: a triangle's rays extrapolate badly far outside it.
const float kMostOutside = 1.5;

TriangleMirror fetch_mirror(int at) {
  TriangleMirror m;
  m.t1 = texelFetch(t_facets, at).xyz;
  m.e1 = texelFetch(t_facets, at + 1).xyz;
  m.e2 = texelFetch(t_facets, at + 2).xyz;
  m.d1 = texelFetch(t_facets, at + 3).xyz;
  m.f1 = texelFetch(t_facets, at + 4).xyz;
  m.f2 = texelFetch(t_facets, at + 5).xyz;
  m.n0 = texelFetch(t_facets, at + 6).xyz;
  m.n1 = texelFetch(t_facets, at + 7).xyz;
  m.n2 = texelFetch(t_facets, at + 8).xyz;
  m.n0_rest = texelFetch(t_facets, at + 9).xyz;
  m.n1_rest = texelFetch(t_facets, at + 10).xyz;
  m.n2_rest = texelFetch(t_facets, at + 11).xyz;
  m.g = texelFetch(t_facets, at + 12).xyz;
  m.g_rest = texelFetch(t_facets, at + 13).xyz;
  return m;
}

struct Projected {
  vec4 at;        // on screen, -1 to 1; barycentrics
  float outside;  // in barycentrics; below 0: has no position
  float shift;    // of its second image, in barycentrics
  int root;       // which, from 1
  int roots;
};

/// A vertex has a position if it has exactly one image near the triangle, before the rays cross: there the map of the rays is one to one.
Projected project(TriangleMirror m, vec3 p) {
  CubicRoots roots = positive_roots(mirror_cubic(m, p));
  Projected v = Projected(vec4(0.0), -1.0, 0.0, 0, roots.count);
  int near = 0;
  MirrorPoint best;
  best.valid = false;
  for (int i = 0; i < roots.count; ++i) {
    MirrorPoint h = mirror_point_at(m, p, roots.k[i]);
    if (h.outside >= kMostOutside) continue;
    ++near;
    best = h;
    v.root = i + 1;
  }
  if (near != 1 || !best.valid) return v;
  vec4 clip = u_frame.clip_from_world * vec4(m.t1 + best.alpha * m.e1 + best.beta * m.e2, 1.0);
  if (clip.w <= 1e-6) return v;
  v.at = vec4(clip.xy / clip.w, best.alpha, best.beta);
  v.outside = best.outside;
  // The triangle of the corners' rays at that distance, and the second ray's largest offset relative to it.
  vec3 e1 = m.e1 + best.k * m.f1, e2 = m.e2 + best.k * m.f2;
  float longest = max(max(length(e1), length(e2)), length(e1 - e2));
  v.shift = kGhostSlack * ghost_offset(best.k) * longest / max(length(cross(e1, e2)), 1e-12);
  return v;
}

/// As in render/reflections/clusters.h.
bool may_meet(vec4 base, vec4 axis, float cosine, vec3 center, float radius) {
  if (cosine <= 0.0) return true;
  vec3 to = center - base.xyz;
  float along = dot(to, axis.xyz), radii = radius + base.w;
  if (along < -radii) return false;
  float limit = radii + along * axis.w;
  return limit >= 0.0 && (dot(to, to) - along * along) * cosine * cosine <= limit * limit;
}

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= u_count) return;
  uvec2 kept = texelFetch(t_kept, i).xy;
  int at = kFacetTexels * int(kept.x), triangle = int(kept.y);
  TriangleMirror mirror = fetch_mirror(at);
  vec4 base = texelFetch(t_facets, at + 14), axis = texelFetch(t_facets, at + 15), box = texelFetch(t_facets, at + 16);
  vec4 rest = texelFetch(t_facets, at + 17);  // margins, px and barycentrics; reflector; cosine
  float longest_px = texelFetch(t_facets, at + 21).w;
  SceneTriangle scene = fetch_triangle(triangle);
  vec3 corner[3] = vec3[3](scene.a, scene.a + scene.e1, scene.a + scene.e2);
  vec3 center = (corner[0] + corner[1] + corner[2]) / 3.0, most = vec3(-1e30);
  float outside = 0.0, shift = 0.0, radius = 0.0;
  vec2 low = vec2(1e30), high = vec2(-1e30);
  bool projected = true;
  int roots = 0, root = 0;
  for (int k = 0; k < 3; ++k) {
    Projected v = project(mirror, corner[k]);
    projected = projected && v.outside >= 0.0;
    outside = max(outside, v.outside);
    shift = max(shift, v.shift);
    low = min(low, v.at.xy);
    high = max(high, v.at.xy);
    most = max(most, vec3(v.at.zw, 1.0 - v.at.z - v.at.w));
    radius = max(radius, length(corner[k] - center));
    roots += v.roots;
    if (k == 0) root = v.root;
  }
  atomicAdd(b_roots, uint(roots));
  vec2 pixel = 2.0 / vec2(u_frame.size.xy);
  if (projected) {
    // Second-order errors grow with the square of the distance from the middle.
    float growth = (1.0 + 2.0 * outside) * (1.0 + 2.0 * outside), margin_px = rest.x * growth + 2.0 * longest_px * shift;
    if (min(min(most.x, most.y), most.z) < -rest.y * growth - shift) return;
    box.xy = max(box.xy, low - margin_px * pixel);
    box.zw = min(box.zw, high + margin_px * pixel);
    if (box.x >= box.z || box.y >= box.w) return;
  } else {
    if (!may_meet(base, axis, rest.w, center, radius)) return;
    atomicAdd(b_footprints, 1u);
  }
  atomicAdd(b_boxes_made, 1u);
  vec2 size = vec2(u_frame.size.xy);
  low = (0.5 + 0.5 * vec2(box.x, -box.w)) * size;
  high = (0.5 + 0.5 * vec2(box.z, -box.y)) * size;
  float nearest_m = length(center - base.xyz) - radius - base.w;
  offer_triangle(low, high, low, kBoxOnly, nearest_m - ghost_offset(max(nearest_m, 0.0)), offered(triangle, projected ? root : 0), int(rest.z));
}
