// Reflectance of a base under a thin film by interference. Common subset of GLSL and C++ with GLM.
// Source: KHR_materials_iridescence, after Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying
// Iridescence"; the film's spectral response is integrated against Gaussian fits of the CIE functions.
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

/// Linear Rec.709 of an interference term of one order: `path_nm` is the optical path difference, `shift` the phase in rad.
MAQUETTE_FN vec3 thin_film_sensitivity(float path_nm, vec3 shift) {
  float phase = 6.28318530718f * path_nm * 1.0e-9f;
  vec3 position = vec3(1.6810e6f, 1.7953e6f, 2.2084e6f);
  vec3 variance = vec3(4.3278e9f, 9.3046e9f, 6.6121e9f);
  vec3 height = vec3(5.4856e-13f, 4.4201e-13f, 5.2481e-13f);
  vec3 xyz = height * sqrt(6.28318530718f * variance) * cos(position * phase + shift) * exp(-(phase * phase) * variance);
  xyz.x += 9.7470e-14f * sqrt(6.28318530718f * 4.5282e9f) * cos(2.2399e6f * phase + shift.x) * exp(-4.5282e9f * phase * phase);
  xyz = xyz / 1.0685e-7f;
  return vec3(3.2404542f * xyz.x - 1.5371385f * xyz.y - 0.4985314f * xyz.z,
              -0.9692660f * xyz.x + 1.8760108f * xyz.y + 0.0415560f * xyz.z,
              0.0556434f * xyz.x - 0.2040259f * xyz.y + 1.0572252f * xyz.z);
}

MAQUETTE_FN vec3 thin_film_schlick(vec3 f0, float cosine) {
  float x = clamp(1.0f - cosine, 0.0f, 1.0f);
  float x2 = x * x;
  return f0 + (vec3(1.0f) - f0) * (x2 * x2 * x);
}

/// Of a film of refractive index `ior` and `thickness_nm` over a base whose reflectance against air at normal incidence is `base_f0`.
MAQUETTE_FN vec3 thin_film_fresnel(float cosine, float ior, float thickness_nm, vec3 base_f0) {
  float film = 1.0f + (ior - 1.0f) * smoothstep(0.0f, 0.03f, thickness_nm);
  float cos2_inside = 1.0f - (1.0f - cosine * cosine) / (film * film);
  if (cos2_inside < 0.0f) return vec3(1.0f);
  float cos_inside = sqrt(cos2_inside);
  float top = (film - 1.0f) / (film + 1.0f);
  vec3 r12 = thin_film_schlick(vec3(top * top), cosine);
  vec3 t121 = vec3(1.0f) - r12;
  float phase12 = film < 1.0f ? 3.14159265359f : 0.0f;
  vec3 root = sqrt(clamp(base_f0, vec3(0.0f), vec3(0.9999f)));
  vec3 base = (vec3(1.0f) + root) / (vec3(1.0f) - root);
  vec3 bottom = (base - vec3(film)) / (base + vec3(film));
  vec3 r23 = thin_film_schlick(bottom * bottom, cos_inside);
  vec3 phase = vec3(3.14159265359f - phase12) + vec3(base.x < film ? 3.14159265359f : 0.0f, base.y < film ? 3.14159265359f : 0.0f,
                                                  base.z < film ? 3.14159265359f : 0.0f);
  vec3 r123 = clamp(r12 * r23, vec3(1.0e-5f), vec3(0.9999f));
  vec3 amplitude = sqrt(r123);
  vec3 all = t121 * t121 * r23 / (vec3(1.0f) - r123);
  vec3 sum = r12 + all;
  vec3 order = all - t121;
  float path_nm = 2.0f * film * thickness_nm * cos_inside;
  for (int k = 1; k <= 2; ++k) {
    order = order * amplitude;
    sum = sum + order * thin_film_sensitivity(float(k) * path_nm, float(k) * phase) * 2.0f;
  }
  return max(sum, vec3(0.0f));
}
