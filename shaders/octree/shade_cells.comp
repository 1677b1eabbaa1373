// Radiance of the cells with BRDFs that mirrored rays hit: samples of the environment's list, each with one of the neighbouring tabulated
// directions of view and light, chosen with its bilinear weight.
// Source: Pharr et al. 2024, "Filtering After Shading With Stochastic Texture Filtering", Sec. 4, for this choice.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shading/linear_id.glsl"
#define REFLECTED 1
#include "shared/frame.glsl"
#include "octree/tables.glsl"
#include "octree/cells.glsl"
#include "shared/hash.glsl"
layout(binding = kUnitLightSamples) uniform samplerBuffer t_light_samples;  // two texels: direction, pdf | radiance, nu_L
layout(std430, binding = kBufferOctreeLayers) buffer Layers { uvec4 b_layers[]; };  // pixel, node | level << 26, t, weight; then radiance
uniform int u_layer_count;
uniform int u_samples;

/// Shadow rays start this many cells from the middle: outside the cell, whose own shadows are in its BRDF.
const float kLeave = 0.9;
const float kOwnCells = 1.8;
vec2 unit_pair(uint x) { return vec2(float(x >> 16u), float(x & 65535u)) * (1.0 / 65536.0); }

void main() {
  uint id = linear_id();
  if (id >= uint(u_layer_count)) return;
  uvec4 layer = b_layers[id];
  ivec2 pixel = ivec2(layer.x & 65535u, layer.x >> 16u);
  int node = int(layer.y & 0x3ffffffu), level = int(layer.y >> 26u);
  float t = uintBitsToFloat(layer.z), weight = uintBitsToFloat(layer.w);
  vec3 direction = view_ray(pixel);
  CellCode code = cell_code(int(texelFetch(t_cell_of_node, node).x) - 1);
  CellFrame frame = cell_frame(code, cell_plane(node, level).normal);
  CellLookup view = cell_lookup(cell_from_world(frame, -direction));
  float cell_m = float(1 << (u_octree_depth - level)) / u_octree.w;
  vec3 inside = (view_origin(pixel) + (t + 1e-3 * cell_m) * direction - u_octree.xyz) / cell_m;
  vec3 middle = u_octree.xyz + (floor(inside) + 0.5) * cell_m;
  uint rotation = hash(uint(pixel.x) + (uint(pixel.y) << 16u) + hash(uint(u_frame.sampling.w)));
  uint first = hash(rotation ^ 0x5bd1e995u) + uint(u_frame.sampling.z) + uint(u_frame.bandwidth_size.w);
  uint q = hash(rotation ^ 0x68bc21ebu) + uint(u_frame.sampling.z) * 0xD1B54A33u, r = hash(rotation ^ 0x02e5be93u);
  int mask = u_frame.environment_size.w - 1;
  vec3 sum = vec3(0.0);
  for (int i = 0; i < u_samples && u_frame.environment.w > 0.0; ++i) {
    int index = int((first + uint(i)) & uint(mask));
    vec4 direction_pdf = texelFetch(t_light_samples, 2 * index);
    vec3 world = world_from_environment(direction_pdf.xyz);
    q += 0xD1B54A33u;
    r += 0x9E3779B9u;
    vec2 a = unit_pair(q), b = unit_pair(hash(r));
    vec3 value = cell_pair_value(code, cell_sample_index(view, a.x, a.y), cell_sample_index(cell_lookup(cell_from_world(frame, world)), b.x, b.y));
#if VISIBILITY == 2
    OctreeHit hit = octree_trace(octree_frame(), OctreeRay(middle, world, kLeave * cell_m, 1e30, kOwnCells * cell_m, 0.0, 0.0));
    value *= hit.node >= 0 ? 0.0 : 1.0;
#endif
    sum += value * texelFetch(t_light_samples, 2 * index + 1).rgb / max(direction_pdf.w, 1e-30);
  }
  sum = max(sum, vec3(0.0)) * (weight * u_frame.environment.z / float(u_samples));
  b_layers[id] = uvec4(floatBitsToUint(sum.r), floatBitsToUint(sum.g), floatBitsToUint(sum.b), 0u);
}
