// BRDFs of octree cells (render/octree/cell_brdf_buffers.h): their codes, frames and visible areas. Needs octree/tables.glsl.
#include "shared/bindings.glsl"
#include "shared/cell_brdf.glsl"
layout(binding = kUnitCellOfNode) uniform usamplerBuffer t_cell_of_node;  // [node], code + 1, 0: none
layout(binding = kUnitCellCodes) uniform usamplerBuffer t_cell_codes;     // cluster (16 bits) and turn (14 bits), mirrored, shared by flat cells; four weights, scale
layout(binding = kUnitCellPairs) uniform samplerBuffer t_cell_pairs;      // [cluster][pair][5]
layout(binding = kUnitCellSeen) uniform samplerBuffer t_cell_seen;        // [cluster][direction][5]

struct CellCode {
  int cluster;
  float rotation_rad;  // of the frame around the normal
  bool mirrored;
  bool flat_shared;
  vec4 weights;
  float scale;  // of light
};

CellCode cell_code(int code) {
  uvec4 w = texelFetch(t_cell_codes, code);
  return CellCode(int(w.x & 0xffffu), float((w.x >> 16u) & 0x3fffu) * (6.28318531 / 16384.0), (w.x & 0x40000000u) != 0u, (w.x >> 31u) != 0u, vec4(unpackHalf2x16(w.y), unpackHalf2x16(w.z)), uintBitsToFloat(w.w));
}

OctreePlane cell_plane(int node, int level) {
  return octree_unpack_plane(level == u_octree_depth ? octree_word(node) : octree_plane_word(node));
}

struct CellFrame {
  vec3 t, b, n;
};
CellFrame cell_frame(CellCode code, vec3 normal) {
  vec3 n = normalize(normal), t = cell_tangent(n), b = cross(n, t);
  float c = cos(code.rotation_rad), s = sin(code.rotation_rad);
  return CellFrame(c * t + s * b, (code.mirrored ? -1.0 : 1.0) * (c * b - s * t), n);
}
vec3 cell_from_world(CellFrame f, vec3 d) { return vec3(dot(f.t, d), dot(f.b, d), dot(f.n, d)); }

float cell_seen_at(CellCode c, int direction) {
  int first = (c.cluster * kCellDirections + direction) * 5;
  float sum = texelFetch(t_cell_seen, first).x;
  for (int k = 0; k < 4; ++k) sum += c.weights[k] * texelFetch(t_cell_seen, first + 1 + k).x;
  return sum;
}

/// Visible area along a direction of the cell's frame, relative to the area of a face.
float cell_seen(CellCode c, vec3 d) {
  CellLookup at = cell_lookup(d);
  float low = mix(cell_seen_at(c, at.first), cell_seen_at(c, at.first + 1), at.x);
  float high = mix(cell_seen_at(c, at.first + kCellSide), cell_seen_at(c, at.first + kCellSide + 1), at.x);
  return max(mix(low, high, at.y), 0.0);
}

vec3 cell_pair_value(CellCode c, int a, int b) {
  int first = (c.cluster * kCellPairs + cell_pair(a, b)) * 5;
  vec3 sum = texelFetch(t_cell_pairs, first).rgb;
  for (int k = 0; k < 4; ++k) sum += c.weights[k] * texelFetch(t_cell_pairs, first + 1 + k).rgb;
  return sum * c.scale;
}
