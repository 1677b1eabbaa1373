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
layout(binding = kUnitLightFieldLumispheres) uniform sampler2DArray t_lumispheres;  // [mean, components]: tiles of clusters, kLumisphereColumns a row
layout(binding = kUnitLightFieldCells) uniform usampler2D t_cells;        // [y][x] texel, where nothing is compressed; of interactions light and material cluster, turn, 8 bits each, mirrored
layout(binding = kUnitLightFieldRadiance) uniform usamplerBuffer t_field;  // [texel][y][x of the lumisphere], half floats
layout(binding = kUnitLightFieldErrors) uniform sampler2D t_errors;       // [y][x]

#ifdef SLICE
uniform float u_slice_tilt, u_slice_turn;  // rad, of the direction of a texel's frame that is read instead of that to the eye
#endif

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

/// Of a triangle that has a side in the atlas.
FieldPoint place_in_field(ivec2 pixel, int triangle) {
  FieldPoint r;
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

FieldPoint load_field_point(ivec2 pixel) {
  FieldPoint r;
  r.known = false;
  r.at = vec2(0.0);
  r.chart = 0;
  int triangle = max(int(texelFetch(t_triangle, pixel, 0).x), 1) - 1;
  bool any = (texelFetch(t_slots, 2 * triangle).x | texelFetch(t_slots, 2 * triangle + 1).x) != 0u;
  // A loop is skipped by software devices where no invocation enters it; both sides of a branch are not.
  for (int i = 0; i < (any ? 1 : 0); ++i) r = place_in_field(pixel, triangle);
  return r;
}

/// Direction in the frame of a texel (its word of t_clusters) in which it mirrors what the point mirrors. Texels whose normals differ then show one
/// highlight at one place; with the direction to the eye itself it would lie between theirs, blurred by their angle.
vec3 direction_at(FieldPoint p, uint cell) {
#ifdef SLICE
  return vec3(sin(u_slice_tilt) * vec2(cos(u_slice_turn), sin(u_slice_turn)), cos(u_slice_tilt));
#endif
  vec3 n = direction_from_octahedral(vec2(float((cell >> 8u) & 4095u), float(cell >> 20u)) / 4095.0);
  CarriedFrame frame = carried_frame(p.axis, n);
  return normalize(vec3(-dot(frame.t, p.mirrored), -dot(frame.b, p.mirrored), max(dot(n, p.mirrored), 1e-3)));
}

ivec2 clamp_cell(ivec2 cell, int side) { return clamp(cell, ivec2(0), ivec2(side - 1)); }

vec2 map_cells(vec3 direction, int directions) { return (parabolic_from_direction(direction) * 0.5 + 0.5) * float(directions); }

const int kLumisphereColumns = 16;

/// Where the map of a cluster's lumisphere is read towards a point of it in cells. The map's splines are tabulated closer than its cells
/// (render/slf/buffers.cpp) and read bilinearly; a tile has a border of one texel.
vec2 lumisphere_at(int cluster, vec2 cells, FieldConstants k) {
  vec2 size = vec2(textureSize(t_lumispheres, 0).xy);
  float tile = size.x / float(kLumisphereColumns);
  vec2 corner = vec2(cluster % kLumisphereColumns, cluster / kLumisphereColumns) * tile + 1.0;
  return (corner + cells * ((tile - 2.0) / float(k.directions))) / size;
}
/// What four components add; weights of those that are not there are 0.
vec3 four_components(vec2 at, int layer, vec4 weights) {
  float first = float(4 * layer + 1);
  return weights.x * texture(t_lumispheres, vec3(at, first)).rgb + weights.y * texture(t_lumispheres, vec3(at, first + 1.0)).rgb +
         weights.z * texture(t_lumispheres, vec3(at, first + 2.0)).rgb + weights.w * texture(t_lumispheres, vec3(at, first + 3.0)).rgb;
}

/// Directions of neighbouring texels that differ by less are read at their mean, in cells: that errs by 1/32 of the map's second derivative.
const float kOneDirection = 0.25;

vec3 texel_reading(FieldPoint p, ivec2 cell, FieldConstants k) {
  uint word = texelFetch(t_clusters, clamp_cell(cell, k.side), 0).x;
  return vec3(map_cells(direction_at(p, word), k.directions), float(word & 255u));
}

vec3 compressed_radiance(FieldPoint p, ivec2 base, vec2 f, FieldConstants k) {
  int layers = (k.components + 3) / 4;
  // x, y: read point of the texel; z: its cluster.
  vec3 t0 = texel_reading(p, base, k), t1 = texel_reading(p, base + ivec2(1, 0), k), t2 = texel_reading(p, base + ivec2(0, 1), k),
       t3 = texel_reading(p, base + ivec2(1, 1), k);
  vec3 mean = mix(mix(t0, t1, f.x), mix(t2, t3, f.x), f.y), far = max(max(abs(t0 - mean), abs(t1 - mean)), max(abs(t2 - mean), abs(t3 - mean)));
  bool same = all(lessThan(far, vec3(kOneDirection, kOneDirection, 1.0e-3)));
  vec3 sum = vec3(0.0);
  // Weights of one cluster and direction blend; else each texel is decoded.
  for (int i = 0; i < (same ? 1 : 0); ++i) {
    vec2 point = lumisphere_at(int(t0.z), mean.xy, k);
    sum = texture(t_lumispheres, vec3(point, 0.0)).rgb;
    for (int l = 0; l < layers; ++l)
      sum += four_components(point, l, texture(t_weights, vec3((vec2(base) + f + 0.5) / float(k.side), float(l))));
  }
  for (int i = 0; i < (same ? 0 : 4); ++i) {
    ivec2 cell = clamp_cell(base + ivec2(i & 1, i >> 1), k.side);
    vec3 t = i < 2 ? (i == 0 ? t0 : t1) : (i == 2 ? t2 : t3);
    vec2 point = lumisphere_at(int(t.z), t.xy, k);
    vec3 own = texture(t_lumispheres, vec3(point, 0.0)).rgb;
    for (int l = 0; l < layers; ++l) own += four_components(point, l, texelFetch(t_weights, ivec3(cell, l), 0));
    sum += ((i & 1) == 1 ? f.x : 1.0 - f.x) * (i > 1 ? f.y : 1.0 - f.y) * own;
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

/// cd/m2 towards the eye, without emission; black where the atlas does not have the point.
vec3 field_radiance(FieldPoint p) {
  FieldConstants k = field_constants();
  vec2 at = p.at - 0.5, base = floor(at);
  bool table = k.light_terms > 0;
  vec3 sum = vec3(0.0);
  for (int i = 0; i < (p.known && k.compressed ? 1 : 0); ++i) sum = compressed_radiance(p, ivec2(base), at - base, k);
  for (int i = 0; i < (p.known && table ? 1 : 0); ++i) sum = interaction_radiance(p, ivec2(base), at - base, k);
  for (int i = 0; i < (!p.known || k.compressed || table ? 0 : 1); ++i) sum = stored_radiance(p, ivec2(base), at - base, k);
  return max(sum, vec3(0.0)) * k.scale;
}
