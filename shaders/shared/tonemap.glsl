// Tone mapping: linear Rec.709 radiance, already multiplied by the exposure, to linear display values in [0, 1]; then sRGB.
// Needs shared/luminance.glsl
// before it. Common subset of GLSL and C++ with GLM (render/picture/tonemap.cpp).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// Same order as tonemap_names().
const int kTonemapLinear = 0;
const int kTonemapReinhard = 1;
const int kTonemapAces = 2;
const int kTonemapAgx = 3;
const int kTonemapPbrNeutral = 4;

// NaN and negative values to 0, infinity to a large number, as the curves below need.
MAQUETTE_FN float tonemap_sane(float v) { return v > 0.0f ? min(v, 1.0e8f) : 0.0f; }

// x / (1 + x) of the luminance, which preserves hues; values outside the gamut are clipped.
// Source: Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images", Eq. 3.
MAQUETTE_FN vec3 tonemap_reinhard(vec3 c) {
  return c * (1.0f / (1.0f + luminance(c)));
}

// Source: Stephen Hill's fit of the ACES RRT and ODT (sRGB), as published in MJP's BakingLab, ACES.hlsl.
MAQUETTE_FN vec3 tonemap_aces(vec3 c) {
  vec3 v = vec3(0.59719f * c.x + 0.35458f * c.y + 0.04823f * c.z, 0.07600f * c.x + 0.90834f * c.y + 0.01566f * c.z,
                0.02840f * c.x + 0.13383f * c.y + 0.83777f * c.z);
  vec3 a = v * (v + vec3(0.0245786f)) - vec3(0.000090537f);
  vec3 b = v * (v * 0.983729f + vec3(0.4329510f)) + vec3(0.238081f);
  vec3 r = a / b;
  return vec3(1.60475f * r.x - 0.53108f * r.y - 0.07367f * r.z, -0.10208f * r.x + 1.10813f * r.y - 0.00605f * r.z,
              -0.00327f * r.x - 0.07276f * r.y + 1.07602f * r.z);
}

// The curve of AgX on [0, 1], degree 6, mean error 4e-6.
// Source: Benjamin Wrensch 2023, "Minimal AgX Implementation", after Troy Sobotka's AgX.
MAQUETTE_FN float tonemap_agx_curve(float x) {
  float x2 = x * x;
  float x4 = x2 * x2;
  return 15.5f * x4 * x2 - 40.14f * x4 * x + 31.96f * x4 - 6.868f * x2 * x + 0.4298f * x2 + 0.1191f * x - 0.00232f;
}

// Range -12.47393 to +4.026069 stops, no look. Source: as above.
MAQUETTE_FN vec3 tonemap_agx(vec3 c) {
  vec3 v = vec3(0.842479062253094f * c.x + 0.0784335999999992f * c.y + 0.0792237451477643f * c.z,
                0.0423282422610123f * c.x + 0.878468636469772f * c.y + 0.0791661274605434f * c.z,
                0.0423756549057051f * c.x + 0.0784336f * c.y + 0.879142973793104f * c.z);
  v = clamp((log2(max(v, vec3(1.0e-10f))) + vec3(12.47393f)) / 16.5f, vec3(0.0f), vec3(1.0f));
  v = vec3(tonemap_agx_curve(v.x), tonemap_agx_curve(v.y), tonemap_agx_curve(v.z));
  vec3 r = vec3(1.19687900512017f * v.x - 0.0980208811401368f * v.y - 0.0990297440797205f * v.z,
                -0.0528968517574562f * v.x + 1.15190312990417f * v.y - 0.0989611768448433f * v.z,
                -0.0529716355144438f * v.x - 0.0980434501171241f * v.y + 1.15107367264116f * v.z);
  // The curve gives display-encoded values of gamma 2.2.
  return pow(max(r, vec3(0.0f)), vec3(2.2f));
}

// Source: Khronos PBR Neutral Tone Mapper specification (KhronosGroup/ToneMapping), 2024.
MAQUETTE_FN vec3 tonemap_pbr_neutral(vec3 c) {
  float start_compression = 0.8f - 0.04f;
  float desaturation = 0.15f;
  float x = min(c.x, min(c.y, c.z));
  float offset = x < 0.08f ? x - 6.25f * x * x : 0.04f;
  vec3 v = c - vec3(offset);
  float peak = max(v.x, max(v.y, v.z));
  if (peak < start_compression) return v;
  float d = 1.0f - start_compression;
  float new_peak = 1.0f - d * d / (peak + d - start_compression);
  v = v * (new_peak / peak);
  float g = 1.0f - 1.0f / (desaturation * (peak - new_peak) + 1.0f);
  return mix(v, vec3(new_peak), g);
}

// Linear to the sRGB encoding. Source: IEC 61966-2-1.
MAQUETTE_FN float srgb_from_linear(float v) {
  return v <= 0.0031308f ? 12.92f * v : 1.055f * pow(v, 1.0f / 2.4f) - 0.055f;
}

MAQUETTE_FN vec3 srgb_encode(vec3 c) { return vec3(srgb_from_linear(c.x), srgb_from_linear(c.y), srgb_from_linear(c.z)); }

// From radiance to linear display values in [0, 1]. exposure: 2^EV.
MAQUETTE_FN vec3 tonemap(vec3 radiance, float exposure, int curve) {
  vec3 c = vec3(tonemap_sane(radiance.x * exposure), tonemap_sane(radiance.y * exposure), tonemap_sane(radiance.z * exposure));
  if (curve == kTonemapReinhard) c = tonemap_reinhard(c);
  if (curve == kTonemapAces) c = tonemap_aces(c);
  if (curve == kTonemapAgx) c = tonemap_agx(c);
  if (curve == kTonemapPbrNeutral) c = tonemap_pbr_neutral(c);
  return clamp(c, vec3(0.0f), vec3(1.0f));
}
