// Surface of each grid point from its triangle: exact intersection of the point's ray, interpolated normal and texture coordinates with
// analytic derivatives, textured material.
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
layout(local_size_x = 64) in;
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#if TEXTURES
#include "shared/texture_table.glsl"
#endif
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;  // 4 texels: position, uv0.x | normal, uv0.y | tangent | uv1, colour bits, 0
layout(binding = kUnitTriangleMaterial) uniform usamplerBuffer t_triangle_material;
layout(binding = kImageSurface, rgba32ui) uniform writeonly uimage2D o_surface;
layout(binding = kImageDepth, r32f) uniform writeonly image2D o_depth;
layout(binding = kImageGuide, rg32ui) uniform writeonly uimage2D o_guide;
#if TEXTURE_BANDWIDTH
layout(binding = kUnitTextureBandwidth) uniform samplerBuffer t_texture_bandwidth;  // [texture][16 x 16], cycles per unit of UV
layout(binding = kImageTextureBandwidth, r32f) uniform writeonly image2D o_texture_bandwidth;  // cycles/m: 1e8 in a scene of a micrometre, beyond half floats
#endif

void resolve_surface(ivec2 pixel, int triangle) {
  int v0 = 4 * int(texelFetch(t_indices, 3 * triangle).x);
  int v1 = 4 * int(texelFetch(t_indices, 3 * triangle + 1).x);
  int v2 = 4 * int(texelFetch(t_indices, 3 * triangle + 2).x);
  vec4 p0 = texelFetch(t_vertices, v0), p1 = texelFetch(t_vertices, v1), p2 = texelFetch(t_vertices, v2);
  vec4 n0 = texelFetch(t_vertices, v0 + 1), n1 = texelFetch(t_vertices, v1 + 1), n2 = texelFetch(t_vertices, v2 + 1);
  vec3 e1 = p1.xyz - p0.xyz, e2 = p2.xyz - p0.xyz;
  vec3 origin = view_origin(pixel), ray = view_ray(pixel);
  TriangleHit hit = intersect_plane_of_triangle(origin, ray, p0.xyz, e1, e2);
  // A grid point on the edge of a thin triangle may miss by rounding: clamped to the triangle.
  vec2 b = clamp(hit.barycentric, 0.0, 1.0);
  b *= 1.0 / max(1.0, b.x + b.y);
  float b0 = 1.0 - b.x - b.y;
#ifdef REFLECTED
  float depth = dot(p0.xyz + b.x * e1 + b.y * e2 - origin, ray);
#else
  float depth = dot(p0.xyz + b.x * e1 + b.y * e2 - origin, u_frame.forward.xyz);
#endif
  vec3 geometric = cross(e1, e2);
  vec3 normal = interpolated_normal(b0 * n0.xyz + b.x * n1.xyz + b.y * n2.xyz, geometric);
  int material = int(texelFetch(t_triangle_material, triangle).x);
  vec4 m0 = material_floats(material, 0), m1 = material_floats(material, 1), m2 = material_floats(material, 2);
  vec4 m3 = material_floats(material, 3);
#if VERTEX_COLORS
  vec4 color = b0 * unpackUnorm4x8(floatBitsToUint(texelFetch(t_vertices, v0 + 3).z)) +
               b.x * unpackUnorm4x8(floatBitsToUint(texelFetch(t_vertices, v1 + 3).z)) +
               b.y * unpackUnorm4x8(floatBitsToUint(texelFetch(t_vertices, v2 + 3).z));
  m0.rgb *= color.rgb;
#endif
  Surface surface;
  surface.base_color = m0.rgb;
  surface.metallic = m1.x;
  surface.roughness = m1.y;
  surface.clearcoat = m3.x;
  surface.material = material;
  vec3 emission = m2.rgb;
  float texture_bandwidth = 0.0;
#if TEXTURES
  // The material's list of textures and their roles. One loop over the list, because software drivers run every branch for every invocation:
  // so the sampling code runs only as often as the longest list needs.
  uvec4 list = material_words(material, 7);
  uvec2 more = uvec2(material_words(material, 5).w, material_words(material, 6).w);
  if (list.x != kNoTexture) {
    TriangleHit hx = intersect_plane_of_triangle(view_origin(pixel + ivec2(1, 0)), view_ray(pixel + ivec2(1, 0)), p0.xyz, e1, e2);
    TriangleHit hy = intersect_plane_of_triangle(view_origin(pixel + ivec2(0, 1)), view_ray(pixel + ivec2(0, 1)), p0.xyz, e1, e2);
#ifdef REFLECTED
    // At a pane's border the next pixel has no ray: no footprint is known there.
    if (texelFetch(t_ray_direction, pixel + ivec2(1, 0), 0).w <= 0.0) hx = hit;
    if (texelFetch(t_ray_direction, pixel + ivec2(0, 1), 0).w <= 0.0) hy = hit;
#endif
    vec2 bx = hx.barycentric - hit.barycentric, by = hy.barycentric - hit.barycentric;
    vec4 u0 = texelFetch(t_vertices, v0 + 3), u1 = texelFetch(t_vertices, v1 + 3), u2 = texelFetch(t_vertices, v2 + 3);
    vec2 s0 = vec2(p0.w, n0.w), s1 = vec2(p1.w, n1.w), s2 = vec2(p2.w, n2.w);
    vec2 uv0 = b0 * s0 + b.x * s1 + b.y * s2, uv1 = b0 * u0.xy + b.x * u1.xy + b.y * u2.xy;
    vec2 a1 = s1 - s0, a2 = s2 - s0, c1 = u1.xy - u0.xy, c2 = u2.xy - u0.xy;
    vec2 dx0 = a1 * bx.x + a2 * bx.y, dy0 = a1 * by.x + a2 * by.y;
    vec2 dx1 = c1 * bx.x + c2 * bx.y, dy1 = c1 * by.x + c2 * by.y;
    vec3 mapped = vec3(0.0, 0.0, 1.0);
    uint tint_flags = material_words(material, 6).x;
    for (int k = 0; k < 6; ++k) {
      uint entry = k < 4 ? list[k & 3] : more[k & 1];
      if (entry == kNoTexture) break;
      int index = int(entry & 0xffffu);
      uint role = entry >> 16u;
      vec4 m = texture_record(index, 1), rest = texture_record(index, 2);
      bool second = (int(rest.w) & 2) != 0;
      vec2 uv = second ? uv1 : uv0, dx = second ? dx1 : dx0, dy = second ? dy1 : dy0;
      mat2 t = mat2(m.x, m.z, m.y, m.w);
      uv = t * uv + rest.xy;
      dx = t * dx;
      dy = t * dy;
      vec4 value = sample_texture(index, uv, dx, dy);
      surface.base_color *= role == kRoleBaseColor ? value.rgb : vec3(role == kRoleOcclusion ? mix(1.0, value.r, m1.w) : 1.0);
      surface.metallic *= role == kRoleMetallicRoughness ? value.b : 1.0;
      surface.roughness *= role == kRoleMetallicRoughness ? value.g : 1.0;
      surface.clearcoat *= role == kRoleClearcoat ? value.r : 1.0;
      emission *= role == kRoleEmissive ? value.rgb : vec3(1.0);
      mapped = role == kRoleNormal ? value.xyz * 2.0 - 1.0 : mapped;
#if TEXTURE_BANDWIDTH
      // Cycles per unit of UV, times units of UV per metre of the pixel's footprint; limited to the Nyquist frequency of the pixels.
      ivec2 cell = ivec2(fract(uv) * 16.0);
      float cycles_per_uv = texelFetch(t_texture_bandwidth, index * 256 + cell.y * 16 + cell.x).x;
      float span = sqrt(max(length(dx) * length(dy), 1e-20));
      // Upsampling divides by the base colour and multiplies by it again (fill.comp), so only the remaining light contributes its detail.
      if (role == kRoleBaseColor)
        cycles_per_uv *= 1.0 - base_color_share(surface.metallic, (tint_flags & kMaterialTinted) != 0u);
      float nu = role <= kRoleNormal ? min(cycles_per_uv * span, 0.5) / (depth * u_frame.forward.w) : 0.0;
      texture_bandwidth = max(texture_bandwidth, nu);
#endif
    }
    vec4 t = b0 * texelFetch(t_vertices, v0 + 2) + b.x * texelFetch(t_vertices, v1 + 2) +
             b.y * texelFetch(t_vertices, v2 + 2);
    normal = apply_normal_map(normal, t, mapped, m1.z);
  }
#endif
  vec3 seen_side = dot(geometric, origin - p0.xyz) < 0.0 ? -geometric : geometric;
  normal = face_viewer(normal, seen_side, -normalize(ray));
  surface.normal = normal;
  imageStore(o_surface, pixel, pack_surface(surface, emission));
  imageStore(o_depth, pixel, vec4(max(depth, 1e-30)));
  imageStore(o_guide, pixel, uvec4(pack_guide(max(depth, 1e-30), normal, material), 0u, 0u));
#if TEXTURE_BANDWIDTH
  imageStore(o_texture_bandwidth, pixel, vec4(texture_bandwidth));
#endif
}

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  int triangle = int(texelFetch(t_triangle, pixel, 0).x) - 1;
  if (triangle < 0) {
    imageStore(o_depth, pixel, vec4(0.0));
    imageStore(o_guide, pixel, uvec4(0u));
    imageStore(o_surface, pixel, uvec4(0u));
  }
  if (triangle >= 0) resolve_surface(pixel, triangle);
}
