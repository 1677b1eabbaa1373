#include "render/reference/scattering.h"

namespace maquette {

glm::vec3 lookup_brdf(const BrdfTable& table, const glm::vec3& wi, const glm::vec3& wo) {
  const shared::MerlCell cell = shared::merl_cell(shared::merl_coordinates(wi, wo));
  const glm::vec3* rgb = table.rgb.data();
  const glm::vec3 &f = cell.fraction, g = glm::vec3(1.0f) - f;
  const auto along_phi = [&](int theta_h, int theta_d) {
    const glm::vec3* row = rgb + shared::merl_index(theta_h, theta_d, 0);
    return row[cell.lower.z] * g.z + row[cell.upper.z] * f.z;
  };
  return (along_phi(cell.lower.x, cell.lower.y) * g.y + along_phi(cell.lower.x, cell.upper.y) * f.y) * g.x +
         (along_phi(cell.upper.x, cell.lower.y) * g.y + along_phi(cell.upper.x, cell.upper.y) * f.y) * f.x;
}

Scattering evaluate_scattering(const SurfacePoint& p, const glm::vec3& wi) {
  Scattering s;
  if (wi.z <= 0.0f) return s;
  if (const MeasuredMaterial* measured = p.material->measured.get()) {
    s.f = lookup_brdf(measured->table, wi, p.wo) * p.tint;
    s.pdf = shared::BrdfSampler(measured->tables).brdf_sample_pdf(p.wo, wi);
    return s;
  }
  s.f = shared::evaluate_analytic(p.analytic, wi, p.wo).total;
  s.pdf = shared::analytic_pdf(p.analytic, p.lobe_weights, wi, p.wo);
  return s;
}

ScatteringSample sample_scattering(const SurfacePoint& p, const glm::vec2& u, float lobe) {
  ScatteringSample s;
  if (const MeasuredMaterial* measured = p.material->measured.get()) {
    const auto drawn = shared::BrdfSampler(measured->tables).sample_brdf(p.wo, u);
    s.wi = drawn.wi;
    s.pdf = drawn.pdf;
    if (s.pdf > 0.0f) s.f = lookup_brdf(measured->table, s.wi, p.wo) * p.tint;
    return s;
  }
  s.wi = shared::sample_analytic(p.analytic, p.lobe_weights, p.wo, u.x, u.y, lobe);
  if (s.wi.z <= 0.0f) return s;
  s.f = shared::evaluate_analytic(p.analytic, s.wi, p.wo).total;
  s.pdf = shared::analytic_pdf(p.analytic, p.lobe_weights, s.wi, p.wo);
  return s;
}

}  // namespace maquette
