// Rays of the eye to the blended surfaces of one layer, for shading as hits of mirrored rays.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shading/linear_id.glsl"
#include "shared/frame.glsl"
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
layout(binding = kImageRayOrigin, rgba32f) uniform writeonly image2D o_origin;        // m; w: depth, 0 for no ray
layout(binding = kImageRayDirection, rgba32f) uniform writeonly image2D o_direction;  // unit; w: number, 0 for no ray
/// Reflectors have smaller numbers.
const float kNumber = 33.0;

void main() {
  int id = int(linear_id());
  ivec2 size = imageSize(o_origin), pixel = ivec2(id % size.x, id / size.x);
  if (pixel.y >= size.y) return;
  bool any_triangle = texelFetch(t_triangle, pixel, 0).x != 0u;
  imageStore(o_origin, pixel, any_triangle ? vec4(view_origin(pixel), 1.0) : vec4(0.0));
  imageStore(o_direction, pixel, any_triangle ? vec4(normalize(view_ray(pixel)), kNumber) : vec4(0.0));
}
