// Per 2 x 2 quad: pools the prediction over neighbours on the same surface, and carries the bandwidth through the bounce to cycles per
// pixel along both screen axes and their correlation. One invocation handles a block of 2 x 2 quads, because their 5 x 5 windows share most texels.
// FIRST_ONLY: only the first quad of every other block is predicted (classify.comp).
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/bandwidth.glsl"
#include "shared/screen_curvature.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
layout(binding = kUnitScreenCurvature) uniform usampler2D t_screen_curvature;     // of shared/screen_curvature.glsl
layout(binding = kUnitEnergy) uniform sampler2D t_energy;  // predict.comp
#if TEXTURE_BANDWIDTH
layout(binding = kUnitTextureBandwidthMap) uniform sampler2D t_texture_bandwidth_map;
#endif
#if NEAR
layout(binding = kUnitNear) uniform sampler2D t_near;
#endif
layout(binding = kImageBandwidth, rgba32f) uniform writeonly image2D o_bandwidth;  // larger nu (cycles/px), mean radiance, standard deviation of one sample, 1 if visible
layout(binding = kImageAxes, rgba16f) uniform writeonly image2D o_axes;  // nu_x, nu_y (cycles/px), their correlation (screen_bandwidth), nu_theta (cycles/rad)
#if COARSE
layout(binding = kImageFirstCoarse, rgba32f) uniform writeonly image2D o_coarse;  // the pyramid's next level, as pyramid.comp makes it
#endif

/// The first visible point of a quad represents it, as in classify.comp; x < 0 for none.
ivec2 visible_point(ivec2 quad) {
  ivec2 pixel = ivec2(-1);
  for (int k = 0; k < 4; ++k) {
    int j = (k + quad.x + 2 * quad.y) & 3;
    ivec2 q = min(2 * quad + ivec2(j & 1, j >> 1), u_frame.size.xy - 1);
    if (pixel.x < 0 && texelFetch(t_depth, q, 0).x > 0.0) pixel = q;
  }
  return pixel;
}

/// Pooled sums of a quad: sum w nu, sum w, sum t^2, number of quads.
struct Pool {
  vec4 sums;
#if NEAR
  vec4 near;
#endif
};
const float kNeighbour = 0.6;  // weight of another quad

/// Value of o_bandwidth for a quad, from its pooled sums; also writes o_axes.
vec4 find_bandwidth(ivec2 quad, ivec2 pixel, Pool pool) {
  float count = pool.sums.w;
  // Nothing was predicted for a surface this small: a very large bandwidth makes every point of it be shaded.
  float nu_theta = count <= 0.0 ? 1e4 : pool.sums.x / max(pool.sums.y, 1e-20);
  count = max(count, 1e-6);
  // The terms contain balance weights for the prediction's own sample counts; n Var(sum of terms / n) does not depend on them.
  float deviation = sqrt(max(pool.sums.z / count, 0.0) * float(PREDICTION_SAMPLES));
  ScreenCurvature bend = unpack_screen_curvature(texelFetch(t_screen_curvature, quad, 0));
  float nu_surface = 0.0, light = 0.0;
#if NEAR
  // Baked visibility and near lights vary over the surface.
  nu_surface += pool.near.x / max(pool.sums.y, 1e-20);
  if (pool.near.w > 0.0) {
    light = pool.near.y;
    deviation = sqrt(deviation * deviation + pool.near.z / pool.near.w);
  }
#endif
  float radiance = max(pool.sums.y - light, 0.0) / count;
#if NEAR
  radiance += light / max(pool.near.w, 1e-6);
#endif
#if TEXTURE_BANDWIDTH
  nu_surface += texelFetch(t_texture_bandwidth_map, pixel, 0).x;
#endif
  float scale = max(u_frame.environment.z, 1e-12);
  vec3 nu = screen_bandwidth(bend, nu_theta, nu_surface, pixel_angle());
  // Half floats end at 65504, and infinity would turn the weights of upsampling into NaN.
  imageStore(o_axes, quad, min(vec4(nu, nu_theta), vec4(65000.0)));
  return vec4(max(nu.x, nu.y), radiance * scale, deviation * scale, 1.0);
}

void main() {
  ivec2 quads = (u_frame.size.xy + 1) / 2;
  int id = int(linear_id());
  ivec2 tile = tile_of(id, 2);
  if (tile.x < 0) return;
  ivec2 corner = kTile / 2 * tile + 2 * ivec2(id & 1, (id >> 1) & 1);
  ivec2 pixels[4];
  float own[4];  // 1 + material
  Pool pools[4];
  for (int k = 0; k < 4; ++k) {
    ivec2 quad = corner + ivec2(k & 1, k >> 1);
    pixels[k] = all(lessThan(quad, quads)) ? visible_point(quad) : ivec2(-1);
    own[k] = float((texelFetch(t_surface, max(pixels[k], ivec2(0)), 0).z >> 16u) + 1u);
    pools[k].sums = vec4(0.0);
#if NEAR
    pools[k].near = vec4(0.0);
#endif
  }
  const int kStep = 1 + FIRST_ONLY;
  int row = -2;
  do {  // tested at the end, as in integrate.glsl
    for (int column = -2; column <= 3; column += kStep) {
      ivec2 q = clamp(corner + ivec2(column, row), ivec2(0), quads - 1);
      vec4 e = texelFetch(t_energy, q, 0);
#if NEAR
      vec4 near = texelFetch(t_near, q, 0);
#endif
      for (int k = 0; k < 4; ++k) {
        int dx = column - (k & 1), dy = row - (k >> 1);
        if (abs(dx) > 2) continue;
        float weight = dx == 0 && dy == 0 ? 1.0 : kNeighbour;
        weight = e.w == own[k] && abs(dy) <= 2 ? weight : 0.0;
        pools[k].sums += weight * vec4(e.xyz, 1.0);
#if NEAR
        pools[k].near += weight * near;
#endif
      }
    }
    row += kStep;
  } while (row <= 3);
  vec4 coarse = vec4(0.0);
  for (int k = 0; k < 4; ++k) {
    ivec2 quad = corner + ivec2(k & 1, k >> 1);
    if (any(greaterThanEqual(quad, quads))) continue;
    vec4 v = vec4(0.0);
    if (pixels[k].x >= 0)
      v = find_bandwidth(quad, pixels[k], pools[k]);
    else
      imageStore(o_axes, quad, vec4(0.0));
    imageStore(o_bandwidth, quad, v);
    coarse = vec4(max(coarse.x, v.x), coarse.yz + v.yz, coarse.w + v.w);
  }
#if COARSE
  imageStore(o_coarse, corner / 2, vec4(coarse.x, coarse.w > 0.0 ? coarse.yz / coarse.w : vec2(0.0), coarse.w));
#endif
}
