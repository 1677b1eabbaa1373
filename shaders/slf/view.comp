// Debug views of the atlas of a surface light field.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/parabolic.glsl"
#include "shared/gbuffer.glsl"
#include "slf/light_field.glsl"
layout(binding = kImageRadiance, rgba32f) uniform writeonly image2D o_value;
#ifndef SLICE
uniform int u_view;  // 0: texels, 1: charts, 2: clusters, 3: errors, 4: weights
#endif

vec3 color_of(uint number) {
  uint h = (number + 1u) * 0x9e3779b9u;
  h ^= h >> 15u;
  h *= 0x85ebca6bu;
  h ^= h >> 13u;
  return 0.15 + 0.7 * vec3(float(h & 255u), float((h >> 8u) & 255u), float((h >> 16u) & 255u)) / 255.0;
}

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  FieldPoint p = load_field_point(pixel);
#ifdef SLICE
  vec3 value = field_radiance(p);
#else
  FieldConstants k = field_constants();
  ivec2 cell = clamp_cell(ivec2(floor(p.at)), k.side);
  vec3 value = color_of(uint(p.chart));
  if (u_view == 0) value *= ((cell.x ^ cell.y) & 1) == 1 ? 1.0 : 0.35;
  if (u_view == 2) value = color_of(texelFetch(t_clusters, cell, 0).x & 255u);
  if (u_view == 3) value = vec3(texelFetch(t_errors, cell, 0).x);
  if (u_view == 4) {
    vec3 w = texelFetch(t_weights, ivec3(cell, 0), 0).rgb;
    value = 0.5 + 0.5 * w / max(length(w), 1e-20);
  }
#endif
  imageStore(o_value, pixel, vec4(p.known ? value : vec3(0.0), 1.0));
}
