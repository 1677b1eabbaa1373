// Scene triangles to boxes on screen that hold all of their reflection in one triangle of a mirror. One group a pair of mirror triangle and
// cluster: of the triangles that no side of the mirrored frustum cuts off the vertices are projected, then the triangles placed.
layout(local_size_x = 64) in;
#include "shared/frame.glsl"
#include "shared/cubic.glsl"
#include "shared/triangle_mirror.glsl"
#include "reflections/nearest.glsl"
layout(binding = 54) uniform samplerBuffer t_facets;  // 22 texels a mirror triangle: render/triangle/reflections.cpp writes them
struct ClusterRecord {
  uint first_vertex, vertex_count, first_triangle, triangle_count;
};
layout(std430, binding = 2) readonly buffer Pairs { uvec2 b_pairs[]; };
layout(std430, binding = 3) readonly buffer Clusters { ClusterRecord b_clusters[]; };
layout(std430, binding = 4) readonly buffer Vertices { uint b_vertices[]; };
layout(std430, binding = 5) readonly buffer Triangles { uvec2 b_triangles[]; };  // corners, 8 bits each; number
layout(std430, binding = 6) buffer Counters { uint b_boxes_made, b_roots, b_projected, b_footprints; };
uniform int u_count;

/// Barycentrics beyond which a vertex is not trusted: the rays of a triangle say little about what is far beside it.
const float kReach = 1.5;

shared vec4 s_vertex[64];  // place on screen, barycentrics
shared float s_outside[64];  // below 0: no place
shared uint s_root[64];      // which, from 1
shared uint s_beyond[64];    // bit k: outside the mirrored frustum's side k
shared uint s_needed[64];
shared uint s_roots;

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

/// A vertex has a place when it is seen once near the triangle, before the rays meet: there the rays' map is one to one.
void project(TriangleMirror m, vec3 p, uint lane) {
  CubicRoots roots = positive_roots(mirror_cubic(m, p));
  int near = 0;
  MirrorPoint best;
  best.valid = false;
  for (int i = 0; i < roots.count; ++i) {
    MirrorPoint h = mirror_point_at(m, p, roots.k[i]);
    if (h.outside < kReach) {
      ++near;
      best = h;
      s_root[lane] = uint(i + 1);
    }
  }
  s_outside[lane] = -1.0;
  atomicAdd(s_roots, uint(roots.count));
  if (near != 1 || !best.valid) return;
  vec4 clip = u_frame.clip_from_world * vec4(m.t1 + best.alpha * m.e1 + best.beta * m.e2, 1.0);
  if (clip.w <= 1e-6) return;
  s_vertex[lane] = vec4(clip.xy / clip.w, best.alpha, best.beta);
  s_outside[lane] = best.outside;
}

uvec3 corners_of(uint triangle) {
  uint corners = b_triangles[triangle].x;
  return uvec3(corners, corners >> 8u, corners >> 16u) & 255u;
}

/// As in render/reflections/clusters.h.
bool may_meet(vec4 base, vec4 axis, float cosine, vec3 center, float radius) {
  if (cosine <= 0.0) return true;
  vec3 to = center - base.xyz;
  float along = dot(to, axis.xyz), reach = radius + base.w;
  if (along < -reach) return false;
  float limit = reach + along * axis.w;
  return limit >= 0.0 && (dot(to, to) - along * along) * cosine * cosine <= limit * limit;
}

void main() {
  uint pair = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
  bool used = pair < uint(u_count);
  uvec2 of_pair = b_pairs[used ? pair : 0u];
  int at = 22 * int(of_pair.x);
  ClusterRecord cluster = b_clusters[of_pair.y];
  uint lane = gl_LocalInvocationID.x;
  if (lane == 0u) s_roots = 0u;
  s_needed[lane] = 0u;
  vec4 base = texelFetch(t_facets, at + 14);
  vec3 p = vec3(0.0);
  if (lane < cluster.vertex_count) {
    p = texelFetch(t_vertices, 4 * int(b_vertices[cluster.first_vertex + lane])).xyz;
    vec3 widening = texelFetch(t_facets, at + 21).xyz * length(p - base.xyz);
    uint beyond = 0u;
    for (int k = 0; k < 3; ++k) beyond |= dot(texelFetch(t_facets, at + 18 + k), vec4(p, 1.0)) > widening[k] ? 1u << uint(k) : 0u;
    s_beyond[lane] = beyond;
  }
  barrier();
  for (uint t = lane; used && t < cluster.triangle_count; t += 64u) {
    uvec3 v = corners_of(cluster.first_triangle + t);
    if ((s_beyond[v.x] & s_beyond[v.y] & s_beyond[v.z]) != 0u) continue;
    s_needed[v.x] = s_needed[v.y] = s_needed[v.z] = 1u;
  }
  barrier();
  if (s_needed[lane] == 1u) project(fetch_mirror(at), p, lane);
  barrier();
  if (!used) return;
  if (lane == 0u) {
    atomicAdd(b_roots, s_roots);
  }
  if (s_needed[lane] == 1u) atomicAdd(b_projected, 1u);
  vec4 axis = texelFetch(t_facets, at + 15), facet_box = texelFetch(t_facets, at + 16);
  vec4 rest = texelFetch(t_facets, at + 17);
  vec2 pixel = 2.0 / vec2(u_frame.size.xy);
  for (uint t = lane; t < cluster.triangle_count; t += 64u) {
    uvec3 v = corners_of(cluster.first_triangle + t);
    if ((s_beyond[v.x] & s_beyond[v.y] & s_beyond[v.z]) != 0u) continue;
    float outside = max(max(s_outside[v.x], s_outside[v.y]), s_outside[v.z]);
    bool placed = min(min(s_outside[v.x], s_outside[v.y]), s_outside[v.z]) >= 0.0;
    vec4 box = facet_box;
    vec3 o = texelFetch(t_vertices, 4 * int(b_vertices[cluster.first_vertex + v.x])).xyz;
    vec3 q = texelFetch(t_vertices, 4 * int(b_vertices[cluster.first_vertex + v.y])).xyz;
    vec3 r = texelFetch(t_vertices, 4 * int(b_vertices[cluster.first_vertex + v.z])).xyz;
    vec3 center = (o + q + r) / 3.0;
    float radius = max(max(length(o - center), length(q - center)), length(r - center));
    if (placed) {
      // Errors of second order grow with the square of the distance from the middle.
      float growth = (1.0 + 2.0 * outside) * (1.0 + 2.0 * outside), margin = rest.y * growth;
      vec4 a = s_vertex[v.x], b = s_vertex[v.y], c = s_vertex[v.z];
      vec3 most = max(max(vec3(a.zw, 1.0 - a.z - a.w), vec3(b.zw, 1.0 - b.z - b.w)), vec3(c.zw, 1.0 - c.z - c.w));
      if (min(min(most.x, most.y), most.z) < -margin) continue;
      box.xy = max(box.xy, min(min(a.xy, b.xy), c.xy) - rest.x * growth * pixel);
      box.zw = min(box.zw, max(max(a.xy, b.xy), c.xy) + rest.x * growth * pixel);
      if (box.x >= box.z || box.y >= box.w) continue;
    } else {
      if (!may_meet(base, axis, rest.w, center, radius)) continue;
      atomicAdd(b_footprints, 1u);
    }
    atomicAdd(b_boxes_made, 1u);
    vec2 size = vec2(u_frame.size.xy), low = (0.5 + 0.5 * vec2(box.x, -box.w)) * size, high = (0.5 + 0.5 * vec2(box.z, -box.y)) * size;
    offer_triangle(low, high, low, kBoxOnly, length(center - base.xyz) - radius - base.w, offered(int(b_triangles[cluster.first_triangle + t].y), placed ? int(s_root[v.x]) : 0), int(rest.z));
  }
}
