// Panes: the background times the transmittance, plus the mirrored environment times the reflectance; both faces with all bounces between
// them (shared/fresnel.glsl). Thin: the transmitted ray is neither refracted nor shifted, and roughness is ignored.
// Blended surfaces show what was shaded for them (render/glass/blended.h). Coverage alpha blends either with what is behind.
// TEXTURES: the item has one of glass/pane_textures.glsl. SURFACE: a share of it is a surface. PANE: a share of it transmits; 2: its faces
// reflect as KHR_materials_specular says. MIRRORED: 1 shows the result of
// a reflector technique, 2 also a second image, 3 is an opaque metal. HATCHED: pixels of low confidence are hatched. All are
// permutations, because software devices run branches that no invocation takes.
// Blending is o_color + o_through * (what is there), so items are drawn back to front.
// RECORD: only panes. Nothing is drawn; each point lists what is needed to draw it under other light (glass/kept.glsl).
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/latlong.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/fresnel.glsl"
#include "shared/pane_faces.glsl"
#include "shading/environment_bilinear.glsl"
#if TEXTURES
#include "shared/texture_table.glsl"
#include "glass/pane_textures.glsl"
uniform float u_normal_scale;
uniform float u_metallic;  // factor of the texture of the metal, which transmits nothing
in vec4 v_uv;              // of both sets
in vec4 v_tangent;
vec4 g_texels[kPaneTextures];  // white where there is no texture
/// In a loop: with a filter for each texture, compilers of software devices need minutes.
void read_textures() {
  for (int k = 0; k < kPaneTextures; ++k) {
    g_texels[k] = vec4(1.0);
    if (u_textures[k] < 0) continue;
    vec2 uv = texture_coordinates(u_textures[k], v_uv.xy, v_uv.zw);
    g_texels[k] = sample_texture(u_textures[k], uv, dFdx(uv), dFdy(uv));
  }
}
#endif
#if SURFACE
layout(binding = kUnitBlendedRadiance) uniform sampler2DArray t_blended_radiance;  // [layer] from front to back, cd/m2
layout(binding = kUnitBlendedDepths) uniform sampler2DArray t_blended_depths;
uniform int u_blended_layers;
#endif
uniform vec4 u_base;      // base colour, alpha
uniform vec3 u_emission;  // cd/m2, of panes
uniform int u_blends;     // 1: alpha is coverage
uniform float u_cutoff;   // alpha below it is cut out; below 0: nothing is
uniform vec2 u_pane;      // share that transmits, refractive index; share 0: a blended surface
uniform vec3 u_layer;     // weights of what the first image shows, of the second image, and of what is no reflection of a pane
uniform vec3 u_absorption;  // of the volume behind a front face, over its thickness
#if PANE == 2
uniform vec4 u_specular;  // specular colour, specular factor
#endif
#if MIRRORED
layout(binding = kUnitRayDirection) uniform sampler2D t_ray_direction;  // w: reflector + 1, below 0 where the ray was not followed
layout(binding = kUnitReflection) uniform sampler2D t_reflection;       // what the nearest reflector of each pixel shows, cd/m2
uniform int u_reflector;                                 // of this item
layout(binding = kUnitLowConfidence) uniform usampler2D t_low_confidence;         // 1 where what is reflected has low confidence
layout(binding = kUnitGhostDirection) uniform sampler2D t_ghost_direction;  // the same of the second image
layout(binding = kUnitGhost) uniform sampler2D t_ghost;
#endif
in vec3 v_position;
in vec3 v_normal;
in vec4 v_color;
in float v_open;
#if RECORD
layout(early_fragment_tests) in;
/// Number of the next layer behind it or 0, uv of the mirrored direction in the unrotated environment, reflectance, transmittance, emission.
struct Layer {
  uvec4 behind_uv_share;
  vec4 share_through, through_added;
};
layout(std430, binding = kBufferPaneLayers) buffer Layers {
  uint b_count, b_unused[3];
  Layer b_layers[];  // number 1 first
};
layout(binding = kImagePaneHeads, r32ui) uniform uimage2D io_heads;
#else
layout(location = 0, index = 0) out vec4 o_color;
layout(location = 0, index = 1) out vec4 o_through;
#endif

#if SURFACE
/// Radiance of the layer that this fragment is of.
vec3 shaded_surface() {
  vec3 radiance = vec3(0.0);
  float nearest = 2.0;
  for (int k = 0; k < u_blended_layers; ++k) {
    ivec3 at = ivec3(gl_FragCoord.xy, k);
    float depth = texelFetch(t_blended_depths, at, 0).x, distance = abs(depth - gl_FragCoord.z);
    if (depth <= 0.0 || distance >= nearest) continue;
    nearest = distance;
    radiance = texelFetch(t_blended_radiance, at, 0).rgb;
  }
  return radiance;
}
#endif

#if MIRRORED
/// Bilinear among the pixels that show this reflector; w: 1, or 0 where another reflector hides it.
vec4 reflected_scene(sampler2D directions, sampler2D radiance) {
  vec2 size = vec2(textureSize(t_reflection, 0));
  vec2 at = gl_FragCoord.xy / vec2(u_frame.size.xy) * size - 0.5;
  ivec2 corner = ivec2(floor(at));
  vec2 f = at - vec2(corner);
  vec4 sum = vec4(0.0);
  for (int k = 0; k < 4; ++k) {
    ivec2 o = ivec2(k & 1, k >> 1), p = clamp(corner + o, ivec2(0), ivec2(size) - 1);
    vec2 w = mix(1.0 - f, f, vec2(o));
    float same = int(abs(texelFetch(directions, p, 0).w)) == u_reflector + 1 ? w.x * w.y + 1e-4 : 0.0;
    sum += same * vec4(texelFetch(radiance, p, 0).rgb, 1.0);
  }
  return sum.w > 0.0 ? vec4(sum.rgb / sum.w, 1.0) : vec4(0.0);
}

/// Thin diagonal lines, an orange filter over reflection and background alike: visible at every exposure, and not mistaken for a reflection.
vec3 hatch_filter() {
  vec2 size = vec2(textureSize(t_low_confidence, 0));
  ivec2 at = clamp(ivec2(gl_FragCoord.xy / vec2(u_frame.size.xy) * size), ivec2(0), ivec2(size) - 1);
  bool low_confidence = texelFetch(t_low_confidence, at, 0).x == 1u && int(texelFetch(t_ray_direction, at, 0).w) == u_reflector + 1;
  float along = mod((gl_FragCoord.x + gl_FragCoord.y) / float(u_frame.size.z), 7.0);
  return low_confidence && along < 1.5 ? vec3(0.8, 0.3, 0.02) : vec3(1.0);
}

/// Reflectance of a smooth metal known by its colour at normal incidence: Fresnel's equations with the real index that has it.
float metal_reflectance(float c, float f0) {
  return fresnel_surface(c, index_of_f0(f0));
}
#endif

/// Base colour, and its coverage; what is cut out is discarded.
vec4 base_color() {
  vec4 base = u_base * v_color;
#if TEXTURES
  base *= g_texels[kPaneBaseColor];
#endif
  if (base.a < u_cutoff) discard;
  return vec4(base.rgb, u_blends > 0 ? base.a : 1.0);
}

/// Towards the viewer, with the material's normal texture.
vec3 shading_normal(vec3 view) {
  vec3 n = normalize(dot(v_normal, v_normal) > 0.0 ? v_normal : view);
#if TEXTURES
  if (u_textures[kPaneNormal] >= 0) n = apply_normal_map(n, v_tangent, g_texels[kPaneNormal].xyz * 2.0 - 1.0, u_normal_scale);
#endif
  return dot(n, view) < 0.0 ? -n : n;
}

#if PANE
PaneFaces faces_of_pane() {
#if PANE == 2
  vec4 specular = u_specular;
#if TEXTURES
  specular.a *= g_texels[kPaneSpecular].a;
  specular.rgb *= g_texels[kPaneSpecularColor].rgb;
#endif
  return pane_faces(u_pane.y, specular.a, specular.rgb);
#else
  return plain_faces(u_pane.y);
#endif
}

PaneShares shares_of_pane(float c, vec3 inside) {
#if PANE == 2
  return pane_shares(c, faces_of_pane(), inside);
#else
  return plain_pane_shares(c, u_pane.y, inside);
#endif
}

#if MIRRORED == 2
/// Of all light that returns from the inside.
vec3 back_reflectance(float c, vec3 inside, vec3 reflected) {
#if PANE == 2
  PaneFaces f = faces_of_pane();
  vec3 front = f.share * vec3(fresnel_surface(c, f.index.x), fresnel_surface(c, f.index.y), fresnel_surface(c, f.index.z));
  return max(reflected - front, 0.0);
#else
  return vec3(fresnel_faces(c, u_pane.y, inside.r).y, fresnel_faces(c, u_pane.y, inside.g).y, fresnel_faces(c, u_pane.y, inside.b).y);
#endif
}
#endif
#endif

void main() {
#if TEXTURES
  read_textures();
#endif
  vec4 base = base_color();
  vec3 view = -normalize(v_position);
  vec3 n = shading_normal(view);
  vec3 emission = u_emission;
#if TEXTURES
  emission *= g_texels[kPaneEmission].rgb;
#endif
  vec3 surface = vec3(0.0);
#if SURFACE
  surface = shaded_surface();
#endif
#if PANE
  float c = dot(n, view), pane = u_pane.x;
  vec3 absorption = gl_FrontFacing ? u_absorption : vec3(0.0);
#if TEXTURES
  pane *= g_texels[kPaneTransmission].r;
  absorption *= g_texels[kPaneThickness].g;
  if (u_textures[kPaneMetallic] >= 0) pane *= 1.0 - u_metallic * g_texels[kPaneMetallic].b;
#endif
  // The refracted ray's way through a slab of that thickness.
  base.rgb = clamp(base.rgb, 0.0, 1.0) * exp(-absorption * inversesqrt(max(1.0 - (1.0 - c * c) / pow(max(u_pane.y, 1.0), 2.0), 1e-6)));
  PaneShares shares = shares_of_pane(c, base.rgb);
#endif
#if RECORD
  uint number = atomicAdd(b_count, 1u) + 1u;
  if (number > uint(b_layers.length())) return;  // the host sees the count
  vec2 mirrored = latlong_uv_from_direction(reflect(-view, n));
  vec3 share = shares.reflected * (v_open * base.a), through = 1.0 - base.a + shares.transmitted * (pane * base.a);
  uint behind = imageAtomicExchange(io_heads, ivec2(gl_FragCoord.xy), number);
  Layer layer;
  layer.behind_uv_share = uvec4(behind, floatBitsToUint(vec3(mirrored, share.r)));
  layer.share_through = vec4(share.gb, through.rg);
  layer.through_added = vec4(through.b, emission * base.a);
  b_layers[number - 1u] = layer;
#else
  o_color = vec4(surface * (u_layer.z * base.a), 0.0);
  o_through = vec4(vec3(1.0 - base.a), 1.0);
#if PANE
  {
    vec3 mirrored = environment_bilinear(environment_from_world(reflect(-view, n))) * (u_frame.environment.z * v_open);
#if MIRRORED
    vec4 scene = reflected_scene(t_ray_direction, t_reflection);
    mirrored = mix(mirrored, scene.rgb, scene.w);
#endif
    vec3 reflected = u_layer.x * shares.reflected * mirrored;
#if MIRRORED == 2
    if (scene.w > 0.0) {
      vec4 second = reflected_scene(t_ghost_direction, t_ghost);
      vec3 back = back_reflectance(c, base.rgb, shares.reflected);
      reflected += back * (u_layer.y * second.rgb - u_layer.x * mirrored) * second.w;
    }
#endif
    o_color = vec4(base.a * (pane * (u_layer.z * emission + reflected) + (1.0 - pane) * u_layer.z * surface), 0.0);
    o_through = vec4(1.0 - base.a + shares.transmitted * (pane * base.a), 1.0);
  }
#endif
#if MIRRORED == 3
  {
    float c = dot(n, view);
    vec4 scene = reflected_scene(t_ray_direction, t_reflection);
    vec3 mirrored = scene.w > 0.0 ? scene.rgb : environment_bilinear(environment_from_world(reflect(-view, n))) * (u_frame.environment.z * v_open);
    vec3 share = vec3(metal_reflectance(c, base.r), metal_reflectance(c, base.g), metal_reflectance(c, base.b));
    o_color = vec4(u_layer.z * (emission + share * mirrored), 0.0);
    o_through = vec4(0.0, 0.0, 0.0, 1.0);
  }
#endif
#if MIRRORED && HATCHED
  {
    vec3 mark = hatch_filter();
    o_color.rgb *= mark;
    o_through.rgb *= mark;
  }
#endif
#endif
}
