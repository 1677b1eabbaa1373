// Debug views of precomputed radiance transfer.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "prt/point.glsl"
layout(binding = kImageRadiance, rgba32f) uniform writeonly image2D o_value;
uniform float u_environment_scale;
uniform int u_view;  // 0: vertices, 1: clusters of the mean, 2: light of the mean, 3: of the first component, 4: error

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
  TransferPoint p = load_transfer_point(pixel);
  int k = p.share.x >= max(p.share.y, p.share.z) ? 0 : (p.share.y >= p.share.z ? 1 : 2);
  vec3 value = color_of(uint(p.vertices[k]));
  if (u_view == 1) {
    int first = int(texelFetch(t_transfer_places, p.vertices[k]).x);
    value = color_of(texelFetch(t_transfer_records, first).x);
  }
  if (u_view >= 2) value = vec3(0.0);
  if (u_view == 4) {
    for (int c = 0; c < 3; ++c) value += p.share[c] * texelFetch(t_transfer_vertices, 4 * p.vertices[c]).w;
  } else if (u_view >= 2) {
    for (int c = 0; c < 3; ++c)
#ifdef JOINT
      value += p.share[c] * texelFetch(t_transfer_shown, p.vertices[c] * u_transfer_functions + u_view - 2).rgb;
#else
      for (int v = 0; v < 3; ++v) value += p.share[c] * texelFetch(t_transfer_shown, (p.vertices[c] * 3 + v) * TERMS + u_view - 2).rgb;
#endif
    value *= u_environment_scale;
  }
  imageStore(o_value, pixel, vec4(p.known ? value : vec3(0.0), 1.0));
}
