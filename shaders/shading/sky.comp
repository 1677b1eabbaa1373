// The points that show the sky. Alpha 0 says so.
layout(local_size_x = 64) in;
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/latlong.glsl"
#include "shared/rgb9e5.glsl"
#include "shading/sky.glsl"
layout(binding = 9) uniform sampler2D t_depth;
layout(binding = 0, rgba32f) uniform writeonly image2D o_radiance;

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x >= 0 && texelFetch(t_depth, pixel, 0).x <= 0.0) imageStore(o_radiance, pixel, vec4(sky_radiance(pixel), 0.0));
}
