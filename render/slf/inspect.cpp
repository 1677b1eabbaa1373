#include "render/slf/inspect.h"

#include <cmath>

#include "render/math/local_pca_fit.h"
#include "render/slf/incident_bake.h"

namespace maquette {

namespace {

constexpr int kClusters[] = {1, 8, 32, 128}, kComponents[] = {2, 4, 8};
/// Texels that the table is computed of; how many there were is printed.
constexpr std::size_t kMostOfTable = 16384;

/// Evenly spaced texels that are not inside other bodies.
std::vector<std::size_t> texels_of_table(const IncidentField& field) {
  std::vector<std::size_t> open, texels;
  for (std::size_t t = 0; t < field.texel_count(); ++t)
    if (!field.masked[t]) open.push_back(t);
  const std::size_t count = std::min(open.size(), kMostOfTable);
  for (std::size_t i = 0; i < count; ++i) texels.push_back(open[i * open.size() / count]);
  return texels;
}

/// Their lumispheres, [3 bin + channel][texel].
Eigen::MatrixXf light_of(const IncidentField& field) {
  const std::vector<std::size_t> texels = texels_of_table(field);
  Eigen::MatrixXf light(3 * field.bins, static_cast<Eigen::Index>(texels.size()));
  for (std::size_t i = 0; i < texels.size(); ++i)
    light.col(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::VectorXf>(field.texel(texels[i]).data(), 3 * field.bins);
  return light;
}

void add_light(const IncidentField& field, BakeFigures* out) {
  const Lumisphere sphere(field.side);
  Eigen::VectorXf measure(3 * sphere.count());
  for (int b = 0; b < sphere.count(); ++b)
    measure.segment(3 * b, 3).setConstant(static_cast<float>(sphere.projected(b)));
  std::size_t masked = 0;
  for (const bool m : field.masked) masked += m ? 1 : 0;
  out->emplace_back("inside_other_bodies", static_cast<double>(masked));
  const Eigen::MatrixXf light = light_of(field);
  if (light.cols() == 0) return;
  const double all = measure.cast<double>().sum() * static_cast<double>(light.cols());
  const double mean = (measure.transpose().cast<double>() * light.cast<double>()).sum() / all;
  out->emplace_back("mean_radiance_cdm2", mean);
  if (!(mean > 0.0)) return;
  out->emplace_back("rms_of_local_pca.of_texels", static_cast<double>(light.cols()));
  for (const int clusters : kClusters)
    for (const int components : kComponents) {
      const LocalPcaFit fit = fit_local_pca(light, measure, {.clusters = clusters, .components = components});
      double squares = 0.0;
      for (const double e : fit.errors) squares += e;
      out->emplace_back(
          "rms_of_local_pca." + std::to_string(clusters) + "_clusters." + std::to_string(components) + "_components",
          std::sqrt(squares / all) / mean);
    }
}

}  // namespace

std::optional<CompressionTable> tabulate_compression(const LightField& field, const std::atomic<bool>& cancel,
                                                     const std::function<void(double)>& progress) {
  constexpr double kOutgoingShare = 0.3;
  const std::vector<std::size_t> texels = texels_of_table(field.incident->field);
  if (texels.empty()) return std::nullopt;
  const auto outgoing = outgoing_of_texels(field, texels, cancel);
  if (!outgoing) return std::nullopt;
  CompressionTable table{{std::begin(kClusters), std::end(kClusters)},
                         {std::begin(kComponents), std::end(kComponents)},
                         {},
                         texels.size()};
  const std::size_t cells = table.clusters.size() * table.components.size();
  for (const int components : kComponents)
    for (const int clusters : kClusters) {
      progress(kOutgoingShare +
               (1.0 - kOutgoingShare) * static_cast<double>(table.errors.size()) / static_cast<double>(cells));
      if (cancel) return std::nullopt;
      LightField compressed;
      compressed.side = field.side;
      compress(outgoing, {clusters, components}, cancel, &compressed);
      table.errors.push_back(compressed.error);
    }
  return cancel ? std::nullopt : std::optional(table);
}

std::optional<BakeFigures> inspect_light_field(const std::string& folder) {
  if (!is_incident_folder(folder)) return std::nullopt;
  const IncidentSummary summary = summarize_incident(folder);
  if (summary.blocks_done < summary.blocks) return std::nullopt;
  BakeFigures figures;
  add_light(load_incident(folder, summary), &figures);
  return figures;
}

}  // namespace maquette
