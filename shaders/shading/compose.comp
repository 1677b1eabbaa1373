// Grid points to pixels: emission, indirect light, box filter over the points of a pixel, and the running mean while nothing moves.
// STAGE 0: one point a pixel, from the grid to the picture in one step. With several points a pixel, or panes that are drawn in between, two
// steps: STAGE 1 completes the points of surfaces in their image, STAGE 2 filters all points. With lists of quads (bandwidth/quads.comp), three
// stages replace STAGE 1: STAGE 3 computes one value for each plain quad and stores it at its last point, which no other quad reads; STAGE 1 with
// QUADS completes the points of the other quads; STAGE 4 copies a plain quad's value to all its points. sky.comp draws points that show the sky,
// except in reflected pictures. TEXTURES: radiance is stored without the base factor. INDIRECT: adds indirect light, from one bake (1) or
// interpolated between two (2). SHADOWS: adds light that rays have shadowed (render/shadow_rays). PANES: draws recorded panes in the same step.
// GLOSSY: adds the change of indirect light by glossy reflections; with REFLECTED, the rays are those of glossy surfaces.
// TINT: panes on the way of reflected rays leave a share of the light.
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#if STAGE == 2
layout(local_size_x = 8, local_size_y = 8) in;
#else
layout(local_size_x = 64) in;
#include "shared/tiles.glsl"
#endif
#include "shared/constants.glsl"
#include "shared/latlong.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
#if STAGE == 1 || STAGE >= 3
layout(binding = kImageRadiance, rgba32f) uniform image2D io_radiance;
#else
layout(binding = kUnitRadiance) uniform sampler2D t_radiance;
layout(binding = kImagePicture, rgba32f) uniform image2D io_picture;
uniform float u_blend;  // weight of this frame in the mean
#endif

#if PANES || defined(REFLECTED)
#include "shading/environment_bilinear.glsl"
#endif
#ifdef QUADS
#include "bandwidth/quads.glsl"
#endif
#if STAGE < 2 || STAGE == 3
#if TEXTURES
#include "shared/luminance.glsl"
#include "bandwidth/base_factor.glsl"
#endif
#if INDIRECT
layout(binding = kUnitIndirectLight) uniform sampler2D t_indirect_light;
#if INDIRECT == 2
layout(binding = kUnitLaterLight) uniform sampler2D t_later_light;
uniform float u_later;  // weight of the later one
#endif
#endif
#if GLOSSY && !defined(REFLECTED)
layout(binding = kUnitGlossy) uniform sampler2D t_glossy;
#endif
#if SHADOWS
layout(binding = kUnitShadowLight) uniform sampler2D t_shadow_light;
#endif
#if (SHADOWS || GLOSSY) && !defined(REFLECTED)
uniform float u_least;  // below 0: a share of a mean, which rays may make negative by itself
#endif
vec3 complete(ivec2 p, vec4 stored) {
  vec3 shaded = stored.rgb;
  uvec4 g = texelFetch(t_surface, p, 0);
  uint flags = material_words(int(g.z >> 16u), 6).x;
#if TEXTURES
  shaded *= base_factor(stored, g, flags);
#endif
#if SHADOWS
  shaded += texelFetch(t_shadow_light, p, 0).rgb;
#ifndef REFLECTED
  shaded = max(shaded, u_least);  // there the mean over the frames is
#endif
#endif
#if INDIRECT || GLOSSY
  vec3 indirect = vec3(0.0);
#if INDIRECT
  indirect = texelFetch(t_indirect_light, p, 0).rgb;
#if INDIRECT == 2
  indirect = mix(indirect, texelFetch(t_later_light, p, 0).rgb, u_later);
#endif
#endif
#if GLOSSY && !defined(REFLECTED)
  indirect = max(indirect + texelFetch(t_glossy, p, 0).rgb, u_least);
#endif
  shaded += indirect;
#endif
  if ((flags & kMaterialUnlit) != 0u) {
    shaded = unpack_base_color(g.y);
  }
#if GLOSSY && defined(REFLECTED)
  return shaded;  // emissive surfaces light opaque ones as lights already
#else
  return shaded + unpack_emission_share(g.w) * material_floats(int(g.z >> 16u), 2).rgb;
#endif
}
#endif

#if STAGE == 0 || STAGE == 2
/// As an increment: mix() multiplies the mean by 1 - 1/n, whose rounding adds up to 0.2 % over a million frames.
void store_blended(ivec2 pixel, vec4 value) {
  if (u_blend < 1.0) {
    vec4 before = imageLoad(io_picture, pixel);
    value = before + (value - before) * u_blend;
  }
  imageStore(io_picture, pixel, value);
}
#endif

#ifdef REFLECTED
#if GLOSSY
/// The surface itself is already shaded with the light of the sky.
vec3 ray_end(ivec2 pixel) { return vec3(0.0); }
#else
#include "shading/sky.glsl"
vec3 ray_end(ivec2 pixel) { return sky_radiance(pixel); }
#endif
#if LAYERS
layout(std430, binding = kBufferOctreeLayers) readonly buffer Layers { uvec4 b_layers[]; };  // radiance
layout(binding = kUnitOctreeLayers) uniform usampler2D t_layers;
/// Adds the octree cells with BRDFs in front of what the ray ends at.
vec4 with_layers(ivec2 pixel, vec4 behind) {
  uvec4 list = texelFetch(t_layers, pixel, 0);
  float through = unpackHalf2x16(list.y >> 16u).x;
  vec4 sum = vec4(behind.rgb * through, 1.0 - (1.0 - behind.w) * through);
  for (uint k = 0u; k < (list.y & 65535u); ++k) sum.rgb += uintBitsToFloat(b_layers[list.x + k].xyz);
  return sum;
}
#endif
#if TINT
layout(binding = kUnitPaneTint) uniform sampler2D t_pane_tint;
#endif
uniform float u_least;  // below 0: a share of a mean, which may be negative by itself
void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  vec4 value = vec4(0.0);
  float reflector = texelFetch(t_ray_direction, pixel, 0).w;
  if (reflector < 0.0) value = vec4(texelFetch(t_ray_origin, pixel, 0).xyz, 0.0);  // not followed: rays.comp says why
  if (reflector > 0.0) {
    bool surface = texelFetch(t_depth, pixel, 0).x > 0.0;
    value = surface ? vec4(complete(pixel, imageLoad(io_radiance, pixel)), 1.0) : vec4(ray_end(pixel), 0.0);
#if LAYERS
    value = with_layers(pixel, value);
#endif
#if TINT
    value.rgb *= texelFetch(t_pane_tint, pixel, 0).rgb;
#endif
  }
  imageStore(io_radiance, pixel, max(value, u_least));
}
#elif STAGE == 2
void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, imageSize(io_picture)))) return;
  int side = u_frame.size.z;
  vec4 sum = vec4(0.0);
  for (int k = 0; k < side * side; ++k) sum += texelFetch(t_radiance, pixel * side + ivec2(k % side, k / side), 0);
  store_blended(pixel, sum / float(side * side));
}
#elif STAGE == 4
void main() {
  ivec2 first = listed_quad(int(linear_id()));
  if (first.x < 0) return;
  vec4 value = imageLoad(io_radiance, first + 1);
  imageStore(io_radiance, first, value);
  imageStore(io_radiance, first + ivec2(1, 0), value);
  imageStore(io_radiance, first + ivec2(0, 1), value);
}
#else
#if PANES
#include "glass/kept.glsl"
#else
vec3 through_panes(ivec2 pixel, vec3 behind) { return behind; }
#endif
#if STAGE == 3
uniform int u_least_points;  // how many of a quad's four points are completed and averaged; all four where there is a texture

void main() {
  ivec2 first = listed_quad(int(linear_id()));
  if (first.x < 0) return;
  vec4 near = imageLoad(io_radiance, first), right = imageLoad(io_radiance, first + ivec2(2, 0));
  vec4 below = imageLoad(io_radiance, first + ivec2(0, 2)), far = imageLoad(io_radiance, first + 2);
  int points = u_least_points;
#if TEXTURES
  points = has_textures(int(texelFetch(t_surface, first, 0).z >> 16u)) ? 4 : points;
#endif
  vec3 sum = vec3(0.0);
  int k = 0;
  do {  // tested at the end, as in integrate.glsl
    ivec2 step = ivec2(k & 1, k >> 1);
    vec2 at = points == 1 ? vec2(0.25) : 0.5 * vec2(step);
    vec4 stored = mix(mix(near, right, at.x), mix(below, far, at.x), at.y);
    sum += through_panes(first + step, complete(first + step, stored));
  } while (++k < points);
  imageStore(io_radiance, first + 1, vec4(sum / float(points), 1.0));
}
#else
void main() {
#ifdef QUADS
  int id = int(linear_id());
  ivec2 pixel = listed_quad(id >> 2);
  if (pixel.x >= 0) pixel += ivec2(id & 1, (id >> 1) & 1);
#else
  ivec2 pixel = tile_point();
#endif
  if (pixel.x < 0 || texelFetch(t_depth, pixel, 0).x <= 0.0) return;
#if STAGE == 0
  store_blended(pixel, vec4(through_panes(pixel, complete(pixel, texelFetch(t_radiance, pixel, 0))), 1.0));
#else
  imageStore(io_radiance, pixel, vec4(through_panes(pixel, complete(pixel, imageLoad(io_radiance, pixel))), 1.0));
#endif
}
#endif
#endif
