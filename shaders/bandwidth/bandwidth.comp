// Per 2 x 2 quad: pools the prediction over neighbours of the same surface, and carries the bandwidth through the bounce to cycles per
// pixel along both screen axes.
layout(local_size_x = 64) in;
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/bandwidth.glsl"
layout(binding = 8) uniform usampler2D t_surface;
layout(binding = 9) uniform sampler2D t_depth;
layout(binding = 31) uniform sampler2D t_bend;  // along the screen axes: curvature (1/m), metres a pixel; x, then y
layout(binding = 18) uniform sampler2D t_energy;
layout(binding = 19) uniform sampler2D t_moments;
#if TEXTURE_BANDWIDTH
layout(binding = 20) uniform sampler2D t_texture_bandwidth_map;
#endif
#if NEAR
layout(binding = 28) uniform sampler2D t_near;
#endif
layout(binding = 0, rgba32f) uniform writeonly image2D o_bandwidth;  // larger nu (cycles/px), mean radiance, standard deviation of one sample, 1 if visible
layout(binding = 1, rgba16f) uniform writeonly image2D o_curvature;  // nu_x, nu_y (cycles/px), curvature (1/m), nu_theta (cycles/rad)

void find_bandwidth(ivec2 quad, ivec2 quads, ivec2 pixel) {
  vec4 energy = vec4(0.0), moments = vec4(0.0), near = vec4(0.0);
  float own = float((texelFetch(t_surface, pixel, 0).z >> 16u) + 1u);
  for (int k = 0; k < 25; ++k) {
    ivec2 q = clamp(quad + ivec2(k % 5, k / 5) - 2, ivec2(0), quads - 1);
    vec4 m = texelFetch(t_moments, q, 0);
    if (m.w != own) continue;
    float w = k == 12 ? 1.0 : 0.6;
    energy += w * texelFetch(t_energy, q, 0);
    moments += w * vec4(m.xyz, float(PREDICTION_SAMPLES) - m.z);
#if NEAR
    near += w * texelFetch(t_near, q, 0);
#endif
  }
  // Nothing was predicted for a surface this small: it is shaded itself.
  bool unknown = moments.z + moments.w <= 0.0;
  float nu_theta = unknown ? 1e4 : energy.x / max(energy.y, 1e-20);
  float nb = max(moments.z, 1.0), ne = max(moments.w, 1.0);
  // Terms carry the balance weights for the prediction's own counts; n Var(sum of terms / n) is free of them.
  float share_b = moments.z / max(moments.z + moments.w, 1.0);
  float per_run = float(PREDICTION_SAMPLES);
  float mean_b = energy.z / nb, mean_e = energy.w / ne;
  float variance_b = max(moments.x / nb, 0.0), variance_e = max(moments.y / ne, 0.0);
  float deviation = per_run * sqrt(max(share_b * variance_b + (1.0 - share_b) * variance_e, 0.0));
  float radiance = (share_b * mean_b + (1.0 - share_b) * mean_e) * per_run;
  vec4 bend = texelFetch(t_bend, quad, 0);
  vec2 kx = bend.xy, ky = bend.zw;
  float nu_surface = 0.0;
#if NEAR
  // Masks and near lights vary over the surface. The lights have one sample for eight of the environment.
  nu_surface += near.x / max(energy.y, 1e-20);
  if (near.w > 0.0) {
    float mean = near.y / near.w;
    radiance += mean;
    deviation = sqrt(deviation * deviation + 8.0 * max(near.z / near.w - mean * mean, 0.0));
  }
#endif
#if TEXTURE_BANDWIDTH
  nu_surface += texelFetch(t_texture_bandwidth_map, pixel, 0).x;
#endif
  float scale = max(u_frame.environment.z, 1e-12);
  float angle = u_frame.forward.w;
  vec2 nu = vec2(bandwidth_one_bounce(nu_theta, kx.x, nu_surface, angle, kx.y),
                 bandwidth_one_bounce(nu_theta, ky.x, nu_surface, angle, ky.y));
  imageStore(o_bandwidth, quad,
             vec4(max(nu.x, nu.y), radiance * scale, deviation * scale, 1.0));
  // Half floats end at 65504, and infinity would turn the weights of upsampling into NaN.
  imageStore(o_curvature, quad, min(vec4(nu, max(kx.x, ky.x), nu_theta), vec4(65000.0)));
}

void main() {
  ivec2 quad = tile_quad();
  ivec2 quads = (u_frame.size.xy + 1) / 2;
  if (quad.x < 0) return;
  ivec2 pixel = ivec2(-1);
  for (int k = 0; k < 4; ++k) {
    int j = (k + quad.x + 2 * quad.y) & 3;
    ivec2 q = min(2 * quad + ivec2(j & 1, j >> 1), u_frame.size.xy - 1);
    if (pixel.x < 0 && texelFetch(t_depth, q, 0).x > 0.0) pixel = q;
  }
  if (pixel.x < 0) {
    imageStore(o_bandwidth, quad, vec4(0.0));
    imageStore(o_curvature, quad, vec4(0.0));
  }
  if (pixel.x >= 0) find_bandwidth(quad, quads, pixel);
}
