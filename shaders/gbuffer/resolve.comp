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
#include "gbuffer/material_surface.glsl"
#if TEXTURES
#include "shared/texture_table.glsl"
#include "shared/triangle_tangent.glsl"
#endif
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
#include "gbuffer/vertex.glsl"
layout(binding = kUnitTriangleMaterial) uniform usamplerBuffer t_triangle_material;
layout(binding = kImageSurface, rgba32ui) uniform writeonly uimage2D o_surface;
layout(binding = kImageDepth, r32f) uniform writeonly image2D o_depth;
layout(binding = kImageGuide, rg32ui) uniform writeonly uimage2D o_guide;
#if TEXTURE_BANDWIDTH
layout(binding = kUnitTextureBandwidth) uniform samplerBuffer t_texture_bandwidth;  // [texture][16 x 16], cycles per unit of UV
layout(binding = kImageTextureBandwidth, r32f) uniform writeonly image2D o_texture_bandwidth;  // cycles/m: 1e8 in a scene of a micrometre, beyond half floats
#endif

/// A triangle's corners, and the point of it that a grid point shows.
struct Triangle {
  ivec3 vertices;  // first texels in the table
  vec4 p0, p1, p2, n0, n1, n2;
  vec3 e1, e2;
  vec3 b;  // barycentric coordinates
  float depth;
};

Triangle load_triangle(ivec2 pixel, int triangle) {
  Triangle t;
  for (int k = 0; k < 3; ++k) t.vertices[k] = 4 * int(texelFetch(t_indices, 3 * triangle + k).x);
  t.p0 = texelFetch(t_vertices, t.vertices.x);
  t.p1 = texelFetch(t_vertices, t.vertices.y);
  t.p2 = texelFetch(t_vertices, t.vertices.z);
  t.n0 = texelFetch(t_vertices, t.vertices.x + 1);
  t.n1 = texelFetch(t_vertices, t.vertices.y + 1);
  t.n2 = texelFetch(t_vertices, t.vertices.z + 1);
  t.e1 = t.p1.xyz - t.p0.xyz;
  t.e2 = t.p2.xyz - t.p0.xyz;
  vec3 origin = view_origin(pixel), ray = view_ray(pixel);
  // A grid point on the edge of a thin triangle may miss by rounding: clamped to the triangle.
  vec2 b = clamp(intersect_plane_of_triangle(origin, ray, t.p0.xyz, t.e1, t.e2).barycentric, 0.0, 1.0);
  b *= 1.0 / max(1.0, b.x + b.y);
  t.b = vec3(1.0 - b.x - b.y, b);
#ifdef REFLECTED
  t.depth = dot(t.p0.xyz + b.x * t.e1 + b.y * t.e2 - origin, ray);
#else
  t.depth = dot(t.p0.xyz + b.x * t.e1 + b.y * t.e2 - origin, u_frame.forward.xyz);
#endif
  return t;
}

vec4 interpolate(Triangle t, int row) {
  return t.b.x * texelFetch(t_vertices, t.vertices.x + row) + t.b.y * texelFetch(t_vertices, t.vertices.y + row) +
         t.b.z * texelFetch(t_vertices, t.vertices.z + row);
}

/// A point's material, before and after its textures.
struct Resolved {
  Surface surface;  // its normal: interpolated, unit
  vec3 emission;  // share of the material's
  float transmission;
  float texture_bandwidth;  // cycles/m
};

Resolved load_material(Triangle t, int material) {
  vec3 normal = t.b.x * t.n0.xyz + t.b.y * t.n1.xyz + t.b.z * t.n2.xyz;
  Resolved r;
  r.surface = surface_of_material(material, interpolated_normal(normal, cross(t.e1, t.e2)));
#if VERTEX_COLORS
  r.surface.base_color *= unpack_vertex_color(texelFetch(t_vertices, t.vertices.x + 3).zw).rgb * t.b.x +
                          unpack_vertex_color(texelFetch(t_vertices, t.vertices.y + 3).zw).rgb * t.b.y +
                          unpack_vertex_color(texelFetch(t_vertices, t.vertices.z + 3).zw).rgb * t.b.z;
#endif
#if DETAILS
  float rotation = uintBitsToFloat(material_words(material, 6).w);
  r.surface.along = vec3(cos(rotation), sin(rotation), 0.0);  // along the tangents; the world's axes at the end
#endif
  r.emission = vec3(1.0);
  r.transmission = material_floats(material, 3).w;
  r.texture_bandwidth = 0.0;
  return r;
}

#if TEXTURES
/// Coordinates of both UV sets and their derivatives along the screen.
struct TextureAt {
  vec2 uv[2], dx[2], dy[2];
};

TextureAt texture_at(ivec2 pixel, Triangle t) {
  TriangleHit hx = intersect_plane_of_triangle(view_origin(pixel + ivec2(1, 0)), view_ray(pixel + ivec2(1, 0)), t.p0.xyz, t.e1, t.e2);
  TriangleHit hy = intersect_plane_of_triangle(view_origin(pixel + ivec2(0, 1)), view_ray(pixel + ivec2(0, 1)), t.p0.xyz, t.e1, t.e2);
  TriangleHit here = intersect_plane_of_triangle(view_origin(pixel), view_ray(pixel), t.p0.xyz, t.e1, t.e2);
#ifdef REFLECTED
  // At a pane's border the next pixel has no ray: no footprint is known there.
  if (texelFetch(t_ray_direction, pixel + ivec2(1, 0), 0).w <= 0.0) hx = here;
  if (texelFetch(t_ray_direction, pixel + ivec2(0, 1), 0).w <= 0.0) hy = here;
#endif
  vec2 bx = hx.barycentric - here.barycentric, by = hy.barycentric - here.barycentric;
  TextureAt at;
  vec2 c0 = texelFetch(t_vertices, t.vertices.x + 3).xy, c1 = texelFetch(t_vertices, t.vertices.y + 3).xy;
  vec2 c2 = texelFetch(t_vertices, t.vertices.z + 3).xy;
  vec2 s0 = vec2(t.p0.w, t.n0.w), s1 = vec2(t.p1.w, t.n1.w), s2 = vec2(t.p2.w, t.n2.w);
  at.uv[0] = t.b.x * s0 + t.b.y * s1 + t.b.z * s2;
  at.uv[1] = t.b.x * c0 + t.b.y * c1 + t.b.z * c2;
  at.dx[0] = (s1 - s0) * bx.x + (s2 - s0) * bx.y;
  at.dy[0] = (s1 - s0) * by.x + (s2 - s0) * by.y;
  at.dx[1] = (c1 - c0) * bx.x + (c2 - c0) * bx.y;
  at.dy[1] = (c1 - c0) * by.x + (c2 - c0) * by.y;
  return at;
}

/// Applies a texture to what its role names, except normals.
void apply_texture(inout Resolved r, uint role, vec4 value, vec4 m1) {
  r.surface.base_color *= role == kRoleBaseColor ? value.rgb : vec3(1.0);
  r.surface.metallic *= role == kRoleMetallicRoughness ? value.b : 1.0;
  r.surface.roughness *= role == kRoleMetallicRoughness ? value.g : 1.0;
  r.surface.clearcoat *= role == kRoleClearcoat ? value.r : 1.0;
  r.emission *= role == kRoleEmissive ? value.rgb : vec3(1.0);
  r.transmission *= role == kRoleTransmission ? value.r : 1.0;
#if DETAILS
  r.surface.occlusion = role == kRoleOcclusion ? mix(1.0, value.r, m1.w) : r.surface.occlusion;
  r.surface.coat_roughness *= role == kRoleCoatRoughness ? value.g : 1.0;
  r.surface.specular *= role == kRoleSpecular ? value.a : 1.0;
  r.surface.specular_color *= role == kRoleSpecularColor ? value.rgb : vec3(1.0);
  r.surface.sheen_color *= role == kRoleSheenColor ? value.rgb : vec3(1.0);
  r.surface.sheen_roughness *= role == kRoleSheenRoughness ? value.a : 1.0;
  r.surface.film *= role == kRoleIridescence ? value.r : 1.0;
  if (role == kRoleIridescenceThickness)
    r.surface.film_nm = mix(material_floats(r.surface.material, 7).z, r.surface.film_nm, value.g);
  if (role == kRoleAnisotropy) {
    vec2 a = value.rg * 2.0 - 1.0, rotated = r.surface.along.xy;
    a = dot(a, a) > 1.0e-4 ? normalize(a) : vec2(1.0, 0.0);
    r.surface.along.xy = vec2(a.x * rotated.x - a.y * rotated.y, a.x * rotated.y + a.y * rotated.x);
    r.surface.anisotropy *= value.b;
  }
#endif
}

#if DETAILS
/// Of the triangle, by the coordinates of one texture.
vec4 tangent_of_texture(Triangle t, int index, vec3 normal, vec4 otherwise) {
  bool second = (int(texture_record(index, 2).w) & 2) != 0;
  vec2 uv[3];
  for (int k = 0; k < 3; ++k) {
    vec2 first = vec2(k == 0 ? t.p0.w : k == 1 ? t.p1.w : t.p2.w, k == 0 ? t.n0.w : k == 1 ? t.n1.w : t.n2.w);
    uv[k] = second ? texelFetch(t_vertices, t.vertices[k] + 3).xy : first;
  }
  return triangle_tangent(normal, t.e1, t.e2, texture_transformed(index, uv[1] - uv[0]), texture_transformed(index, uv[2] - uv[0]),
                          otherwise);
}
#endif

void read_textures(ivec2 pixel, Triangle t, inout Resolved r) {
  int material = r.surface.material;
  if (!has_textures(material)) return;
  TextureAt at = texture_at(pixel, t);
  vec3 mapped = vec3(0.0, 0.0, 1.0);
  vec4 m1 = material_floats(material, 1);
#if DETAILS
  vec3 coat_mapped = vec3(0.0, 0.0, 1.0);
  int coat_texture = -1;
#endif
#if TEXTURE_BANDWIDTH
  uint flags = material_words(material, 6).x;
#endif
  // One loop over the list, because software drivers run every branch for every invocation: so the sampling code runs only as often as the
  // longest list needs.
  for (int k = 0; k < kMostTextures; ++k) {
    uint entry = material_texture(material, k);
    if (entry == kNoTexture) break;
    int index = int(entry & 0xffffu);
    uint role = entry >> 16u;
    vec4 m = texture_record(index, 1), rest = texture_record(index, 2);
    int set = (int(rest.w) & 2) != 0 ? 1 : 0;
    mat2 linear = mat2(m.x, m.z, m.y, m.w);
    vec2 uv = linear * at.uv[set] + rest.xy, dx = linear * at.dx[set], dy = linear * at.dy[set];
    vec4 value = sample_texture(index, uv, dx, dy);
    apply_texture(r, role, value, m1);
    mapped = role == kRoleNormal ? value.xyz * 2.0 - 1.0 : mapped;
#if DETAILS
    coat_mapped = role == kRoleCoatNormal ? value.xyz * 2.0 - 1.0 : coat_mapped;
    coat_texture = role == kRoleCoatNormal ? index : coat_texture;
#endif
#if TEXTURE_BANDWIDTH
    // Cycles per unit of UV, times units of UV per metre of the pixel's footprint; limited to the Nyquist frequency of the pixels.
    ivec2 cell = ivec2(fract(uv) * 16.0);
    float cycles_per_uv = texelFetch(t_texture_bandwidth, index * 256 + cell.y * 16 + cell.x).x;
    float span = sqrt(max(length(dx) * length(dy), 1e-20));
    // Upsampling divides by the base colour and multiplies by it again (fill.comp), so only the remaining light contributes its detail.
    if (role == kRoleBaseColor) cycles_per_uv *= 1.0 - base_color_share(r.surface.metallic, (flags & kMaterialTinted) != 0u);
    float nu = role != kRoleEmissive ? min(cycles_per_uv * span, 0.5) / pixel_width(t.depth) : 0.0;
    r.texture_bandwidth = max(r.texture_bandwidth, nu);
#endif
  }
  vec4 tangent = interpolate(t, 2);
#if DETAILS
  vec4 m8 = material_floats(material, 8);
  bool own = m8.y > 0.0 && abs(tangent.w) < 1.5;
  vec4 coat_tangent = own ? tangent_of_texture(t, max(coat_texture, 0), r.surface.normal, tangent) : tangent;
  r.surface.coat_normal = apply_normal_map(r.surface.normal, coat_tangent, coat_mapped, m8.x);
#endif
  r.surface.normal = apply_normal_map(r.surface.normal, tangent, mapped, m1.z);
}
#endif

void resolve_surface(ivec2 pixel, int triangle) {
  Triangle t = load_triangle(pixel, triangle);
  Resolved r = load_material(t, int(texelFetch(t_triangle_material, triangle).x));
#if TEXTURES
  read_textures(pixel, t, r);
#endif
  // Metal transmits nothing, and the surface besides the pane has all of it.
  if (r.transmission > 0.0) r.surface.metallic = min(r.surface.metallic / max(1.0 - r.transmission * (1.0 - r.surface.metallic), 1e-6), 1.0);
  vec3 view = view_origin(pixel) - t.p0.xyz, to_eye = -normalize(view_ray(pixel)), geometric = cross(t.e1, t.e2);
  vec3 seen_side = dot(geometric, view) < 0.0 ? -geometric : geometric;
  r.surface.normal = face_viewer(r.surface.normal, seen_side, to_eye);
  float depth = max(t.depth, 1e-30);
#if DETAILS
  r.surface.coat_normal = face_viewer(r.surface.coat_normal, seen_side, to_eye);
  r.surface.along = tangent_direction(r.surface.normal, interpolate(t, 2), r.surface.along.xy);
  store_details(pixel, r.surface);
#endif
#if DETAILS
  vec3 coat_normal = r.surface.coat_normal;
#else
  vec3 coat_normal = r.surface.normal;
#endif
  r.emission *= emission_through_coat(r.surface.clearcoat, dot(coat_normal, to_eye));
  imageStore(o_surface, pixel, pack_surface(r.surface, r.emission));
  imageStore(o_depth, pixel, vec4(depth));
  imageStore(o_guide, pixel, uvec4(pack_guide(depth, r.surface.normal, r.surface.material), 0u, 0u));
#if TEXTURE_BANDWIDTH
  imageStore(o_texture_bandwidth, pixel, vec4(r.texture_bandwidth));
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
