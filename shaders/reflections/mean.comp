// The mean over the frames at rest of what mirrored rays show, one invocation a pixel of the tiles that have rays.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
layout(binding = kImageRadiance, rgba32f) uniform image2D io_radiance;
layout(binding = kImageMean, rgba32f) uniform image2D io_mean;
uniform float u_blend;  // weight of this frame

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  vec4 value = imageLoad(io_radiance, pixel), before = u_blend < 1.0 ? imageLoad(io_mean, pixel) : vec4(0.0);
  value = before + (value - before) * u_blend;
  imageStore(io_mean, pixel, value);
  imageStore(io_radiance, pixel, max(value, 0.0));
}
