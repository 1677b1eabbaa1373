#include "render/reference/scattering.h"

#include <algorithm>

namespace maquette {

LobeChoice choose_lobe(const glm::vec3& weights, float u) {
  const int lobe = u < weights.x ? 0 : u < weights.x + weights.y ? 1 : 2;
  const float begin = lobe == 0 ? 0.0f : lobe == 1 ? weights.x : weights.x + weights.y;
  return {lobe, weights[lobe] > 0.0f ? std::clamp((u - begin) / weights[lobe], 0.0f, 0x1.fffffep-1f) : 0.0f};
}

namespace {

/// Prefetches what density_of reads; `half` is set.
void prepare_density(const MeasuredMaterial& measured, int elevation, ScatteringQuery* query) {
  const int row = elevation * kThetaCellCount;
  query->theta_cell = shared::find_theta_cell(measured.tables.theta_cells.data() + row, query->half.t);
  query->theta = measured.tables.theta_cells.data() + row + query->theta_cell;
  query->phis = measured.tables.phi_cells.data() + (row + query->theta_cell) * kPhiCellCount;
  for (int p : {0, kPhiCellCount / 2, kPhiCellCount - 1}) __builtin_prefetch(query->phis + p);
}
void prepare_density(const MeasuredMaterial& measured, const glm::vec3& wo, ScatteringQuery* query) {
  shared::BrdfSampler sampler(measured.tables);
  query->half = sampler.half_vector_position(wo, query->wi);
  prepare_density(measured, sampler.brdf_elevation(wo), query);
}

float density_of(const MeasuredMaterial& measured, const glm::vec3& wo, const ScatteringQuery& query) {
  const int p = shared::find_phi_cell(query.phis, query.half.phi);
  return shared::BrdfSampler(measured.tables)
      .density_in_cell(wo, query.wi, query.half, query.theta_cell, *query.theta, query.phis[p]);
}

}  // namespace

BrdfQuery prepare_brdf(const SurfacePoint& p, const glm::vec3& wi) {
  BrdfQuery query{wi, {}};
  if (const MeasuredMaterial* measured = p.material->measured.get()) {
    query.cell = PackedBrdf::cell_of(shared::merl_cell(shared::merl_coordinates(wi, p.wo)));
    measured->values.prefetch(query.cell);
  }
  return query;
}

ScatteringQuery prepare_scattering(const SurfacePoint& p, const glm::vec3& wi) {
  ScatteringQuery query{prepare_brdf(p, wi)};
  if (const MeasuredMaterial* measured = p.material->measured.get()) prepare_density(*measured, p.wo, &query);
  return query;
}

void QueryBatch::add(const SurfacePoint& p, BrdfQuery* query, ScatteringQuery* density) {
  const MeasuredMaterial* measured = p.material->measured.get();
  if (!measured) return;
  lanes_.wi.set(count_, query->wi);
  lanes_.wo.set(count_, p.wo);
  waiting_[count_++] = {measured, query, density};
  if (count_ == BrdfLanes::kCount) complete();
}

void QueryBatch::complete() {
  if (count_ == 0) return;
  lanes_.compute();
  for (std::size_t i = 0; i < count_; ++i) {
    const Waiting& w = waiting_[i];
    w.query->cell = lanes_.cell(i);
    w.measured->values.prefetch(w.query->cell);
    if (!w.density) continue;
    w.density->half = {lanes_.coordinates.t[i], lanes_.coordinates.phi[i], lanes_.coordinates.length_sum[i]};
    prepare_density(*w.measured, lanes_.coordinates.elevation[i], w.density);
  }
  count_ = 0;
}

glm::vec3 evaluate_brdf(const SurfacePoint& p, const BrdfQuery& query) {
  if (const MeasuredMaterial* measured = p.material->measured.get())
    return measured->values.look_up(query.cell) * p.tint;
  if (const Btf* btf = p.material->btf.get()) return evaluate_btf(*btf, p.btf, query.wi, p.wo) * p.tint;
  return shared::evaluate_analytic(p.analytic, query.wi, p.wo).total;
}

float scattering_pdf(const SurfacePoint& p, const glm::vec3& wi) {
  if (const MeasuredMaterial* measured = p.material->measured.get()) {
    ScatteringQuery query{{wi, {}}};
    prepare_density(*measured, p.wo, &query);
    return density_of(*measured, p.wo, query);
  }
  return shared::analytic_pdf(p.analytic, p.lobe_weights, wi, p.wo);
}

Scattering evaluate_scattering(const SurfacePoint& p, const ScatteringQuery& query) {
  const MeasuredMaterial* measured = p.material->measured.get();
  return {evaluate_brdf(p, query), measured ? density_of(*measured, p.wo, query) : scattering_pdf(p, query.wi)};
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
  choice.cell = sampler.brdf_cell_of(u);
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
  if (s.pdf > 0.0f) s.f = evaluate_brdf(p, prepare_brdf(p, s.wi));
  return s;
}

}  // namespace maquette
