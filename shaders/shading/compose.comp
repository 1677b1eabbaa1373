// Grid points to pixels: emission, sky, box filter over the samples of a pixel, and the running mean while nothing moves.
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
layout(binding = 14) uniform usamplerBuffer t_environment;
layout(binding = 24) uniform sampler2D t_radiance;
layout(binding = 0, rgba32f) uniform image2D io_picture;
uniform float u_blend;  // weight of this frame in the mean

vec3 environment_bilinear(vec3 d) {
  ivec2 size = u_frame.environment_size.xy;
  vec2 uv = latlong_uv_from_direction(d) * vec2(size) - 0.5;
  ivec2 p = ivec2(floor(uv));
  vec2 f = uv - vec2(p);
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 4; ++k) {
    ivec2 q = p + ivec2(k & 1, k >> 1);
    q.x = (q.x + size.x) % size.x;
    q.y = clamp(q.y, 0, size.y - 1);
    float w = ((k & 1) != 0 ? f.x : 1.0 - f.x) * ((k >> 1) != 0 ? f.y : 1.0 - f.y);
    sum += w * unpack_rgb9e5(texelFetch(t_environment, q.y * size.x + q.x).x, u_frame.environment_size.z);
  }
  return sum;
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, imageSize(io_picture)))) return;
  int side = u_frame.size.z;
  vec4 sum = vec4(0.0);
  for (int k = 0; k < side * side; ++k) {
    ivec2 p = pixel * side + ivec2(k % side, k / side);
    if (texelFetch(t_depth, p, 0).x > 0.0) {
      uvec4 g = texelFetch(t_surface, p, 0);
      vec3 emission = unpack_rgb9e5(g.w, kEmissionBias);
      vec3 shaded = texelFetch(t_radiance, p, 0).rgb;
      if ((material_words(int(g.z >> 16u), 6).x & kMaterialUnlit) != 0u) {
        vec4 y = unpackUnorm4x8(g.y);
        shaded = y.rgb * y.rgb;
      }
      sum += vec4(shaded + emission, 1.0);
    } else {
      vec3 d = environment_from_world(normalize(ray_through(vec2(p) + 0.5)));
      sum += vec4(environment_bilinear(d) * u_frame.environment.z, 0.0);
    }
  }
  sum /= float(side * side);
  if (u_blend < 1.0) sum = mix(imageLoad(io_picture, pixel), sum, u_blend);
  imageStore(io_picture, pixel, sum);
}
