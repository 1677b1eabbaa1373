// A grid point of parts with precomputed transfer: its triangle, its three transfer vertices, and where its material is read.
// Needs frame, constants, octahedral, rgb9e5 and gbuffer included before.
#include "shared/bindings.glsl"
#include "prt/transfer.glsl"
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
// [triangle]: its place in the grid + 1 (0: none), level, tiles of its material for one unit of texture coordinates (as floats)
layout(binding = kUnitTransferTriangles) uniform usamplerBuffer t_transfer_triangles;
layout(binding = kUnitTransferGrid) uniform usamplerBuffer t_transfer_grid;
layout(binding = kUnitTransferShown) uniform samplerBuffer t_transfer_shown;
// [group][view][level][y][x][mean, components][rgb], four half floats a texel
layout(binding = kUnitTransferFactors) uniform samplerBuffer t_transfer_factors;

struct TransferPoint {
  bool known;
  ivec3 vertices;
  vec3 share;
  vec2 uv;          // in tiles of its material
  float footprint;  // in tiles; 1: the mean of the tile
  vec3 to_eye;
};

int grid_at(int first, int n, int i, int j) { return int(texelFetch(t_transfer_grid, first + j * (n + 1) - j * (j - 1) / 2 + i).x); }

/// The same as find_transfer_corners.
void find_corners(int first, int level, vec2 b, inout TransferPoint p) {
  int n = 1 << level;
  vec2 at = clamp(b, vec2(0.0), vec2(1.0)) * float(n);
  int i = min(int(at.x), n - 1), j = min(int(at.y), n - 1);
  if (i + j > n - 1) {
    if (i > 0) i = max(n - 1 - j, 0);
    else j = n - 1;
  }
  vec2 f = at - vec2(i, j);
  if (f.x + f.y <= 1.0 || i + j >= n - 1) {
    f /= max(f.x + f.y, 1.0);
    p.vertices = ivec3(grid_at(first, n, i, j), grid_at(first, n, i + 1, j), grid_at(first, n, i, j + 1));
    p.share = vec3(1.0 - f.x - f.y, f);
  } else {
    p.vertices = ivec3(grid_at(first, n, i + 1, j + 1), grid_at(first, n, i, j + 1), grid_at(first, n, i + 1, j));
    p.share = vec3(f.x + f.y - 1.0, 1.0 - f.x, 1.0 - f.y);
  }
}

TransferPoint load_transfer_point(ivec2 pixel) {
  TransferPoint r;
  int triangle = max(int(texelFetch(t_triangle, pixel, 0).x), 1) - 1;
  ivec3 v = ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x, texelFetch(t_indices, 3 * triangle + 2).x);
  vec4 p0 = texelFetch(t_vertices, 4 * v.x), p1 = texelFetch(t_vertices, 4 * v.y), p2 = texelFetch(t_vertices, 4 * v.z);
  vec2 s0 = vec2(p0.w, texelFetch(t_vertices, 4 * v.x + 1).w), s1 = vec2(p1.w, texelFetch(t_vertices, 4 * v.y + 1).w),
       s2 = vec2(p2.w, texelFetch(t_vertices, 4 * v.z + 1).w);
  vec3 e1 = p1.xyz - p0.xyz, e2 = p2.xyz - p0.xyz, ray = view_ray(pixel);
  r.to_eye = -normalize(ray);
  vec2 here = intersect_plane_of_triangle(view_origin(pixel), ray, p0.xyz, e1, e2).barycentric;
  vec2 across = intersect_plane_of_triangle(view_origin(pixel + ivec2(1, 0)), view_ray(pixel + ivec2(1, 0)), p0.xyz, e1, e2).barycentric - here;
  vec2 down = intersect_plane_of_triangle(view_origin(pixel + ivec2(0, 1)), view_ray(pixel + ivec2(0, 1)), p0.xyz, e1, e2).barycentric - here;
  vec2 b = clamp(here, 0.0, 1.0);
  b /= max(1.0, b.x + b.y);
  uvec4 place = texelFetch(t_transfer_triangles, triangle);
  r.known = place.x > 0u && dot(cross(e1, e2), r.to_eye) >= 0.0;
  find_corners(int(max(place.x, 1u)) - 1, int(place.y), b, r);
  vec2 tiles = uintBitsToFloat(place.zw);
  r.uv = (s0 + (s1 - s0) * b.x + (s2 - s0) * b.y) * tiles;
  vec2 dx = ((s1 - s0) * across.x + (s2 - s0) * across.y) * tiles, dy = ((s1 - s0) * down.x + (s2 - s0) * down.y) * tiles;
  r.footprint = tiles.x > 0.0 ? sqrt(max(dot(dx, dx), dot(dy, dy))) : 1.0;
#ifdef REFLECTED
  // At a pane's border the next pixel has no ray.
  if (texelFetch(t_ray_direction, pixel + ivec2(1, 0), 0).w <= 0.0 || texelFetch(t_ray_direction, pixel + ivec2(0, 1), 0).w <= 0.0) r.footprint = 0.0;
#endif
  return r;
}

struct FactorLevel {
  int first, width, height;
};
/// The two levels of a view that a footprint lies between.
struct NearLevels {
  FactorLevel fine, coarse;
  float share;  // of the coarse one
  int all;      // texels of all levels
};
/// `material`: the group's second texel. `texels`: of the buffer, for one of the material.
NearLevels near_levels(uvec4 material, int texels, float footprint) {
  FactorLevel level = FactorLevel(0, int(material.y), int(material.z));
  float texel_footprint = footprint * float(max(level.width, level.height));
  float place = min(texel_footprint > 1.0 ? log2(texel_footprint) : 0.0, float(findMSB(max(level.width, level.height))));
  int fine = int(place);
  NearLevels near = NearLevels(level, level, place - float(fine), 0);
  while (true) {  // every level, to know where the next view begins
    if (fine >= 0) near.fine = FactorLevel(near.all, level.width, level.height);
    if (fine == 0 || fine == -1) near.coarse = FactorLevel(near.all, level.width, level.height);
    near.all += level.width * level.height * texels;
    --fine;
    if (level.width == 1 && level.height == 1) break;
    level.width = max(1, level.width / 2), level.height = max(1, level.height / 2);
  }
  return near;
}

/// Four texels around a point of a level, by their places in the buffer.
struct NearTexels {
  ivec4 first;
  vec4 share;
};
NearTexels near_texels(FactorLevel level, int texels, vec2 uv) {
  vec2 at = fract(uv) * vec2(level.width, level.height) - 0.5, low = floor(at), f = at - low;
  NearTexels near;
  for (int k = 0; k < 4; ++k) {
    ivec2 cell = ivec2(low) + ivec2(k & 1, k >> 1);
    cell = ivec2(cell.x < 0 ? level.width - 1 : (cell.x >= level.width ? 0 : cell.x), cell.y < 0 ? level.height - 1 : (cell.y >= level.height ? 0 : cell.y));
    near.share[k] = ((k & 1) == 1 ? f.x : 1.0 - f.x) * (k > 1 ? f.y : 1.0 - f.y);
    near.first[k] = level.first + (cell.y * level.width + cell.x) * texels;
  }
  return near;
}

#ifdef JOINT
/// Light times factors of one texel: of its cluster's functions, at the three vertices.
vec3 texel_radiance(TransferPoint p, int first, int terms, NearViews views[3]) {
  vec4 four = texelFetch(t_transfer_factors, first);
  int cluster = int(four.x), at = 1;
  vec3 sum = vec3(0.0);
  for (int c = 0; c < terms; ++c) {
    vec3 color;
    for (int n = 0; n < 3; ++n, ++at) {
      if ((at & 3) == 0) four = texelFetch(t_transfer_factors, first + at / 4);
      color[n] = four[at & 3];
    }
    vec3 light = vec3(0.0);
    for (int k = 0; k < 3; ++k)
      if (p.share[k] > 0.0) {
#ifdef REFLECTED
        light += p.share[k] * function_light(int(texelFetch(t_transfer_places, p.vertices[k]).x), cluster * terms + c, views[k]);
#else
        light += p.share[k] * texelFetch(t_transfer_shown, p.vertices[k] * u_transfer_functions + cluster * terms + c).rgb;
#endif
      }
    sum += color * light;
  }
  return sum;
}

/// Radiance towards the eye: that of each texel around the point and its level, blended. Views are those of the vertices.
vec3 transfer_radiance(TransferPoint p) {
  uint group_index = texelFetch(t_transfer_places, p.vertices.x).y;
  uvec4 material = texelFetch(t_transfer_groups, 2 * int(group_index) + 1);
  int terms = 1 + int(material.w), texels = (1 + 3 * terms + 3) / 4;
  NearViews none = NearViews(ivec3(0), vec3(0.0)), views[3] = NearViews[3](none, none, none);
#ifdef REFLECTED
  uvec4 group = texelFetch(t_transfer_groups, 2 * int(group_index));
  for (int k = 0; k < 3; ++k) views[k] = vertex_views(p.vertices[k], group, p.to_eye);
#endif
  NearLevels near = near_levels(material, texels, p.footprint);
  vec3 sum = vec3(0.0);
  for (int l = 0; l < 2; ++l) {
    float of_level = l == 0 ? 1.0 - near.share : near.share;
    FactorLevel level = near.fine;
    if (l == 1) level = near.coarse;
    level.first += int(material.x);
    if (!(of_level > 0.0)) continue;
    NearTexels four = near_texels(level, texels, p.uv);
    for (int k = 0; k < 4; ++k)
      if (four.share[k] > 0.0) sum += of_level * four.share[k] * texel_radiance(p, four.first[k], terms, views);
  }
  return max(sum, vec3(0.0));
}
#else
const int kFactorTexels = (3 * TERMS + 3) / 4;

/// Factors of a view: the mean texture and the eigen-textures at a point. Texels bilinear, levels linear, as read_btf_factors.
struct Factors {
  vec4 four[kFactorTexels];
};

void add_factor_level(FactorLevel level, int texels, vec2 uv, float share, inout Factors sum) {
  NearTexels near = near_texels(level, texels, uv);
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < kFactorTexels; ++i)
      if (i < texels) sum.four[i] += share * near.share[k] * texelFetch(t_transfer_factors, near.first[k] + i);
}

/// `material`: the group's second texel. `view`: of it.
Factors read_factors(uvec4 material, int view, vec2 uv, float footprint) {
  int components = int(material.w), texels = (3 * (1 + components) + 3) / 4;
  NearLevels near = near_levels(material, texels, footprint);
  int first = int(material.x) + view * near.all;
  near.fine.first += first, near.coarse.first += first;
  Factors sum;
  for (int i = 0; i < kFactorTexels; ++i) sum.four[i] = vec4(0.0);
  add_factor_level(near.fine, texels, uv, 1.0 - near.share, sum);
  if (near.share > 0.0) add_factor_level(near.coarse, texels, uv, near.share, sum);
  return sum;
}

vec3 factor_color(Factors f, int c) {
  vec3 color;
  for (int k = 0; k < 3; ++k) color[k] = f.four[(3 * c + k) >> 2][(3 * c + k) & 3];
  return color;
}

/// Radiance towards the eye. The views and their shares are those of the vertices, and what is interpolated over the triangle is the radiance that
/// the point's own texels have under each vertex's light: on an edge it depends on the edge's two vertices alone, so that no seam shows where the
/// nearest views of neighbours differ.
vec3 transfer_radiance(TransferPoint p) {
  uint group_index = texelFetch(t_transfer_places, p.vertices.x).y;
  int components = int(texelFetch(t_transfer_groups, 2 * int(group_index)).x);
  uvec4 material = texelFetch(t_transfer_groups, 2 * int(group_index) + 1);
  int view[9];
  vec3 light[9 * TERMS];
  int count = 0;
  for (int k = 0; k < 3; ++k) {
#ifdef REFLECTED
    VertexTransfer at = vertex_transfer(p.vertices[k], p.to_eye);
#endif
    for (int v = 0; v < 3; ++v) {
#ifdef REFLECTED
      int index = at.views.share[v] > 0.0 ? at.views.index[v] : -1;
#else
      int texel = (p.vertices[k] * 3 + v) * TERMS;
      vec4 mean = texelFetch(t_transfer_shown, texel);
      int index = int(mean.w);
#endif
      if (index < 0 || !(p.share[k] > 0.0)) continue;
      int slot = count;
      for (int s = 0; s < count; ++s)
        if (view[s] == index) slot = s;
      if (slot == count) {
        view[slot] = index;
        for (int c = 0; c < TERMS; ++c) light[slot * TERMS + c] = vec3(0.0);
        ++count;
      }
      for (int c = 0; c < TERMS; ++c) {
#ifdef REFLECTED
        vec3 own = (c == 0 ? at.mean : at.light[v * TERMS + c]) * at.views.share[v];
#else
        vec3 own = texelFetch(t_transfer_shown, texel + c).rgb;
#endif
        light[slot * TERMS + c] += p.share[k] * own;
      }
    }
  }
  vec3 sum = vec3(0.0);
  for (int s = 0; s < count; ++s) {
    Factors f = read_factors(material, view[s], p.uv, p.footprint);
    for (int c = 0; c < TERMS; ++c)
      if (c <= components) sum += light[s * TERMS + c] * factor_color(f, c);
  }
  return max(sum, vec3(0.0));
}
#endif
