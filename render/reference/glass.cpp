#include "render/reference/glass.h"

#include <algorithm>
#include <cmath>

namespace maquette {

namespace {

/// G2 of both directions over G1 of `cosine_out`: height-correlated Smith masking and shadowing.
float shadowing(float cosine_in, float cosine_out, float alpha) {
  if (alpha <= 0.0f) return 1.0f;
  const auto at = [](float c) { return glm::vec3(std::sqrt(std::max(1.0f - c * c, 0.0f)), 0.0f, c); };
  const shared::GgxWidth width = shared::round_width(alpha);
  return 4.0f * cosine_in * cosine_out * shared::ggx_visibility(at(cosine_in), at(cosine_out), width) /
         std::max(shared::ggx_g1(at(cosine_out), width), 1e-20f);
}

/// Entries of the Mueller matrices of an interface: mean and half difference of the reflectances of both polarisations
/// (perpendicular and parallel to the plane of incidence), and the factors of U.
struct Interface {
  float reflected = 1.0f, difference = 0.0f, reflected_u = 1.0f, passed_u = 0.0f;
  float other = -1.0f;  ///< cosine of the refracted ray; negative: total internal reflection
};

/// `eta`: refractive index of this side over that of the other. Source: Born and Wolf 1999, Sec. 1.5.2, Eq. 21, and
/// 1.5.4, Eq. 60.
Interface fresnel_at_interface(float cosine, float eta) {
  Interface f;
  const float cosine2 = 1.0f - eta * eta * (1.0f - cosine * cosine);
  if (cosine2 <= 0.0f) {
    const float k = std::sqrt(-cosine2), c = std::max(cosine, 1e-20f);
    f.reflected_u = std::cos(2.0f * (std::atan2(eta * k, c) - std::atan2(k, eta * c)));
    return f;
  }
  f.other = std::sqrt(cosine2);
  const float s = (eta * cosine - f.other) / (eta * cosine + f.other);
  const float p = (cosine - eta * f.other) / (cosine + eta * f.other);
  f.reflected = 0.5f * (s * s + p * p);
  f.difference = 0.5f * (s * s - p * p);
  f.reflected_u = s * p;
  f.passed_u = std::sqrt((1.0f - s * s) * (1.0f - p * p));
  return f;
}

/// Rotates the Stokes parameters into the plane of incidence.
void rotate_to_incidence_plane(const glm::vec3& direction, const glm::vec3& facet, Polarisation* state) {
  const glm::vec3 across = glm::cross(direction, facet);
  const float length = glm::length(across);
  if (!(length > 1e-6f)) return;  // normal incidence: any plane will do
  const glm::vec3 axis = across / length;
  const float c = glm::dot(state->axis, axis), s = glm::dot(glm::cross(direction, state->axis), axis);
  const float c2 = c * c - s * s, s2 = 2.0f * s * c, q = state->q, u = state->u;
  *state = {q * c2 + u * s2, u * c2 - q * s2, axis};
}

/// Reflects or refracts about `facet`, with the Fresnel reflectance as probability.
GlassSample refract_or_mirror(const glm::vec3& direction, const glm::vec3& facet, float eta, float choice,
                              Polarisation* state) {
  const float cosine = std::clamp(-glm::dot(direction, facet), 0.0f, 1.0f);
  const Interface f = fresnel_at_interface(cosine, eta);
  rotate_to_incidence_plane(direction, facet, state);
  const float reflectance = f.reflected + f.difference * state->q;
  GlassSample sample;
  sample.passed = f.other >= 0.0f && choice >= reflectance;
  if (sample.passed) {
    sample.direction = glm::normalize(direction * eta + facet * (eta * cosine - f.other));
    sample.weight = glm::vec3(eta * eta);  // radiance over the squared index is conserved
    const float share = 1.0f - reflectance;
    *state = {((1.0f - f.reflected) * state->q - f.difference) / share, f.passed_u * state->u / share, state->axis};
  } else {
    sample.direction = direction + facet * (2.0f * cosine);
    sample.weight = glm::vec3(1.0f);
    const float share = std::max(reflectance, 1e-20f);
    *state = {(f.difference + f.reflected * state->q) / share, f.reflected_u * state->u / share, state->axis};
  }
  return sample;
}

/// The same of a face that does not reflect as its index says, for unpolarised light.
GlassSample refract_or_mirror(const glm::vec3& direction, const glm::vec3& facet, float eta, float choice,
                              const shared::PaneFaces& faces) {
  const float cosine = std::clamp(-glm::dot(direction, facet), 0.0f, 1.0f);
  const float other = fresnel_at_interface(cosine, eta).other, outside = eta <= 1.0f ? cosine : other;
  GlassSample sample;
  sample.direction = direction + facet * (2.0f * cosine);
  sample.weight = glm::vec3(1.0f);
  if (other < 0.0f) return sample;  // total internal reflection
  glm::vec3 reflected{};
  for (int c = 0; c < 3; ++c) reflected[c] = faces.share * shared::fresnel_surface(outside, faces.index[c]);
  const float probability = std::clamp(largest(reflected), 0.0f, 1.0f);
  sample.passed = choice >= probability;
  sample.weight = reflected / std::max(probability, 1e-20f);
  if (!sample.passed) return sample;
  const glm::vec2 passes = shared::face_passes(outside, faces);
  sample.direction = glm::normalize(direction * eta + facet * (eta * cosine - other));
  sample.weight = glm::vec3(eta * eta * 0.5f * (passes.x + passes.y) / (1.0f - probability));
  return sample;
}

GlassSample sample_solid_glass(const SurfacePoint& p, const glm::vec3& direction, float alpha, const glm::vec2& u,
                               float choice, Polarisation* polarisation) {
  const float index = std::max(p.material->values.ior, 1.0f);
  const float eta = p.front ? 1.0f / index : index;
  const glm::vec3 facet =
      alpha > 0.0f ? p.to_world(shared::sample_ggx_visible(p.wo, shared::round_width(alpha), u.x, u.y)) : p.n;
  const Polarisation before = *polarisation;
  const auto leave = [&](const glm::vec3& normal) {
    if (shared::is_plain(p.faces)) return refract_or_mirror(direction, normal, eta, choice, polarisation);
    *polarisation = {};
    return refract_or_mirror(direction, normal, eta, choice, p.faces);
  };
  GlassSample sample = leave(facet);
  const float side = glm::dot(sample.direction, p.normal);
  // The shading normal sent the ray to the wrong side of the geometric surface: use the geometric normal instead.
  if (sample.passed ? side >= 0.0f : side <= 0.0f) {
    *polarisation = before;
    sample = leave(p.normal);
  }
  sample.weight *= shadowing(std::abs(glm::dot(sample.direction, p.n)), p.wo.z, alpha);
  // The base colour tints once for each crossing of the body: where the ray enters.
  if (sample.passed && p.front) sample.weight *= glm::clamp(p.base_color, 0.0f, 1.0f);
  return sample;
}

GlassSample sample_rough_pane(const SurfacePoint& p, float alpha, const glm::vec2& u, float choice) {
  GlassSample sample;
  const glm::vec3 facet = shared::sample_ggx_visible(p.wo, shared::round_width(alpha), u.x, u.y);
  const float cosine = std::clamp(glm::dot(p.wo, facet), 0.0f, 1.0f);
  glm::vec3 wi = facet * (2.0f * cosine) - p.wo;
  if (wi.z <= 0.0f) return sample;  // masked by other facets
  const PaneShares shares = shares_of_pane(cosine, p.faces, glm::clamp(p.base_color, 0.0f, 1.0f));
  const float reflect = largest(shares.reflected), pass = largest(shares.transmitted);
  if (!(reflect + pass > 0.0f)) return sample;
  const float probability = reflect / (reflect + pass);
  sample.passed = choice >= probability;
  sample.weight = (sample.passed ? shares.transmitted / (1.0f - probability) : shares.reflected / probability) *
                  shadowing(wi.z, p.wo.z, alpha);
  if (sample.passed) wi.z = -wi.z;
  sample.direction = glm::normalize(p.to_world(wi));
  const float side = glm::dot(sample.direction, p.normal);
  if (sample.passed ? side >= 0.0f : side <= 0.0f) sample.weight = glm::vec3(0.0f);
  return sample;
}

}  // namespace

GlassSample sample_glass(const SurfacePoint& p, const glm::vec3& direction, float alpha, const glm::vec2& u,
                         float choice, Polarisation* polarisation) {
  if (!p.material->solid) return sample_rough_pane(p, alpha, u, choice);
  return sample_solid_glass(p, direction, alpha, u, choice, polarisation);
}

}  // namespace maquette
