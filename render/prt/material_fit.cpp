#include <algorithm>
#include <cmath>

#include "render/prt/transfer_bake.h"
#include "scenes/btf/broad_light.h"
#include "scenes/btf/half_floats.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

using Eigen::Index;

/// RMS over views, texels and broad lights of what a joint factorisation misses, relative to the RMS of the BTF.
double error_of_joint(const JointBtf& joint, const Btf& btf) {
  const Index own = 1 + btf.components, terms = joint.terms, all = own + terms;
  const std::size_t stored = 3 * static_cast<std::size_t>(own);
  const std::size_t texels = static_cast<std::size_t>(btf.width) * static_cast<std::size_t>(btf.height);
  std::vector<double> lost(btf.views.size(), 0.0), energy(btf.views.size(), 0.0);
  parallel_for(std::size_t{0}, btf.views.size(), [&](std::size_t v) {
    const BtfView& view = btf.views[v];
    std::vector<Eigen::MatrixXd> grams(static_cast<std::size_t>(joint.clusters), Eigen::MatrixXd::Zero(all, all));
    Eigen::Matrix<double, Eigen::Dynamic, 3> factors(all, 3);
    const auto read = [&](const std::uint16_t* halves, Index first, Index count) {
      for (Index c = 0; c < count; ++c)
        for (Index k = 0; k < 3; ++k) factors(first + c, k) = static_cast<double>(float_of_half(halves[3 * c + k]));
    };
    for (std::size_t t = 0; t < texels; ++t) {
      const std::uint16_t* fitted = joint.texels.data() + t * joint.texel_halves();
      read(view.factors.data() + t * stored, 0, own);
      read(fitted + 1, own, terms);
      grams[static_cast<std::size_t>(float_of_half(fitted[0]))] += factors.lazyProduct(factors.transpose());
    }
    Eigen::MatrixXd of_view =
        reflect_broad_lights(*view.lights, light_functions(view, btf.components), static_cast<int>(own));
    const Eigen::MatrixXd of_joint =
        reflect_broad_lights(*view.lights, joint.functions[v], static_cast<int>(joint.function_count()));
    of_view.conservativeResize(Eigen::NoChange, all);
    for (std::size_t cluster = 0; cluster < grams.size(); ++cluster) {
      of_view.rightCols(terms) = -of_joint.middleCols(static_cast<Index>(cluster) * terms, terms);
      lost[v] += broad_light_energy(of_view, grams[cluster]);
      energy[v] += broad_light_energy(of_view.leftCols(own), grams[cluster].topLeftCorner(own, own));
    }
  });
  double sum = 0.0, of = 0.0;
  for (std::size_t v = 0; v < lost.size(); ++v) sum += lost[v], of += energy[v];
  return of > 0.0 ? std::sqrt(std::max(sum, 0.0) / of) : 0.0;
}

}  // namespace

std::optional<MaterialFit> fit_material(const Btf& material, const TransferOptions& options,
                                        const std::atomic<bool>& cancel) {
  const std::vector<double> errors = btf_errors_by_components(material);
  if (cancel) return std::nullopt;
  // The joint form may have more components than the BTF, whose views it holds together.
  const int most = options.joint ? options.btf_components : std::min(options.btf_components, material.components);
  MaterialFit fit{most, 0.0, errors.front(), nullptr};
  if (options.btf_error > 0.0)
    for (fit.components = 0; fit.components < std::min(most, material.components); ++fit.components)
      if (errors[static_cast<std::size_t>(fit.components)] <= options.btf_error) break;
  fit.error = errors[static_cast<std::size_t>(std::min(fit.components, material.components))];
  if (!options.joint) return fit;
  for (;; ++fit.components) {
    fit.joint = fit_joint_btf(material, {options.texel_clusters, fit.components}, cancel);
    if (!fit.joint || cancel) return std::nullopt;
    fit.error = error_of_joint(*fit.joint, material);
    if (fit.components >= most || fit.error <= options.btf_error) return fit;
  }
}

}  // namespace maquette
