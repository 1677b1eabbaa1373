// Selects the opaque surfaces whose reflections are traced.
uniform float u_roughness;     // of the widest lobe
uniform ivec2 u_named[16];     // triangles of named parts, from and to
uniform int u_named_count;
/// Roughness limit of named parts; render/reflections/reflectors.h has the same number.
const float kMaxGlossyRoughness = 0.5;

float widest_roughness(int triangle) {
  float roughness = u_roughness;
  for (int k = 0; k < u_named_count; ++k)
    if (triangle >= u_named[k].x && triangle < u_named[k].y) roughness = kMaxGlossyRoughness;
  return roughness;
}
