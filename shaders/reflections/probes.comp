// Copies the rays of every u_spacing-th pixel of a reflected picture into a small one.
layout(local_size_x = 8, local_size_y = 8) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
layout(binding = kUnitRayOrigin) uniform sampler2D t_origin;
layout(binding = kUnitRayDirection) uniform sampler2D t_direction;
layout(binding = kImageRayOrigin, rgba32f) uniform writeonly image2D o_origin;
layout(binding = kImageRayDirection, rgba32f) uniform writeonly image2D o_direction;
uniform int u_spacing;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, u_frame.size.xy))) return;
  ivec2 from = min(u_spacing * pixel + u_spacing / 2, textureSize(t_origin, 0) - 1);
  imageStore(o_origin, pixel, texelFetch(t_origin, from, 0));
  imageStore(o_direction, pixel, texelFetch(t_direction, from, 0));
}
