// Where several shading modes share a frame: copies the points of one layer into the frame's radiance and depth.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
layout(binding = kUnitDepth) uniform sampler2D t_depth;  // of the layer
layout(binding = kUnitRadiance) uniform sampler2D t_radiance;
layout(binding = kImageRadiance, rgba32f) uniform writeonly image2D o_radiance;
layout(binding = kImageDepth, r32f) uniform writeonly image2D o_depth;

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  float depth = texelFetch(t_depth, pixel, 0).x;
  if (depth <= 0.0) return;
  imageStore(o_radiance, pixel, texelFetch(t_radiance, pixel, 0));
  imageStore(o_depth, pixel, vec4(depth));
}
