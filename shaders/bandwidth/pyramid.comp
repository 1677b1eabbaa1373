// One level of the bandwidth pyramid: maximum of the bandwidth, so that interpolation does not miss it; means of radiance and deviation.
layout(local_size_x = 8, local_size_y = 8) in;
#include "shared/bindings.glsl"
layout(binding = kUnitPyramid) uniform sampler2D t_fine;
layout(binding = kImageCoarse, rgba32f) uniform writeonly image2D o_coarse;
uniform int u_level;  // of t_fine
void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  ivec2 fine = textureSize(t_fine, u_level);
  if (any(greaterThanEqual(p, imageSize(o_coarse)))) return;
  // A third row or column only at the odd end of a level.
  ivec2 end = min(2 * p + 2, fine);
  end += ivec2(end.x == fine.x - 1 ? 1 : 0, end.y == fine.y - 1 ? 1 : 0);
  vec4 r = vec4(0.0);
  vec2 sum = vec2(0.0);
  ivec2 q = 2 * p;
  do {  // tested at the end, as in shading/integrate.glsl
    q.x = 2 * p.x;
    do {
      vec4 v = texelFetch(t_fine, q, u_level);
      r.x = max(r.x, v.x);
      sum += v.yz * v.w;
      r.w += v.w;
    } while (++q.x < end.x);
  } while (++q.y < end.y);
  imageStore(o_coarse, p, vec4(r.x, r.w > 0.0 ? sum / r.w : vec2(0.0), r.w));
}
