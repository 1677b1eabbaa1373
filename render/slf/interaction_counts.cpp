#include "render/slf/interaction_counts.h"

#include <array>
#include <numeric>
#include <optional>

namespace maquette {

namespace {

/// From light that varies much to a material that does. Every step leaves more error of the light and less of the
/// material.
constexpr std::array<InteractionCounts, 7> kCounts{
    {{64, 8, 4}, {64, 8, 8}, {32, 8, 8}, {32, 8, 16}, {16, 8, 16}, {8, 8, 16}, {8, 4, 16}}};
constexpr Eigen::Index kTexels = 4096;
constexpr int kRounds = 6;

}  // namespace

LocalPcaSketch sketch_interactions(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure) {
  return sketch_for_local_pca(samples, measure, kTexels);
}

InteractionCounts choose_interaction_counts(const LocalPcaSketch& light,
                                            const std::vector<InteractionMaterial>& materials,
                                            const std::function<int(const InteractionCounts&)>& clusters_of,
                                            const std::atomic<bool>& cancel) {
  if (materials.empty()) return kCounts.front();
  const auto mean_error = [&](const LocalPcaSketch& sketch, int clusters, int components) {
    LocalPcaOptions options{.clusters = clusters, .components = components, .rounds = kRounds};
    options.stop = [&cancel] { return cancel.load(); };
    const LocalPcaFit fit = fit_local_pca(sketch.samples, {}, options);
    const double sum = std::accumulate(fit.errors.begin(), fit.errors.end(), 0.0);
    return sketch.lost + sum / static_cast<double>(sketch.samples.cols());
  };
  struct Errors {
    double light = 0.0, materials = 0.0;
  };
  std::array<std::optional<Errors>, kCounts.size()> known;
  const auto errors_at = [&](std::size_t step) {
    if (known[step]) return *known[step];
    const InteractionCounts& counts = kCounts[step];
    Errors e;
    e.light = mean_error(light, counts.light_clusters, counts.light_components);
    for (const InteractionMaterial& m : materials)
      e.materials += m.texels * mean_error(m.sketch, clusters_of(counts), counts.material_components);
    known[step] = e;
    return e;
  };
  std::size_t first = 0, last = kCounts.size() - 1;  // where light errs as much as the materials, or more
  while (first < last && !cancel) {
    const std::size_t middle = (first + last) / 2;
    if (errors_at(middle).light < errors_at(middle).materials)
      first = middle + 1;
    else
      last = middle;
  }
  const auto sum_at = [&](std::size_t step) { return errors_at(step).light + errors_at(step).materials; };
  return kCounts[first > 0 && !cancel && sum_at(first - 1) < sum_at(first) ? first - 1 : first];
}

}  // namespace maquette
