// The G-buffer of one grid point: 16 bytes and its depth.
//   x  shading normal, octahedral, 2 x 16 bit
//   y  base colour (square-root coded, 3 x 8 bit), metallic 8 bit
//   z  roughness 8 bit, clearcoat 8 bit, material 16 bit
//   w  emitted radiance, shared exponent (kEmissionBias), cd/m2
// Depth along the viewing axis is a separate float; 0 where only the sky is visible.
const int kEmissionBias = 10;

struct Surface {
  vec3 normal;
  vec3 base_color;
  float metallic;
  float roughness;
  float clearcoat;
  int material;
};

uvec4 pack_surface(Surface s, vec3 emission) {
  vec2 oct = octahedral_from_direction(s.normal) * 2.0f - 1.0f;
  return uvec4(packSnorm2x16(oct), packUnorm4x8(vec4(sqrt(s.base_color), s.metallic)),
               uint(clamp(s.roughness, 0.0f, 1.0f) * 255.0f + 0.5f) |
                   (uint(clamp(s.clearcoat, 0.0f, 1.0f) * 255.0f + 0.5f) << 8u) | (uint(s.material) << 16u),
               pack_rgb9e5(emission, kEmissionBias));
}

vec3 unpack_normal(uint x) { return direction_from_octahedral(unpackSnorm2x16(x) * 0.5f + 0.5f); }

Surface unpack_surface(uvec4 g) {
  Surface s;
  s.normal = unpack_normal(g.x);
  vec4 y = unpackUnorm4x8(g.y);
  s.base_color = y.xyz * y.xyz;
  s.metallic = y.w;
  s.roughness = float(g.z & 255u) * (1.0f / 255.0f);
  s.clearcoat = float((g.z >> 8u) & 255u) * (1.0f / 255.0f);
  s.material = int(g.z >> 16u);
  return s;
}

/// Guide of the bilateral upsampling, in one fetch: depth, and the normal (2 x 12 bits) with the low 8 bits of the material.
uvec2 pack_guide(float depth, vec3 normal, int material) {
  vec2 oct = octahedral_from_direction(normal);
  return uvec2(floatBitsToUint(depth), uint(oct.x * 4095.0f + 0.5f) | (uint(oct.y * 4095.0f + 0.5f) << 12u) |
                                           (uint(material & 255) << 24u));
}
vec3 guide_normal(uint y) {
  return direction_from_octahedral(vec2(float(y & 4095u), float((y >> 12u) & 4095u)) * (1.0f / 4095.0f));
}

/// Approximate share of the reflected light of a white base that scales with the base colour: all for a tinted measured material and for a metal,
/// the Lambert part for another analytic material (against 4 % of specular reflection). Defined for white, because the part that does not scale is
/// the same on dark texels.
float base_color_share(float metallic, bool tinted) { return tinted ? 1.0f : mix(1.0f / 1.04f, 1.0f, metallic); }
