// Resets the accumulated results of the points whose material was replaced, while nothing moves.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/material_table.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kImageForgottenMean, rgba32f) uniform writeonly image2D o_mean;
layout(binding = kImageForgottenSpread) uniform writeonly image2D o_spread;
layout(binding = kImageForgottenDeviation, r32f) uniform writeonly image2D o_deviation;
layout(binding = kImageForgottenResidual, r32f) uniform writeonly image2D o_residual;

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  if ((material_words(int(texelFetch(t_surface, pixel, 0).z >> 16u), 6).x & kMaterialReplaced) == 0u) return;
  imageStore(o_mean, pixel, vec4(0.0));
  imageStore(o_spread, pixel, vec4(0.0));
  imageStore(o_deviation, pixel, vec4(0.0));
  imageStore(o_residual, pixel, vec4(-1.0));
}
