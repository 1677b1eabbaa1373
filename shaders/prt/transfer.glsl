// Precomputed radiance transfer: the transfer of vertices towards the eye under the light at hand.
// Needs frame and constants included before.
#include "shared/bindings.glsl"
#ifndef TERMS
#define TERMS 3  // the mean and the components of materials, at most
#endif
layout(binding = kUnitTransferVertices) uniform samplerBuffer t_transfer_vertices;  // [vertex]: position, error of its transfer | n | t | b
layout(binding = kUnitTransferPlaces) uniform usamplerBuffer t_transfer_places;     // [vertex]: first texel of its records, group
// [vertex][matrix]: first row of its cluster's sums, then weights as half floats
layout(binding = kUnitTransferRecords) uniform usamplerBuffer t_transfer_records;
layout(binding = kUnitTransferSums) uniform samplerBuffer t_transfer_sums;          // [row] light times q
// [group]: components, first texel in the views' table, triangles, borders | first factor, width, height, components of the material
layout(binding = kUnitTransferGroups) uniform usamplerBuffer t_transfer_groups;
// Of a group: 16 x 16 texels of four starts each, then its triangles (inverse rows with a corner each, neighbours), then its border (two ends)
layout(binding = kUnitTransferViews) uniform samplerBuffer t_transfer_views;
uniform int u_transfer_components;  // of the transfer
#ifdef JOINT
// [vertex][function]: as the records above, of a function's first view; rows of the next views follow
uniform int u_transfer_functions;  // of the material with most
uniform int u_transfer_view_rows;
#endif
const int kStartSide = 32;

/// Three sampled views and their shares.
struct NearViews {
  ivec3 index;
  vec3 share;
};

/// The nearest point of the border of the sampled views, by angle. The same as DirectionMesh::nearest_on_border.
NearViews border_views(int first, int count, vec3 d) {
  NearViews best = NearViews(ivec3(0), vec3(1.0, 0.0, 0.0));
  float nearest = -2.0;
  for (int i = 0; i < count; ++i) {
    vec4 a = texelFetch(t_transfer_views, first + 2 * i), b = texelFetch(t_transfer_views, first + 2 * i + 1);
    vec3 normal = normalize(cross(a.xyz, b.xyz));
    vec3 on = d - normal * dot(normal, d);
    float s = dot(cross(on, b.xyz), normal), t = dot(cross(a.xyz, on), normal);
    float from_a = s > 0.0 && t > 0.0 ? t / (s + t) : (dot(d, a.xyz) >= dot(d, b.xyz) ? 0.0 : 1.0);
    float cosine = dot(d, normalize(mix(a.xyz, b.xyz, from_a)));
    if (cosine > nearest) {
      nearest = cosine;
      best = NearViews(ivec3(int(a.w), int(b.w), int(a.w)), vec3(1.0 - from_a, from_a, 0.0));
    }
  }
  return best;
}

/// The same as DirectionMesh::find. `d`: unit, local.
NearViews near_views(uvec4 group, vec3 d) {
  int first = int(group.y), triangles = int(group.z), border = int(group.w);
  int of_triangles = first + kStartSide * kStartSide / 4;
  ivec2 cell = clamp(ivec2((d.xy * 0.5 + 0.5) * float(kStartSide)), ivec2(0), ivec2(kStartSide - 1));
  int start = cell.y * kStartSide + cell.x;
  int t = triangles > 0 ? int(texelFetch(t_transfer_views, first + start / 4)[start & 3]) : -1;
  for (int step = 0; step <= triangles && t >= 0; ++step) {
    vec4 a = texelFetch(t_transfer_views, of_triangles + 4 * t), b = texelFetch(t_transfer_views, of_triangles + 4 * t + 1),
         c = texelFetch(t_transfer_views, of_triangles + 4 * t + 2);
    vec3 w = vec3(dot(a.xyz, d), dot(b.xyz, d), dot(c.xyz, d));
    int k = w.x < w.y ? (w.x < w.z ? 0 : 2) : (w.y < w.z ? 1 : 2);
    if (w[k] >= -1e-6) {
      w = max(w, vec3(0.0));
      return NearViews(ivec3(int(a.w), int(b.w), int(c.w)), w / (w.x + w.y + w.z));
    }
    t = int(texelFetch(t_transfer_views, of_triangles + 4 * t + 3)[k]);
  }
  return border_views(of_triangles + 4 * triangles, border, d);
}

int record_texels() { return (1 + (u_transfer_components + 1) / 2 + 3) / 4; }

/// p and s summed: the light of one matrix at a vertex. `offset`: of its rows from those that the record names.
vec3 record_light(int texel, int offset) {
  uvec4 words = texelFetch(t_transfer_records, texel);
  int row = int(words.x) + offset;
  vec3 sum = texelFetch(t_transfer_sums, row).rgb;
  for (int c = 0; c < u_transfer_components; c += 2) {
    int word = 1 + c / 2;
    if (word > 3 && (word & 3) == 0) words = texelFetch(t_transfer_records, texel + word / 4);
    vec2 weight = unpackHalf2x16(words[word & 3]);
    sum += weight.x * texelFetch(t_transfer_sums, row + 1 + c).rgb;
    if (c + 1 < u_transfer_components) sum += weight.y * texelFetch(t_transfer_sums, row + 2 + c).rgb;
  }
  return sum;
}

/// Sampled views near the direction to an eye, in the vertex's frame.
NearViews vertex_views(int vertex, uvec4 group, vec3 to_eye) {
  vec3 n = texelFetch(t_transfer_vertices, 4 * vertex + 1).xyz;
  vec3 d = vec3(dot(texelFetch(t_transfer_vertices, 4 * vertex + 2).xyz, to_eye), dot(texelFetch(t_transfer_vertices, 4 * vertex + 3).xyz, to_eye),
                max(dot(n, to_eye), 1e-3));
  return near_views(group, normalize(d));
}

#ifdef JOINT
/// The light of one function of the material at a vertex, over its near views. `first`: of the vertex's records.
vec3 function_light(int first, int function, NearViews views) {
  vec3 sum = vec3(0.0);
  for (int v = 0; v < 3; ++v)
    if (views.share[v] > 0.0) sum += views.share[v] * record_light(first + function * record_texels(), views.index[v] * u_transfer_view_rows);
  return sum;
}
#else
/// A vertex's transfer towards an eye.
struct VertexTransfer {
  NearViews views;
  vec3 mean;               // of all views
  vec3 light[3 * TERMS];   // [view][component], the first of each is unused
};

VertexTransfer vertex_transfer(int vertex, vec3 to_eye) {
  uvec2 place = texelFetch(t_transfer_places, vertex).xy;
  uvec4 group = texelFetch(t_transfer_groups, 2 * int(place.y));
  int texels = record_texels(), components = int(group.x);
  VertexTransfer r;
  r.views = vertex_views(vertex, group, to_eye);
  r.mean = record_light(int(place.x), 0);
  for (int v = 0; v < 3; ++v)
    for (int c = 0; c + 1 < TERMS; ++c) {
      vec3 light = vec3(0.0);
      if (c < components && r.views.share[v] > 0.0) light = record_light(int(place.x) + texels * (1 + r.views.index[v] * components + c), 0);
      r.light[v * TERMS + c + 1] = light;
    }
  return r;
}
#endif
