// Grid points to pixels: emission, sky, box filter over the samples of a pixel, and the running mean while nothing moves.
// With panes in the scene in two steps, and the panes are drawn between them: STAGE 1 completes the grid's points, STAGE 2 filters
// them. STAGE 0 does both.
layout(local_size_x = 8, local_size_y = 8) in;
#include "shared/frame.glsl"
#include "shared/constants.glsl"
#include "shared/latlong.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
layout(binding = 8) uniform usampler2D t_surface;
layout(binding = 9) uniform sampler2D t_depth;
#if STAGE == 1
layout(binding = 0, rgba32f) uniform image2D io_radiance;
#else
layout(binding = 24) uniform sampler2D t_radiance;
layout(binding = 0, rgba32f) uniform image2D io_picture;
uniform float u_blend;  // weight of this frame in the mean
#endif

#include "shading/environment_bilinear.glsl"

#if STAGE < 2
/// Alpha 0 where only the sky is seen.
vec4 complete(ivec2 p, vec3 shaded) {
  if (texelFetch(t_depth, p, 0).x > 0.0) {
    uvec4 g = texelFetch(t_surface, p, 0);
    vec3 emission = unpack_rgb9e5(g.w, kEmissionBias);
    if ((material_words(int(g.z >> 16u), 6).x & kMaterialUnlit) != 0u) {
      vec4 y = unpackUnorm4x8(g.y);
      shaded = y.rgb * y.rgb;
    }
    return vec4(shaded + emission, 1.0);
  }
  vec3 d = environment_from_world(normalize(view_ray(p)));
  return vec4(environment_bilinear(d) * u_frame.environment.z, 0.0);
}
#endif

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
#if STAGE == 1
  if (any(greaterThanEqual(pixel, u_frame.size.xy))) return;
#ifdef REFLECTED
  if (texelFetch(t_ray_direction, pixel, 0).w <= 0.0) {
    imageStore(io_radiance, pixel, vec4(0.0));
    return;
  }
#endif
  imageStore(io_radiance, pixel, complete(pixel, imageLoad(io_radiance, pixel).rgb));
#else
  if (any(greaterThanEqual(pixel, imageSize(io_picture)))) return;
  int side = u_frame.size.z;
  vec4 sum = vec4(0.0);
  for (int k = 0; k < side * side; ++k) {
    ivec2 p = pixel * side + ivec2(k % side, k / side);
    vec4 value = texelFetch(t_radiance, p, 0);
#if STAGE == 0
    value = complete(p, value.rgb);
#endif
    sum += value;
  }
  sum /= float(side * side);
  // As an increment: mix() multiplies the mean by 1 - 1/n, whose rounding adds up to 0.2 % over a million frames.
  if (u_blend < 1.0) {
    vec4 before = imageLoad(io_picture, pixel);
    sum = before + (sum - before) * u_blend;
  }
  imageStore(io_picture, pixel, sum);
#endif
}
