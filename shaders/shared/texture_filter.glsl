// Filtering of textures that are packed in one list of texels of 4 x 16 bits with their mip chains (render/materials/texture_atlas.h).
// Common subset of GLSL and C++ with GLM. The includer defines before it:
//   uvec2 fetch_texel_words(int index)                a packed texel
//   vec4 texture_record(int texture_index, int row)   row 0 to 2 of a record
// Record of a texture (3 vec4): offset bits, width, height, levels | rotation and scale of the transform (a 2x2 matrix) | transform
// offset, wrap code (s + 4 t), flags (1 sRGB, 2 UV set 1, 4 nearest).
/// Transforms a vector of UV by the linear part of KHR_texture_transform.
vec2 texture_transformed(int texture_index, vec2 uv) {
  vec4 matrix = texture_record(texture_index, 1);
  return vec2(matrix.x * uv.x + matrix.y * uv.y, matrix.z * uv.x + matrix.w * uv.y);
}

/// The UV coordinates of the texture's set, transformed by KHR_texture_transform.
vec2 texture_coordinates(int texture_index, vec2 uv0, vec2 uv1) {
  vec4 rest = texture_record(texture_index, 2);
  return texture_transformed(texture_index, (int(rest.w) & 2) != 0 ? uv1 : uv0) + vec2(rest.x, rest.y);
}

/// Remainders in float: integer division is scalar and slow on software drivers; sizes are far below 2^24.
int wrap_texel(int i, int size, int mode) {
  if (mode == 2) return clamp(i, 0, size - 1);
  float period = float(mode == 1 ? 2 * size : size);
  float m = float(i) - period * floor(float(i) / period);
  m = mode == 1 && m >= float(size) ? period - 1.0f - m : m;
  return clamp(int(m), 0, size - 1);
}

/// sRGB images are stored square-root coded (render/materials/texture_atlas.cpp): decoding is one product, and filtering is in linear light.
vec4 fetch_texel(int offset, ivec2 size, ivec2 p, int wrap, bool srgb) {
  int x = wrap_texel(p.x, size.x, wrap & 3);
  int y = wrap_texel(p.y, size.y, wrap >> 2);
  uvec2 words = fetch_texel_words(offset + y * size.x + x);
  vec2 rg = unpackUnorm2x16(words.x);
  vec2 ba = unpackUnorm2x16(words.y);
  vec4 c = vec4(rg.x, rg.y, ba.x, ba.y);
  return srgb ? vec4(c.x * c.x, c.y * c.y, c.z * c.z, c.w) : c;
}

vec4 sample_level(int offset, ivec2 size, vec2 uv, int wrap, bool srgb, bool nearest) {
  vec2 p = uv * vec2(size);
  if (nearest) return fetch_texel(offset, size, ivec2(floor(p)), wrap, srgb);
  p -= 0.5f;
  ivec2 i = ivec2(floor(p));
  vec2 f = p - vec2(i);
  return mix(mix(fetch_texel(offset, size, i, wrap, srgb), fetch_texel(offset, size, i + ivec2(1, 0), wrap, srgb), f.x),
             mix(fetch_texel(offset, size, i + ivec2(0, 1), wrap, srgb),
                 fetch_texel(offset, size, i + ivec2(1, 1), wrap, srgb), f.x),
             f.y);
}

/// Trilinear; the footprint is the geometric mean of the two derivatives, so that glancing surfaces stay readable.
vec4 sample_texture(int texture_index, vec2 uv, vec2 duv_dx, vec2 duv_dy) {
  vec4 a = texture_record(texture_index, 0);
  vec4 rest = texture_record(texture_index, 2);
  vec2 extent = vec2(a.y, a.z);
  ivec2 size = ivec2(extent);
  int levels = int(a.w);
  int flags = int(rest.w);
  vec2 ex = duv_dx * extent;
  vec2 ey = duv_dy * extent;
  float lod = clamp(0.25f * log2(max(dot(ex, ex) * dot(ey, ey), 1.0e-12f)), 0.0f, float(levels - 1));
  int level = int(lod);
  int offset = floatBitsToInt(a.x);
  for (int l = 0; l < level; ++l) {
    offset += size.x * size.y;
    size = max(size / 2, ivec2(1));
  }
  bool srgb = (flags & 1) != 0;
  bool nearest = (flags & 4) != 0;
  int wrap = int(rest.z);
  float t = lod - float(level);
  int last = t > 0.02f && level + 1 < levels ? 2 : 1;
  vec4 sum = vec4(0.0f);
  for (int l = 0; l < last; ++l) {
    float weight = last == 1 ? 1.0f : (l == 0 ? 1.0f - t : t);
    sum += weight * sample_level(offset, size, uv, wrap, srgb, nearest);
    offset += size.x * size.y;
    size = max(size / 2, ivec2(1));
  }
  return sum;
}
