#include "render/slf/interactions.h"

#include <cmath>
#include <map>

#include "render/slf/direction_spline.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// What all material clusters make of one term of the light.
void fill_columns(const InteractionTerms& terms, int light, int light_term, Interactions* out) {
  using Channel = Eigen::Map<Eigen::VectorXf, 0, Eigen::InnerStride<>>;
  using Light = Eigen::Map<const Eigen::VectorXf, 0, Eigen::InnerStride<>>;
  const Eigen::Index bins = terms.light.rows() / 3;
  const float* arriving = terms.light.col(light * terms.codes.light_terms + light_term).data();
  for (Eigen::Index c = 0; c < 3; ++c) {
    const Eigen::VectorXf incident = Light(arriving + c, bins, Eigen::InnerStride<>(3));
    std::map<const BtfResponse*, Eigen::VectorXf> of_btf;
    for (int m = 0; m < terms.codes.material_clusters; ++m) {
      const MaterialCluster& cluster = terms.materials[static_cast<std::size_t>(m)];
      if (cluster.btf && !of_btf.contains(cluster.btf.get()))
        of_btf[cluster.btf.get()] = cluster.btf->light_of_terms(incident);
      for (Eigen::Index k = 0; k < cluster.terms(); ++k) {
        const auto column = static_cast<Eigen::Index>(out->column(light, m, light_term, static_cast<int>(k)));
        Channel leaving(out->table.col(column).data() + c, bins, Eigen::InnerStride<>(3));
        if (cluster.btf)
          leaving = cluster.btf->apply_factors(cluster.factors.col(k), c, of_btf.at(cluster.btf.get()));
        else
          leaving = cluster.responses[static_cast<std::size_t>(k)].channels[static_cast<std::size_t>(c)] * incident;
      }
    }
  }
}

}  // namespace

std::shared_ptr<const Interactions> compute_interactions(const InteractionTerms& terms,
                                                         const std::atomic<bool>& cancel) {
  auto out = std::make_shared<Interactions>();
  out->codes = terms.codes;
  const int clusters = terms.codes.light_clusters;
  out->table = Eigen::MatrixXf::Zero(terms.light.rows(), static_cast<Eigen::Index>(out->column(clusters, 0, 0, 0)));
  parallel_for(0, clusters, [&](int light) {
    for (int i = 0; i < terms.codes.light_terms && !cancel; ++i) fill_columns(terms, light, i, out.get());
  });
  if (cancel) return nullptr;
  return out;
}

Eigen::VectorXf Interactions::decode(std::size_t texel) const {
  const auto t = static_cast<Eigen::Index>(texel);
  Eigen::VectorXf sum = Eigen::VectorXf::Zero(table.rows());
  for (int i = 0; i < codes.light_terms; ++i)
    for (int k = 0; k < codes.material_terms; ++k) {
      const auto from =
          table.col(static_cast<Eigen::Index>(column(codes.light_cluster[texel], codes.material_cluster[texel], i, k)));
      for (int c = 0; c < 3; ++c) {
        const float weight = (i == 0 ? 1.0f : codes.light_weights(i - 1, t)) * codes.material_weights(3 * k + c, t);
        for (Eigen::Index row = c; row < sum.size(); row += 3) sum[row] += weight * from[row];
      }
    }
  return sum;
}

double interaction_error(const Interactions& interactions, const OutgoingField& field, int side, std::size_t step) {
  const DirectionSpline spline{Lumisphere(side)};
  const Lumisphere& sphere = spline.lumisphere();
  double squares = 0.0, sum = 0.0, all = 0.0;
  for (std::size_t t = 0; t < interactions.codes.turns.size(); t += step) {
    const Eigen::VectorXf own = interactions.decode(t);
    const auto truth = field.radiance.col(static_cast<Eigen::Index>(t));
    for (int b = 0; b < sphere.count(); ++b) {
      const double area = sphere.solid_angle(b);
      glm::dvec3 a(0.0), e(0.0);
      for (const DirectionSpline::Share& s : spline.shares(interactions.codes.turns[t].to_btf(sphere.direction(b))))
        for (int c = 0; c < 3; ++c) a[c] += static_cast<double>(s.weight) * static_cast<double>(own[3 * s.bin + c]);
      for (const DirectionSpline::Share& s : spline.shares(sphere.direction(b)))
        for (int c = 0; c < 3; ++c) e[c] += static_cast<double>(s.weight) * static_cast<double>(truth[3 * s.bin + c]);
      squares += area * glm::dot(a - e, a - e);
      sum += area * (e.x + e.y + e.z);
      all += 3.0 * area;
    }
  }
  return sum > 0.0 ? std::sqrt(squares / all) / (sum / all) : 0.0;
}

}  // namespace maquette
