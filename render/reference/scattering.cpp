#include "render/reference/scattering.h"

#include <algorithm>

namespace maquette {

LobeChoice choose_lobe(const glm::vec3& weights, float u) {
  const int lobe = u < weights.x ? 0 : u < weights.x + weights.y ? 1 : 2;
  const float begin = lobe == 0 ? 0.0f : lobe == 1 ? weights.x : weights.x + weights.y;
  return {lobe, weights[lobe] > 0.0f ? std::clamp((u - begin) / weights[lobe], 0.0f, 0x1.fffffep-1f) : 0.0f};
}

ScatteringQuery prepare_scattering(const SurfacePoint& p, const glm::vec3& wi) {
  ScatteringQuery query{wi, {}};
  if (const MeasuredMaterial* measured = p.material->measured.get()) {
    query.cell = shared::merl_cell(shared::merl_coordinates(wi, p.wo));
    measured->values.prefetch(query.cell);
  }
  return query;
}

glm::vec3 evaluate_brdf(const SurfacePoint& p, const ScatteringQuery& query) {
  if (const MeasuredMaterial* measured = p.material->measured.get())
    return measured->values.look_up(query.cell) * p.tint;
  return shared::evaluate_analytic(p.analytic, query.wi, p.wo).total;
}

float scattering_pdf(const SurfacePoint& p, const glm::vec3& wi) {
  if (const MeasuredMaterial* measured = p.material->measured.get())
    return shared::BrdfSampler(measured->tables).brdf_sample_pdf(p.wo, wi);
  return shared::analytic_pdf(p.analytic, p.lobe_weights, wi, p.wo);
}

Scattering evaluate_scattering(const SurfacePoint& p, const ScatteringQuery& query) {
  return {evaluate_brdf(p, query), scattering_pdf(p, query.wi)};
}

Scattering evaluate_scattering(const SurfacePoint& p, const glm::vec3& wi) {
  return wi.z > 0.0f ? evaluate_scattering(p, prepare_scattering(p, wi)) : Scattering();
}

ScatteringChoice choose_scattering(const SurfacePoint& p, const glm::vec2& u) {
  ScatteringChoice choice;
  choice.u = u;
  const MeasuredMaterial* measured = p.material->measured.get();
  if (!measured) return choice;
  shared::BrdfSampler sampler(measured->tables);
  const int row = sampler.brdf_elevation(p.wo) * kThetaCellCount;
  const glm::vec2* theta_cells = measured->tables.theta_cells.data() + row;
  for (int k = 0; k < kThetaCellCount; k += 8) __builtin_prefetch(theta_cells + k);
  choice.cell = sampler.choose_brdf_cell(u);
  choice.theta_cell = theta_cells + choice.cell.theta.k;
  choice.phi_cell = measured->tables.phi_cells.data() + (row + choice.cell.theta.k) * kPhiCellCount + choice.cell.p;
  __builtin_prefetch(choice.phi_cell);
  return choice;
}

DrawnDirection draw_scattering(const SurfacePoint& p, const ScatteringChoice& choice) {
  if (const MeasuredMaterial* measured = p.material->measured.get()) {
    const auto drawn = shared::BrdfSampler(measured->tables)
                           .brdf_sample_in_cell(p.wo, choice.cell, *choice.theta_cell, *choice.phi_cell);
    return {drawn.wi, drawn.pdf};
  }
  const LobeChoice chosen = choose_lobe(p.lobe_weights, choice.u.x);
  DrawnDirection d;
  d.wi = shared::sample_analytic(p.analytic, chosen.lobe, p.wo, chosen.within, choice.u.y);
  if (d.wi.z > 0.0f) d.pdf = shared::analytic_pdf(p.analytic, p.lobe_weights, d.wi, p.wo);
  return d;
}

ScatteringSample sample_scattering(const SurfacePoint& p, const glm::vec2& u) {
  const DrawnDirection d = draw_scattering(p, choose_scattering(p, u));
  ScatteringSample s{d.wi, glm::vec3(0.0f), d.pdf};
  if (s.pdf > 0.0f) s.f = evaluate_brdf(p, prepare_scattering(p, s.wi));
  return s;
}

}  // namespace maquette
