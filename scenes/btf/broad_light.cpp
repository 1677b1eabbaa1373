#include "scenes/btf/broad_light.h"

#include <algorithm>
#include <cmath>

#include "scenes/btf/half_floats.h"
#include "scenes/parallel.h"

namespace maquette {

using Eigen::Index;

Eigen::MatrixXd reflect_broad_lights(const DirectionMesh& lights, const std::vector<float>& functions, int count) {
  const double cosine = std::sqrt(0.5);  // 45 degrees to each side
  const std::vector<glm::dvec3> caps = ubo_directions();
  const std::vector<double> shares = lights.quadrature().projected;
  const auto stride = static_cast<std::size_t>(count);
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(static_cast<Index>(caps.size()), count);
  for (std::size_t cap = 0; cap < caps.size(); ++cap)
    for (std::size_t l = 0; l < lights.size(); ++l) {
      if (glm::dot(caps[cap], lights.directions()[l]) < cosine) continue;
      for (std::size_t k = 0; k < stride; ++k)
        sums(static_cast<Index>(cap), static_cast<Index>(k)) +=
            shares[l] * static_cast<double>(functions[l * stride + k]);
    }
  return sums;
}

double broad_light_energy(const Eigen::Ref<const Eigen::MatrixXd>& reflected,
                          const Eigen::Ref<const Eigen::MatrixXd>& gram) {
  return reflected.lazyProduct(gram).cwiseProduct(reflected).sum();
}

std::vector<float> light_functions(const BtfView& view, int components) {
  const auto count = static_cast<std::size_t>(components);
  std::vector<float> functions;
  for (std::size_t l = 0; l < view.lights->size(); ++l) {
    functions.push_back(1.0f);
    for (std::size_t c = 0; c < count; ++c) functions.push_back(view.light_weights[l * count + c]);
  }
  return functions;
}

std::vector<double> btf_errors_by_components(const Btf& btf) {
  const Index terms = 1 + btf.components;
  const std::size_t stored = 3 * static_cast<std::size_t>(terms);
  const std::size_t texels = static_cast<std::size_t>(btf.width) * static_cast<std::size_t>(btf.height);
  std::vector<Eigen::VectorXd> lost(btf.views.size());  // [view][terms kept]
  parallel_for(std::size_t{0}, btf.views.size(), [&](std::size_t v) {
    const BtfView& view = btf.views[v];
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(terms, terms);
    Eigen::Matrix<double, Eigen::Dynamic, 3> factors(terms, 3);
    for (std::size_t t = 0; t < texels; ++t) {
      for (Index c = 0; c < terms; ++c)
        for (Index k = 0; k < 3; ++k)
          factors(c, k) =
              static_cast<double>(float_of_half(view.factors[t * stored + static_cast<std::size_t>(3 * c + k)]));
      gram += factors.lazyProduct(factors.transpose());
    }
    const Eigen::MatrixXd reflected =
        reflect_broad_lights(*view.lights, light_functions(view, btf.components), static_cast<int>(terms));
    lost[v] = Eigen::VectorXd::Zero(terms + 1);
    for (Index kept = 0; kept < terms; ++kept)
      lost[v][kept] =
          broad_light_energy(reflected.rightCols(terms - kept), gram.bottomRightCorner(terms - kept, terms - kept));
  });
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(terms + 1);
  for (const Eigen::VectorXd& of_view : lost) sum += of_view;
  std::vector<double> errors;
  for (Index kept = 1; kept <= terms; ++kept)
    errors.push_back(sum[0] > 0.0 ? std::sqrt(std::max(sum[kept], 0.0) / sum[0]) : 0.0);
  return errors;
}

}  // namespace maquette
