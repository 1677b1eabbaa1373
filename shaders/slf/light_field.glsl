// A surface light field at a grid point: where in the atlas it is, and the radiance that leaves there towards the eye.
// Needs frame, constants, octahedral, rgb9e5, gbuffer and parabolic included before.
#include "shared/bindings.glsl"
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
layout(binding = kUnitLightFieldSlots) uniform usamplerBuffer t_slots;  // [2 triangle + back]: side of the atlas + 1, 0: none
// Two texels of constants, then three a side: UVs of two corners | of the third, chart | axis of the chart
layout(binding = kUnitLightFieldSides) uniform samplerBuffer t_sides;
layout(binding = kUnitLightFieldClusters) uniform usampler2D t_clusters;  // [y][x] cluster, 8 bits; octahedral normal, 12 each
layout(binding = kUnitLightFieldWeights) uniform sampler2DArray t_weights;  // [component / 4][y][x]
layout(binding = kUnitLightFieldLumispheres) uniform sampler2D t_lumispheres;  // tiles: [mean, components][cluster]
layout(binding = kUnitLightFieldCells) uniform usampler2D t_cells;        // [y][x] texel, where nothing is compressed; of interactions light and material cluster, turn, 8 bits each, mirrored
layout(binding = kUnitLightFieldRadiance) uniform usamplerBuffer t_field;  // [texel][y][x of the lumisphere], half floats
layout(binding = kUnitLightFieldErrors) uniform sampler2D t_errors;       // [y][x]

struct FieldConstants {
  float scale;     // cd/m2 of a stored unit
  int directions;  // side of a lumisphere
  int components;
  bool compressed;
  int side;        // of the atlas
  int light_terms, material_terms, material_clusters;  // of the table of interactions; 0: there is none
};
FieldConstants field_constants() {
  vec4 a = texelFetch(t_sides, 0), b = texelFetch(t_sides, 1);
  return FieldConstants(a.x, int(a.y), int(a.z), a.w > 0.5, int(b.x), int(b.y), int(b.z), int(b.w));
}

/// Where a grid point is in the atlas.
struct FieldPoint {
  bool known;     // the atlas has this side
  vec2 at;        // texels
  int chart;
  vec3 position;  // m, world
  vec3 axis;      // of the chart's frames
  vec3 mirrored;  // unit, world: the direction to the eye, mirrored at the normal
};

FieldPoint load_field_point(ivec2 pixel) {
  FieldPoint r;
  int triangle = max(int(texelFetch(t_triangle, pixel, 0).x), 1) - 1;
  ivec3 v = ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x, texelFetch(t_indices, 3 * triangle + 2).x);
  vec3 ray = view_ray(pixel), to_eye = -normalize(ray);
  r.position = view_origin(pixel) + ray * texelFetch(t_depth, pixel, 0).x;
  vec3 p0 = texelFetch(t_vertices, 4 * v.x).xyz;
  vec3 e1 = texelFetch(t_vertices, 4 * v.y).xyz - p0, e2 = texelFetch(t_vertices, 4 * v.z).xyz - p0, d = r.position - p0;
  int back = dot(cross(e1, e2), to_eye) < 0.0 ? 1 : 0;
  // In units of the longer edge: in metres, fourth powers of small edges would underflow.
  float unit = inversesqrt(max(max(dot(e1, e1), dot(e2, e2)), 1e-36));
  e1 *= unit, e2 *= unit, d *= unit;
  float a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2), f = dot(d, e1), g = dot(d, e2);
  vec2 w = clamp(vec2(c * f - b * g, a * g - b * f) / max(a * c - b * b, 1e-30), 0.0, 1.0);
  w /= max(1.0, w.x + w.y);
  int slot = int(texelFetch(t_slots, 2 * triangle + back).x);
  r.known = slot > 0;
  int side = 2 + 3 * max(slot - 1, 0);
  vec4 s0 = texelFetch(t_sides, side), s1 = texelFetch(t_sides, side + 1);
  r.at = s0.xy * (1.0 - w.x - w.y) + s0.zw * w.x + s1.xy * w.y;
  r.chart = int(s1.z);
  vec3 n = unpack_normal(texelFetch(t_surface, pixel, 0).x);
  r.axis = texelFetch(t_sides, side + 2).xyz;
  r.mirrored = 2.0 * max(dot(n, to_eye), 1e-3) * n - to_eye;
  return r;
}

/// Direction in the frame of a texel (its word of t_clusters) in which it mirrors what the point mirrors. Texels whose normals differ then show one
/// highlight at one place; with the direction to the eye itself it would lie between theirs, blurred by their angle.
vec3 direction_at(FieldPoint p, uint cell) {
  vec3 n = direction_from_octahedral(vec2(float((cell >> 8u) & 4095u), float(cell >> 20u)) / 4095.0);
  CarriedFrame frame = carried_frame(p.axis, n);
  return normalize(vec3(-dot(frame.t, p.mirrored), -dot(frame.b, p.mirrored), max(dot(n, p.mirrored), 1e-3)));
}

ivec2 clamp_cell(ivec2 cell, int side) { return clamp(cell, ivec2(0), ivec2(side - 1)); }

vec2 map_cells(vec3 direction, int directions) { return (parabolic_from_direction(direction) * 0.5 + 0.5) * float(directions); }

/// Quadratic B-splines about the cells at one coordinate as two bilinear reads: offsets of both from the cell's centre, and the weight of the second.
/// Source: Sigg and Hadwiger 2005, "Fast Third-Order Texture Filtering", GPU Gems 2, chapter 20; here the middle cell is divided between both.
vec3 spline_reads(float t) {
  vec3 w = vec3(0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t));
  float low = w.x + 0.5 * w.y, high = w.z + 0.5 * w.y;
  return vec3(-w.x / low, w.z / high, high);
}

/// Of a term (mean or a component) of a cluster, towards a point of the map in cells; a tile has a border of one cell.
vec3 lumisphere_term(int cluster, int term, vec2 cells, int directions) {
  vec2 cell = clamp(floor(cells), vec2(0.0), vec2(float(directions - 1))) + 0.5;
  vec3 x = spline_reads(cells.x - cell.x), y = spline_reads(cells.y - cell.y);
  vec2 tile = vec2(cluster, term) * float(directions + 2) + 1.0 + cell, size = vec2(textureSize(t_lumispheres, 0));
  vec3 low = mix(texture(t_lumispheres, (tile + vec2(x.x, y.x)) / size).rgb, texture(t_lumispheres, (tile + vec2(x.y, y.x)) / size).rgb, x.z);
  vec3 high = mix(texture(t_lumispheres, (tile + vec2(x.x, y.y)) / size).rgb, texture(t_lumispheres, (tile + vec2(x.y, y.y)) / size).rgb, x.z);
  return mix(low, high, y.z);
}

vec3 decode_cluster(int cluster, vec4 weights[4], vec2 cells, FieldConstants k) {
  vec3 sum = lumisphere_term(cluster, 0, cells, k.directions);
  for (int c = 0; c < k.components; ++c) sum += weights[c >> 2][c & 3] * lumisphere_term(cluster, c + 1, cells, k.directions);
  return sum;
}

vec3 compressed_radiance(FieldPoint p, ivec2 base, vec2 f, FieldConstants k) {
  int layers = (k.components + 3) / 4;
  vec4 share = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
  uvec4 cells;
  for (int i = 0; i < 4; ++i) cells[i] = texelFetch(t_clusters, clamp_cell(base + ivec2(i & 1, i >> 1), k.side), 0).x;
  bool same = all(equal(cells, uvec4(cells.x)));
  // Weights of one cluster and direction blend; else each texel is decoded.
  vec3 sum = vec3(0.0);
  int decodes = same ? 1 : 4;
  for (int i = 0; i < decodes; ++i) {
    vec4 weights[4] = vec4[4](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    int first = same ? 0 : i, last = same ? 3 : i;
    for (int j = first; j <= last; ++j) {
      ivec2 cell = clamp_cell(base + ivec2(j & 1, j >> 1), k.side);
      for (int l = 0; l < layers; ++l) weights[l] += (same ? share[j] : 1.0) * texelFetch(t_weights, ivec3(cell, l), 0);
    }
    sum += (same ? 1.0 : share[i]) * decode_cluster(int(cells[i] & 255u), weights, map_cells(direction_at(p, cells[i]), k.directions), k);
  }
  return sum;
}

/// Coefficients of the column of a buffer, read towards a point of the map in cells.
vec3 read_spline(int column, vec2 cells, int directions) {
  ivec2 cell = clamp_cell(ivec2(floor(cells)), directions);
  vec2 t = cells - vec2(cell) - 0.5;
  vec2 low = 0.5 * (0.5 - t) * (0.5 - t), high = 0.5 * (0.5 + t) * (0.5 + t), middle = 0.75 - t * t;
  vec3 x = vec3(low.x, middle.x, high.x), y = vec3(low.y, middle.y, high.y), sum = vec3(0.0);
  for (int j = 0; j < 9; ++j) {
    ivec2 at = clamp_cell(cell + ivec2(j % 3 - 1, j / 3 - 1), directions);
    uvec2 half3 = texelFetch(t_field, (column * directions + at.y) * directions + at.x).xy;
    sum += x[j % 3] * y[j / 3] * vec3(unpackHalf2x16(half3.x), unpackHalf2x16(half3.y).x);
  }
  return sum;
}

vec3 stored_radiance(FieldPoint p, ivec2 base, vec2 f, FieldConstants k) {
  vec3 sum = vec3(0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 cell = clamp_cell(base + ivec2(i & 1, i >> 1), k.side);
    int texel = int(texelFetch(t_cells, cell, 0).x);
    vec2 cells = map_cells(direction_at(p, texelFetch(t_clusters, cell, 0).x), k.directions);
    float share = ((i & 1) == 1 ? f.x : 1.0 - f.x) * (i > 1 ? f.y : 1.0 - f.y);
    sum += share * read_spline(texel, cells, k.directions);
  }
  return sum;
}

/// Direction of the texel's frame in that of its material (render/slf/btf_response.h, to_btf).
vec3 turn_to_material(vec3 d, uint code) {
  float angle = float((code >> 16u) & 255u) * (6.28318531 / 128.0), c = cos(angle), s = sin(angle), up = c * d.y - s * d.x;
  return vec3(c * d.x + s * d.y, (code & 0x1000000u) != 0u ? -up : up, d.z);
}

vec3 interaction_radiance(FieldPoint p, ivec2 base, vec2 f, FieldConstants k) {
  int layers = (k.light_terms + 2) / 4;
  vec3 sum = vec3(0.0);
  for (int n = 0; n < 4; ++n) {
    ivec2 cell = clamp_cell(base + ivec2(n & 1, n >> 1), k.side);
    uint code = texelFetch(t_cells, cell, 0).x;
    vec2 cells = map_cells(turn_to_material(direction_at(p, texelFetch(t_clusters, cell, 0).x), code), k.directions);
    int column = (int(code & 255u) * k.material_clusters + int((code >> 8u) & 255u)) * k.light_terms * k.material_terms;
    vec3 own = vec3(0.0);
    for (int i = 0; i < k.light_terms; ++i) {
      float light = i == 0 ? 1.0 : texelFetch(t_weights, ivec3(cell, max(i - 1, 0) / 4), 0)[max(i - 1, 0) & 3];
      for (int j = 0; j < k.material_terms; ++j) {
        vec3 material = texelFetch(t_weights, ivec3(cell, layers + j), 0).rgb;
        own += light * material * read_spline(column + i * k.material_terms + j, cells, k.directions);
      }
    }
    sum += ((n & 1) == 1 ? f.x : 1.0 - f.x) * (n > 1 ? f.y : 1.0 - f.y) * own;
  }
  return sum;
}

/// cd/m2 towards the eye, without emission.
vec3 field_radiance(FieldPoint p) {
  FieldConstants k = field_constants();
  vec2 at = p.at - 0.5, base = floor(at);
  // A loop is skipped by software devices where no invocation enters it; both sides of a branch are not.
  vec3 sum = vec3(0.0);
  for (int i = 0; i < (k.compressed ? 1 : 0); ++i) sum = compressed_radiance(p, ivec2(base), at - base, k);
  bool table = k.light_terms > 0;
  for (int i = 0; i < (table ? 1 : 0); ++i) sum = interaction_radiance(p, ivec2(base), at - base, k);
  for (int i = 0; i < (k.compressed || table ? 0 : 1); ++i) sum = stored_radiance(p, ivec2(base), at - base, k);
  return max(sum, vec3(0.0)) * k.scale;
}
