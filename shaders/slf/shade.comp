// Looks up the surface light field at every point of a layer.
layout(local_size_x = 64) in;
#ifndef BAKED
#define BAKED 1
#endif
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/parabolic.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "slf/light_field.glsl"
layout(binding = kImageRadiance, rgba32f) uniform writeonly image2D o_radiance;
layout(binding = kImageLookupMarks, rgba8ui) uniform writeonly uimage2D o_marks;  // shaded, level, log2 of samples, 1 if visible
#if !BAKED
uniform float u_preview_cdm2;  // until the bake is there: light from the eye, on the surfaces' own colours
#endif
layout(std430, binding = kBufferCounters) buffer Counters { uint b_visible, b_shaded; };

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  if (texelFetch(t_depth, pixel, 0).x <= 0.0) {
    imageStore(o_marks, pixel, uvec4(0u));
    return;
  }
#if BAKED
  FieldPoint p = load_field_point(pixel);
  imageStore(o_marks, pixel, uvec4(p.known ? 1u : 0u, 0u, 0u, 1u));
  atomicAdd(b_visible, 1u);
  if (p.known) atomicAdd(b_shaded, 1u);
  vec3 radiance = p.known ? field_radiance(p) : vec3(0.0);
  if (any(isnan(radiance)) || any(isinf(radiance))) radiance = vec3(0.0);
  imageStore(o_radiance, pixel, vec4(radiance, 1.0));
#else
  imageStore(o_marks, pixel, uvec4(0u, 0u, 0u, 1u));
  atomicAdd(b_visible, 1u);
  Surface s = unpack_surface(texelFetch(t_surface, pixel, 0));
  float facing = abs(dot(s.normal, normalize(view_ray(pixel))));
  const float kGloss = 0.05;  // without it black leather has no shape
  imageStore(o_radiance, pixel, vec4((s.base_color + kGloss) * (u_preview_cdm2 * (0.3 + 0.7 * facing)), 1.0));
#endif
}
