// G-buffer of what mirrored rays hit in the octree: normal, material and mean colour of a cell, and one triangle of it. The traversal stops at
// cells as wide as the pixel's cone. GLOSSY: rays of opaque surfaces, with cones as wide as their lobes.
layout(local_size_x = 64) in;
#define REFLECTED 1
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "gbuffer/material_surface.glsl"
#include "octree/tables.glsl"
layout(binding = kUnitOctreeColors) uniform usamplerBuffer t_octree_colors;        // [node]
layout(binding = kUnitOctreeTriangles) uniform usamplerBuffer t_octree_triangles;  // [node], of the geometry
uint octree_color_word(int node) { return texelFetch(t_octree_colors, node).x; }
#include "shared/octree_surface.glsl"
layout(binding = kImageSurface, rgba32ui) uniform writeonly uimage2D o_surface;
layout(binding = kImageDepth, r32f) uniform writeonly image2D o_depth;
layout(binding = kImageOctreeTriangle, r32ui) uniform writeonly uimage2D o_triangle;
layout(binding = kImageOctreeEffort, rg8ui) uniform writeonly uimage2D o_effort;
layout(binding = kImageGuide, rg32ui) uniform writeonly uimage2D o_guide;
layout(std430, binding = kBufferOctreeCounters) buffer Counters { uint b_rays, b_steps, b_layer_count; };
#if CELLS
#include "octree/cells.glsl"
layout(std430, binding = kBufferOctreeLayers) writeonly buffer Layers { uvec4 b_layers[]; };  // pixel, node | level << 26, t, weight
layout(binding = kImageOctreeLayers, rg32ui) uniform writeonly uimage2D o_layers;            // first layer, count | what comes through (half) << 16
uniform int u_layer_capacity;
uniform int u_all_cells;  // 0: flat cells of one material use it instead of a cell BRDF

/// Largest number of cells with BRDFs along a ray; the last one is treated as opaque.
const int kMaxLayers = 4;
/// A ray stops when its transmittance is below this; a cell with a smaller opacity is not shaded.
const float kLeastShare = 0.01;

/// Distance at which the ray leaves the cell that it meets at `t`.
float leave_cell(vec3 origin, vec3 direction, float t, float cell_m) {
  vec3 lower = u_octree.xyz + floor((origin + (t + 1e-3 * cell_m) * direction - u_octree.xyz) / cell_m) * cell_m;
  vec3 to = lower + cell_m * vec3(greaterThan(direction, vec3(0.0)));
  vec3 out_t = (to - origin) / (max(abs(direction), vec3(1e-20)) * (vec3(1.0) - 2.0 * vec3(lessThan(direction, vec3(0.0)))));
  return max(min(min(out_t.x, out_t.y), out_t.z), t + 0.02 * cell_m);
}
#endif
#if GLOSSY
layout(binding = kUnitLobeWidth) uniform sampler2D t_width;  // rad: half of the lobe lies within
/// Cells of the surface's own material are skipped while the ray is less than this many cells above it: a curved surface is not as flat
/// as its cells.
const float kOwnHeight = 1.0;
/// Width of a cell relative to the half angle of the lobe.
const float kLobeCells = 1.0;
#else
uniform int u_own_material[16];  // of each opaque reflector, which is in the octree; -1: a pane, which is not
uniform vec3 u_own_low[16];      // its bounds, m
uniform vec3 u_own_high[16];
#endif

/// Up to this distance, in cells, a solid cell is assumed to be the frame that touches the reflector.
const float kFrameCells = 1.8;
/// Number of a mirror's own cells that a ray skips: those in which it starts, and those of facets in front of a concave mirror's true surface.
const int kOwnCells = 6;
/// A mean of normals may face away from the ray: it is rotated back to this cosine, as interpolated normals are.
const float kLeastFacing = 0.004;
/// The same for a mean that faces away: the visible part of the cell faces the ray with about this cosine.
const float kRimFacing = 0.15;

void store_nothing(ivec2 pixel, int steps) {
  imageStore(o_effort, pixel, uvec4(uint(min(steps, 255)), 0u, 0u, 0u));
  imageStore(o_surface, pixel, uvec4(0u));
  imageStore(o_depth, pixel, vec4(0.0));
  imageStore(o_guide, pixel, uvec4(0u));
  imageStore(o_triangle, pixel, uvec4(0u));
}

#if GLOSSY
/// Angle to the ray of a neighbour along an axis, the smaller of both sides: one may lie beyond an edge.
float angle_along(ivec2 pixel, ivec2 step_px, vec4 direction) {
  float least = 1e30;
  for (int k = -1; k <= 1; k += 2) {
    vec4 other = texelFetch(t_ray_direction, clamp(pixel + k * step_px, ivec2(0), u_frame.size.xy - 1), 0);
    float angle = length(other.xyz - direction.xyz);
    if (other.w == direction.w && angle > 0.0) least = min(least, angle);
  }
  return least < 1e30 ? least : pixel_angle();
}
/// Spread of the cone: that of the lobe, or that caused by the surface's curvature if larger. Blending cells with their neighbours doubles it.
float spread_of(ivec2 pixel, vec4 direction) {
  float angle = 0.5 * (angle_along(pixel, ivec2(1, 0), direction) + angle_along(pixel, ivec2(0, 1), direction));
  return max(angle, kLobeCells * texelFetch(t_width, pixel, 0).x);
}

/// True for a cell of the surface itself. The normal is halfway between the mirrored ray and the view direction.
bool is_own(vec3 origin, vec4 direction, OctreeColor color, float t, float cell_m) {
  vec3 normal = normalize(direction.xyz - normalize(from_eye(origin)));
  return color.material == int(direction.w) - 1 && t * dot(direction.xyz, normal) < kOwnHeight * cell_m;
}
#else
/// Angle between the rays of neighbouring pixels: a curved pane spreads them.
float spread_of(ivec2 pixel, vec4 direction) {
  float sum = 0.0, count = 0.0;
  for (int k = 0; k < 4; ++k) {
    ivec2 to = pixel + ivec2((k & 1) * 2 - 1, 0) * (1 - (k >> 1)) + ivec2(0, (k & 1) * 2 - 1) * (k >> 1);
    vec4 other = texelFetch(t_ray_direction, clamp(to, ivec2(0), u_frame.size.xy - 1), 0);
    if (other.w != direction.w || to != clamp(to, ivec2(0), u_frame.size.xy - 1)) continue;
    sum += length(other.xyz - direction.xyz);
    count += 1.0;
  }
  return count > 0.0 ? sum / count : pixel_angle();
}
bool is_within(vec3 p, int reflector, float margin) {
  return all(greaterThan(p, u_own_low[reflector] - margin)) && all(lessThan(p, u_own_high[reflector] + margin));
}
bool is_own(vec3 origin, vec4 direction, OctreeColor color, float t, float cell_m) {
  int reflector = int(direction.w) - 1;
  return color.material == u_own_material[reflector] && is_within(origin + t * direction.xyz, reflector, cell_m);
}
#endif

/// Whether a cell's colour is that of the material's emissive texture; without one it is that of the base colour.
bool has_emissive_texture(int material, vec3 emission) {
  if (emission == vec3(0.0)) return false;
  for (int k = 0; k < kMostTextures; ++k) {
    uint entry = material_texture(material, k);
    if (entry == kNoTexture) break;
    if (entry >> 16u == kRoleEmissive) return true;
  }
  return false;
}

/// The cell that is met, as gbuffer/resolve.comp stores a surface.
void store_surface(ivec2 pixel, vec3 origin, vec3 direction, OctreeHit hit, int steps) {
  OctreeSurface seen = octree_surface(octree_frame(), hit, origin + hit.t * direction, direction);
  vec3 normal = seen.normal;
  float facing = -dot(normal, direction);
  float least = facing < 0.0 ? kRimFacing : kLeastFacing;
  if (facing < least) normal = normalize(normal - direction * (least - facing));
  vec4 m2 = material_floats(seen.material, 2);
  bool glows = has_emissive_texture(seen.material, m2.rgb);
  Surface surface = surface_of_material(seen.material, normal);
  if (!glows) surface.base_color *= seen.tint;
#if DETAILS
  surface.anisotropy = 0.0;  // a cell has no tangents
  store_details(pixel, surface);
#endif
  float depth = max(hit.t, 1e-30);
  imageStore(o_surface, pixel, pack_surface(surface, glows ? seen.tint : vec3(1.0)));
  imageStore(o_depth, pixel, vec4(depth));
  imageStore(o_guide, pixel, uvec4(pack_guide(depth, normal, seen.material), 0u, 0u));
  imageStore(o_effort, pixel, uvec4(uint(min(steps, 255)), uint(hit.level), 0u, 0u));
  imageStore(o_triangle, pixel, uvec4(texelFetch(t_octree_triangles, hit.node).x + 1u));
}

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  vec4 direction = texelFetch(t_ray_direction, pixel, 0);
  if (direction.w <= 0.0) {
    store_nothing(pixel, 0);
#if CELLS
    imageStore(o_layers, pixel, uvec4(0u, packHalf2x16(vec2(1.0, 0.0)) << 16u, 0u, 0u));
#endif
    return;
  }
  vec4 origin = texelFetch(t_ray_origin, pixel, 0);
  float even_cell_m = float(1 << u_octree_detail) / u_octree.w;
  OctreeRay ray = OctreeRay(origin.xyz, direction.xyz, 0.0, 1e30, kFrameCells * even_cell_m, pixel_width(origin.w), spread_of(pixel, direction));
  OctreeHit hit;
  OctreeColor color;
  int steps = 0, own = 0;
#if CELLS
  uvec4 layers[kMaxLayers];
  int layer_count = 0;
  float through = 1.0;
#endif
  bool going = true;
  while (going) {
    hit = octree_trace(octree_frame(), ray);
    steps += hit.steps;
    if (hit.node < 0) break;
    going = false;
    color = octree_unpack_color(texelFetch(t_octree_colors, hit.node).x);
    float cell_m = float(1 << (u_octree_depth - hit.level)) / u_octree.w;
    if (own < kOwnCells && is_own(origin.xyz, direction, color, hit.t, cell_m)) {
      ++own;
      ray.t_min = hit.t + 0.5 * cell_m;
      going = true;
    }
#if CELLS
    int cell = going ? 0 : int(texelFetch(t_cell_of_node, hit.node).x);
    CellCode code = cell_code(max(cell - 1, 0));
    if (cell > 0 && (u_all_cells != 0 || !code.flat_shared)) {
      OctreePlane plane = cell_plane(hit.node, hit.level);
      float seen = cell_seen(code, cell_from_world(cell_frame(code, plane.normal), -direction.xyz));
      float outline = cell_outline(direction.xyz);
      // The traversal has hit the plane of a flat cell, which is opaque.
      float opacity = plane.planar || layer_count + 1 == kMaxLayers ? 1.0 : min(seen / outline, 1.0);
      if (opacity > 1.0 - kLeastShare) opacity = 1.0;
      if (opacity > kLeastShare && seen > 1e-4) {
        uint where = uint(pixel.x) | (uint(pixel.y) << 16u);
        layers[layer_count++] = uvec4(where, uint(hit.node) | (uint(hit.level) << 26u), floatBitsToUint(hit.t), floatBitsToUint(through * opacity / seen));
        through *= 1.0 - opacity;
      }
      going = through > kLeastShare;
      if (!going) through = 0.0;
      ray.t_min = leave_cell(origin.xyz, direction.xyz, hit.t, cell_m);
    }
#endif
  }
  atomicAdd(b_rays, 1u);
  atomicAdd(b_steps, uint(steps));
#if CELLS
  uint first = layer_count > 0 ? atomicAdd(b_layer_count, uint(layer_count)) : 0u;
  // The buffer has space for two layers a pixel; the host draws again with a larger one when this is not enough.
  if (first + uint(layer_count) > uint(u_layer_capacity)) layer_count = 0;
  for (int k = 0; k < layer_count; ++k) b_layers[first + uint(k)] = layers[k];
  imageStore(o_layers, pixel, uvec4(first, uint(layer_count) | (packHalf2x16(vec2(through, 0.0)) << 16u), 0u, 0u));
  if (hit.node >= 0 && through == 0.0) {
    store_nothing(pixel, steps);
    imageStore(o_effort, pixel, uvec4(uint(min(steps, 255)), uint(hit.level), 0u, 0u));
    return;
  }
#endif
  if (hit.node < 0) {
    store_nothing(pixel, steps);
    return;
  }
  store_surface(pixel, origin.xyz, direction.xyz, hit, steps);
}
