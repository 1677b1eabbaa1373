// Radiance of the points that show the sky, with alpha 0. PANES: recorded panes are drawn over it.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/latlong.glsl"
#include "shared/rgb9e5.glsl"
#include "shading/sky.glsl"
#if PANES
#include "glass/kept.glsl"
#else
vec3 through_panes(ivec2 pixel, vec3 behind) { return behind; }
#endif
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;  // number + 1, 0 for the sky
layout(binding = kImageRadiance, rgba32f) uniform writeonly image2D o_radiance;

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x >= 0 && texelFetch(t_triangle, pixel, 0).x == 0u)
    imageStore(o_radiance, pixel, vec4(through_panes(pixel, sky_radiance(pixel)), 0.0));
}
