// The G-buffer of one grid point: 16 bytes and its depth.
//   x  shading normal, octahedral, 2 x 16 bit
//   y  roots of the base colour, shared exponent (kBaseColorBias): within 0.4 % of its largest channel, 1e-3 of a dark one beside it
//   z  root of the roughness 10 bit, metallic 6 bit, material 16 bit
//   w  share of the material's emission, which its texture and its coat leave: logarithms of 11, 11 and 10 bits, within 0.7 % down to 1e-6, and 1
//      exactly. Its factors are the material's: a shared exponent would lose a channel a thousandth of another one
// Depth along the viewing axis is a separate float; 0 where only the sky is visible.
// DETAILS: two more layers of 16 bytes hold what scenes rarely have (unpack_details); without them points read it from the material.
const int kBaseColorBias = 34;  // to 64, as vertex colours may be
#ifndef DETAILS
#define DETAILS 0
#endif

struct Surface {
  vec3 normal;
  vec3 base_color;
  float metallic;
  float roughness;
  float clearcoat;
  int material;
#if DETAILS
  float occlusion;  // of sky and baked light
  vec3 coat_normal;
  float coat_roughness;
  float specular;
  vec3 specular_color;
  vec3 sheen_color;
  float sheen_roughness;
  float anisotropy;
  vec3 along;  // direction of the anisotropy, unit, across the normal
  float film;
  float film_nm;
#endif
};

/// Codes of a share: 0 is 0, the last one 1, and those between are kShareOctaves apart.
const vec3 kShareCodes = vec3(2047.0f, 2047.0f, 1023.0f);
const float kShareOctaves = 20.0f;
uint pack_emission_share(vec3 share) {
  vec3 at = kShareCodes + log2(max(share, vec3(1.0e-30f))) * (kShareCodes - 1.0f) / kShareOctaves;
  uvec3 code = uvec3(clamp(at + 0.5f, vec3(0.0f), kShareCodes));
  return code.x | (code.y << 11u) | (code.z << 22u);
}
vec3 unpack_emission_share(uint w) {
  vec3 code = vec3(float(w & 2047u), float((w >> 11u) & 2047u), float(w >> 22u));
  return exp2((code - kShareCodes) * kShareOctaves / (kShareCodes - 1.0f)) * vec3(greaterThan(code, vec3(0.0f)));
}

uvec4 pack_surface(Surface s, vec3 emission_share) {
  vec2 oct = octahedral_from_direction(s.normal) * 2.0f - 1.0f;
  return uvec4(packSnorm2x16(oct), pack_rgb9e5(sqrt(max(s.base_color, vec3(0.0f))), kBaseColorBias),
               uint(sqrt(clamp(s.roughness, 0.0f, 1.0f)) * 1023.0f + 0.5f) |
                   (uint(clamp(s.metallic, 0.0f, 1.0f) * 63.0f + 0.5f) << 10u) | (uint(s.material) << 16u),
               pack_emission_share(emission_share));
}

vec3 unpack_base_color(uint y) {
  vec3 root = unpack_rgb9e5(y, kBaseColorBias);
  return root * root;
}
float unpack_roughness(uint z) {
  float root = float(z & 1023u) * (1.0f / 1023.0f);
  return root * root;
}
float unpack_metallic(uint z) { return float((z >> 10u) & 63u) * (1.0f / 63.0f); }

vec3 unpack_normal(uint x) { return direction_from_octahedral(unpackSnorm2x16(x) * 0.5f + 0.5f); }

Surface unpack_surface(uvec4 g) {
  Surface s;
  s.normal = unpack_normal(g.x);
  s.base_color = unpack_base_color(g.y);
  s.metallic = unpack_metallic(g.z);
  s.roughness = unpack_roughness(g.z);
  s.clearcoat = 0.0f;  // of unpack_details, or the material's
  s.material = int(g.z >> 16u);
  return s;
}

#if DETAILS
const int kSpecularBias = 34;  // colours to 64
struct Details {
  uvec4 lobes;   // coat roughness, sheen roughness | clearcoat 11 bit, specular 11, occlusion 10 | specular colour | sheen colour
  uvec4 shapes;  // coat normal | direction of the anisotropy | its strength, film | thickness (half float), roughness
};

Details pack_details(Surface s) {
  Details d;
  d.lobes = uvec4(packUnorm2x16(vec2(s.coat_roughness, s.sheen_roughness)),
                  uint(clamp(s.clearcoat, 0.0f, 1.0f) * 2047.0f + 0.5f) | (uint(clamp(s.specular, 0.0f, 1.0f) * 2047.0f + 0.5f) << 11u) |
                      (uint(clamp(s.occlusion, 0.0f, 1.0f) * 1023.0f + 0.5f) << 22u),
                  pack_rgb9e5(s.specular_color, kSpecularBias), pack_rgb9e5(s.sheen_color, kSpecularBias));
  d.shapes = uvec4(packSnorm2x16(octahedral_from_direction(s.coat_normal) * 2.0f - 1.0f),
                   packSnorm2x16(octahedral_from_direction(s.along) * 2.0f - 1.0f), packUnorm2x16(vec2(s.anisotropy, s.film)),
                   (packHalf2x16(vec2(s.film_nm, 0.0f)) & 0xffffu) | (packUnorm2x16(vec2(s.roughness, 0.0f)) << 16u));
  return d;
}

Surface unpack_details(Surface s, uvec4 lobes, uvec4 shapes) {
  vec2 roughness = unpackUnorm2x16(lobes.x), shares = unpackUnorm2x16(shapes.z);
  s.coat_roughness = roughness.x;
  s.sheen_roughness = roughness.y;
  s.clearcoat = float(lobes.y & 2047u) * (1.0f / 2047.0f);
  s.specular = float((lobes.y >> 11u) & 2047u) * (1.0f / 2047.0f);
  s.occlusion = float(lobes.y >> 22u) * (1.0f / 1023.0f);
  s.specular_color = unpack_rgb9e5(lobes.z, kSpecularBias);
  s.sheen_color = unpack_rgb9e5(lobes.w, kSpecularBias);
  s.coat_normal = unpack_normal(shapes.x);
  s.along = unpack_normal(shapes.y);
  s.anisotropy = shares.x;
  s.film = shares.y;
  s.film_nm = unpackHalf2x16(shapes.w).x;
  s.roughness = unpackUnorm2x16(shapes.w).y;
  return s;
}
#endif

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
