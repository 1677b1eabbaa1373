// What mirrored rays meet before their hits, one layer of blended surfaces at a time. ADD 0: gives its image the rays, with these surfaces as
// their hits; 1: adds its light, which was shaded since, to the picture.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shading/linear_id.glsl"
/// MirroredLayer of render/reflections/mirrored_layer.h.
struct Met {
  uint pixel, triangle;
  float red, green, blue;
};
layout(std430, binding = kBufferMirroredLayer) readonly buffer Layer { Met b_met[]; };
uniform int u_count;
#if ADD
layout(binding = kUnitRadiance) uniform sampler2D t_radiance;  // of the layer
layout(binding = kImageRadiance, rgba32f) uniform image2D io_radiance;
#else
layout(binding = kUnitRayOrigin) uniform sampler2D t_ray_origin;
layout(binding = kUnitRayDirection) uniform sampler2D t_ray_direction;
layout(binding = kImageRayOrigin, rgba32f) uniform writeonly image2D o_origin;
layout(binding = kImageRayDirection, rgba32f) uniform writeonly image2D o_direction;
layout(binding = kImageLayerTriangle, r32ui) uniform writeonly uimage2D o_triangle;
layout(binding = kImageLayerTint, rgba16) uniform writeonly image2D o_tint;
#endif

void main() {
  int id = int(linear_id());
  if (id >= u_count) return;
  Met met = b_met[id];
#if ADD
  int width = imageSize(io_radiance).x;
#else
  int width = imageSize(o_origin).x;
#endif
  ivec2 pixel = ivec2(int(met.pixel) % width, int(met.pixel) / width);
#if ADD
  vec4 shown = imageLoad(io_radiance, pixel);
  imageStore(io_radiance, pixel, vec4(shown.rgb + texelFetch(t_radiance, pixel, 0).rgb, shown.w));
#else
  imageStore(o_origin, pixel, texelFetch(t_ray_origin, pixel, 0));
  imageStore(o_direction, pixel, texelFetch(t_ray_direction, pixel, 0));
  imageStore(o_triangle, pixel, uvec4(met.triangle + 1u));
  imageStore(o_tint, pixel, vec4(met.red, met.green, met.blue, 1.0));
#endif
}
