// Shows precomputed radiance transfer at every point of a layer.
layout(local_size_x = 64) in;
#ifndef BAKED
#define BAKED 1
#endif
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "prt/point.glsl"
layout(binding = kImageRadiance, rgba32f) uniform writeonly image2D o_radiance;
layout(binding = kImageLookupMarks, rgba8ui) uniform writeonly uimage2D o_marks;  // shaded, level, log2 of samples, 1 if visible
layout(std430, binding = kBufferCounters) buffer Counters { uint b_visible, b_shaded; };
uniform float u_environment_scale;

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  if (texelFetch(t_depth, pixel, 0).x <= 0.0) {
    imageStore(o_marks, pixel, uvec4(0u));
    return;
  }
  vec3 radiance = vec3(0.0);
  bool known = false;
#if BAKED
  TransferPoint p = load_transfer_point(pixel);
  known = p.known;
  if (known) radiance = transfer_radiance(p) * u_environment_scale;
  if (any(isnan(radiance)) || any(isinf(radiance))) radiance = vec3(0.0);
#endif
  atomicAdd(b_visible, 1u);
  if (known) atomicAdd(b_shaded, 1u);
  imageStore(o_marks, pixel, uvec4(known ? 1u : 0u, 0u, 0u, 1u));
  imageStore(o_radiance, pixel, vec4(radiance, 1.0));
}
