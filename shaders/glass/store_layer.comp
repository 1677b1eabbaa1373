// Keeps radiance and depth of one layer of blended surfaces, the radiance as a mean over frames.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#define REFLECTED 1
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
layout(binding = kUnitRadiance) uniform sampler2D t_radiance;
layout(binding = kUnitBlendedDepth) uniform sampler2D t_depth;
layout(binding = kImageBlendedRadiance, rgba32f) uniform image2DArray io_radiance;
layout(binding = kImageBlendedDepths, r32f) uniform writeonly image2DArray o_depths;
uniform int u_layer;
uniform float u_blend;  // weight of this frame

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  float depth = texelFetch(t_depth, pixel, 0).x;
  if (!(depth > 0.0)) return;
  ivec3 at = ivec3(pixel, u_layer);
  vec4 value = texelFetch(t_radiance, pixel, 0), before = u_blend < 1.0 ? imageLoad(io_radiance, at) : vec4(0.0);
  imageStore(io_radiance, at, before + (value - before) * u_blend);
  imageStore(o_depths, at, vec4(depth));
}
