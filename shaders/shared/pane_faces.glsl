// Panes whose faces reflect as KHR_materials_specular says. Needs shared/fresnel.glsl before it. Common subset of GLSL and C++ with GLM
// (render/math/surface_formulas.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// Refractive index of a face that reflects f0 at normal incidence; that of a perfect mirror is finite, too.
MAQUETTE_FN float index_of_f0(float f0) {
  float root = sqrt(clamp(f0, 0.0f, 0.999f));
  return (1.0f + root) / (1.0f - root);
}

// How the faces of a pane reflect.
struct PaneFaces {
  vec3 index;   // refractive index with the reflectance of each channel, at least 1
  float share;  // of that reflectance
};

MAQUETTE_FN PaneFaces plain_faces(float ior) {
  PaneFaces faces;
  faces.index = vec3(max(ior, 1.0f));
  faces.share = 1.0f;
  return faces;
}

// Source: KHR_materials_specular, "Implementation": F0 is that of the index times the colour, at most 1, all times the factor.
// Differs: Fresnel's equations with the index of that F0, instead of Schlick's approximation. An index of 0 reflects all (KHR_materials_ior).
MAQUETTE_FN PaneFaces pane_faces(float ior, float specular, vec3 specular_color) {
  PaneFaces faces = plain_faces(ior);
  faces.share = specular;
  if (specular_color != vec3(1.0f) || ior < 1.0f) {
    float root = (ior - 1.0f) / (ior + 1.0f);
    vec3 f0 = specular_color * (root * root);
    faces.index = vec3(index_of_f0(f0.x), index_of_f0(f0.y), index_of_f0(f0.z));
  }
  return faces;
}

MAQUETTE_FN bool is_plain(PaneFaces f) { return f.share == 1.0f && f.index.x == f.index.y && f.index.x == f.index.z; }

// What a face lets through, for s and p polarisation: the same of all channels, so that less reflection of one colour does not transmit more of
// it. Source: KHR_materials_specular, which takes the largest channel of F.
MAQUETTE_FN vec2 face_passes(float cos_i, PaneFaces f) {
  vec2 reflected = max(max(fresnel_sp(cos_i, f.index.x), fresnel_sp(cos_i, f.index.y)), fresnel_sp(cos_i, f.index.z));
  return vec2(1.0f, 1.0f) - reflected * f.share;
}

// As fresnel_pane, for faces that reflect a share of what their index says. `passes`: of face_passes.
MAQUETTE_FN vec2 fresnel_pane_faces(float cos_i, float n, float share, vec2 passes, float inside) {
  vec2 face = fresnel_sp(cos_i, n) * share;
  vec2 kept = max(vec2(1.0f, 1.0f) - face * face * (inside * inside), vec2(1.0e-6f, 1.0e-6f));
  vec2 transmitted = passes * passes * inside / kept;
  vec2 reflected = face * (vec2(1.0f, 1.0f) + transmitted * inside);
  return vec2(0.5f * (reflected.x + reflected.y), 0.5f * (transmitted.x + transmitted.y));
}

// Reflectance and transmittance of a pane per channel.
struct PaneShares {
  vec3 reflected;
  vec3 transmitted;
};

// For faces that are not plain, too; `inside`: internal transmittance of one crossing.
MAQUETTE_FN PaneShares pane_shares(float cos_i, PaneFaces faces, vec3 inside) {
  vec2 passes = face_passes(cos_i, faces);
  vec2 red = fresnel_pane_faces(cos_i, faces.index.x, faces.share, passes, inside.x);
  vec2 green = fresnel_pane_faces(cos_i, faces.index.y, faces.share, passes, inside.y);
  vec2 blue = fresnel_pane_faces(cos_i, faces.index.z, faces.share, passes, inside.z);
  PaneShares shares;
  shares.reflected = vec3(red.x, green.x, blue.x);
  shares.transmitted = vec3(red.y, green.y, blue.y);
  return shares;
}

// The same where all channels are reflected by one index.
MAQUETTE_FN PaneShares plain_pane_shares(float cos_i, float n, vec3 inside) {
  vec2 red = fresnel_pane(cos_i, n, inside.x);
  vec2 green = fresnel_pane(cos_i, n, inside.y);
  vec2 blue = fresnel_pane(cos_i, n, inside.z);
  PaneShares shares;
  shares.reflected = vec3(red.x, green.x, blue.x);
  shares.transmitted = vec3(red.y, green.y, blue.y);
  return shares;
}
