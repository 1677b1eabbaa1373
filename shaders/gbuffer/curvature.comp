// Per 2 x 2 quad: curvature and footprint of the surface along the screen axes, from the G-buffer, so that geometry may change every frame.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/bandwidth.glsl"
#include "shared/screen_curvature.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
layout(binding = kImageScreenCurvature, rgba32ui) uniform writeonly uimage2D o_screen_curvature;  // of shared/screen_curvature.glsl

struct Sample {
  vec3 position, normal;
  int material;
  bool valid;
};

Sample load_sample(ivec2 pixel) {
  Sample s;
  pixel = clamp(pixel, ivec2(0), u_frame.size.xy - 1);
  float depth = texelFetch(t_depth, pixel, 0).x;
  uvec4 g = texelFetch(t_surface, pixel, 0);
  s.valid = depth > 0.0;
  s.position = position_through(vec2(pixel) + 0.5, depth);
  s.normal = unpack_normal(g.x);
  s.material = int(g.z >> 16u);
  return s;
}

bool same_surface(Sample a, Sample b, float tolerance_m) {
  return b.valid && a.material == b.material && abs(dot(b.position - a.position, a.normal)) < tolerance_m &&
         dot(a.normal, b.normal) > 0.5;
}

/// Change of position and normal over one pixel along a screen axis, from the side where the normal changes less.
struct Along {
  vec3 step_m, normal_change;
};

const float kLeastCosine = 0.02;  // of grazing views

Along along_axis(Sample c, ivec2 pixel, ivec2 axis, float pixel_m) {
  float tangent_m = pixel_m / max(dot(c.normal, -normalize(ray_through(vec2(pixel) + 0.5).direction)), kLeastCosine);
  // Without a neighbour: on the tangent plane.
  EyeRay ray = ray_through(vec2(pixel + axis) + 0.5);
  float along_ray = dot(c.position - ray.origin, c.normal) / min(dot(ray.direction, c.normal), -kLeastCosine * length(ray.direction));
  Along best = Along(ray.origin + ray.direction * along_ray - c.position, vec3(0.0));
  float best_change = 1e30;
  for (int side = -1; side <= 1; side += 2) {
    ivec2 q = pixel + side * axis;
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, u_frame.size.xy))) continue;
    Sample s = load_sample(q);
    if (!same_surface(c, s, 4.0 * tangent_m)) continue;
    // The chord between unit normals is precise for small angles, where the arc cosine of their product is not.
    vec3 change = s.normal - c.normal;
    if (length(change) < best_change) {
      best_change = length(change);
      best = Along(float(side) * (s.position - c.position), float(side) * change);
    }
  }
  return best;
}

void main() {
  ivec2 quad = tile_quad();
  if (quad.x < 0) return;
  ivec2 pixel = ivec2(-1);
  for (int k = 0; k < 4; ++k) {
    int j = (k + quad.x + 2 * quad.y) & 3;
    ivec2 q = min(2 * quad + ivec2(j & 1, j >> 1), u_frame.size.xy - 1);
    if (pixel.x < 0 && texelFetch(t_depth, q, 0).x > 0.0) pixel = q;
  }
  if (pixel.x < 0) {
    imageStore(o_screen_curvature, quad, uvec4(0u));
  } else {
    Sample c = load_sample(pixel);
    float pixel_m = pixel_width(texelFetch(t_depth, pixel, 0).x);
    Along x = along_axis(c, pixel, ivec2(1, 0), pixel_m), y = along_axis(c, pixel, ivec2(0, 1), pixel_m);
    imageStore(o_screen_curvature, quad, pack_screen_curvature(x.step_m, y.step_m, x.normal_change, y.normal_change));
  }
}
