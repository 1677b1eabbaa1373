#include "render/slf/inspect.h"

#include <algorithm>
#include <cmath>

#include "render/math/local_pca_fit.h"
#include "render/parts/baked_parts.h"
#include "render/slf/incident_bake.h"
#include "scenes/error.h"
#include "scenes/node_paths.h"

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

/// [3 bin + channel]
Eigen::VectorXf projected_measure(const IncidentField& field) {
  const Lumisphere sphere(field.side);
  Eigen::VectorXf measure(3 * sphere.count());
  for (int b = 0; b < sphere.count(); ++b)
    measure.segment(3 * b, 3).setConstant(static_cast<float>(sphere.projected(b)));
  return measure;
}

double mean_of(const Eigen::MatrixXf& light, const Eigen::VectorXf& measure) {
  if (light.cols() == 0) return 0.0;
  return (measure.transpose().cast<double>() * light.cast<double>()).sum() /
         (measure.cast<double>().sum() * static_cast<double>(light.cols()));
}

void add_light(const IncidentField& field, BakeFigures* out) {
  std::size_t masked = 0;
  for (const bool m : field.masked) masked += m ? 1 : 0;
  out->emplace_back("inside_other_bodies", static_cast<double>(masked));
  out->emplace_back("mean_radiance_cdm2", mean_of(light_of(field), projected_measure(field)));
}

std::string table_entry(const char* light, int clusters, int components) {
  return std::string("rms_of_local_pca.of_light_that_") + light + "." + std::to_string(clusters) + "_clusters." +
         std::to_string(components) + "_components";
}

void add_table_of_arriving(const IncidentField& field, BakeFigures* out) {
  const Eigen::MatrixXf light = light_of(field);
  const Eigen::VectorXf measure = projected_measure(field);
  const double mean = mean_of(light, measure);
  if (!(mean > 0.0)) return;
  const double all = measure.cast<double>().sum() * static_cast<double>(light.cols());
  out->emplace_back("rms_of_local_pca.of_texels", static_cast<double>(light.cols()));
  for (const int clusters : kClusters)
    for (const int components : kComponents) {
      const LocalPcaFit fit = fit_local_pca(light, measure, {.clusters = clusters, .components = components});
      double squares = 0.0;
      for (const double e : fit.errors) squares += e;
      out->emplace_back(table_entry("arrives", clusters, components), std::sqrt(squares / all) / mean);
    }
}

/// The field of the folder, uncompressed, over the scene with its own materials. Throws Error where the scene is not
/// the one that was baked.
std::shared_ptr<const LightField> load_field(const std::string& folder, const IncidentSummary& summary,
                                             const Scene& scene) {
  LightFieldJob job;
  job.scene = std::make_shared<const Scene>(scene);
  IncidentJob& incident = job.incident;
  incident.scene = job.scene;
  incident.geometry = std::make_shared<const FlatGeometry>(flatten(scene));
  const std::vector<std::string> paths = node_paths(scene);
  for (std::size_t i = 0; i < incident.geometry->items.size(); ++i) {
    const DrawItem& item = incident.geometry->items[i];
    if (item.node < 0 || std::ranges::find(summary.contents.parts, paths[static_cast<std::size_t>(item.node)]) ==
                             summary.contents.parts.end())
      continue;
    const int material = material_of_item(scene, item, incident.variant);
    incident.parts.push_back({i, material >= 0 && scene.materials[static_cast<std::size_t>(material)].double_sided});
  }
  incident.atlas.side = summary.provenance.atlas_side;
  incident.options.side = summary.provenance.lumisphere_side;
  incident.options.paths = summary.provenance.paths;
  incident.folder = folder;
  incident.must_work = incident.show_stale = true;  // what light it was is as it was
  incident.may_make = false;
  job.compression.clusters = 0;
  LightFieldMemory memory;
  return make_light_field(job, &memory, std::atomic<bool>{false}, {});
}

void add_table_of_leaving(const LightField& field, BakeFigures* out) {
  const auto table = tabulate_compression(field, std::atomic<bool>{false}, [](double) {});
  if (!table) return;
  out->emplace_back("rms_of_local_pca.of_texels", static_cast<double>(table->vectors));
  for (std::size_t k = 0; k < table->clusters.size(); ++k)
    for (std::size_t c = 0; c < table->components.size(); ++c)
      out->emplace_back(table_entry("leaves", table->clusters[k], table->components[c]), table->error(c, k));
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

std::optional<BakeFigures> inspect_light_field(const std::string& folder, const Scene* scene) {
  if (!is_incident_folder(folder)) return std::nullopt;
  const IncidentSummary summary = summarize_incident(folder);
  BakeFigures figures{{"blocks", static_cast<double>(summary.blocks)}};
  if (summary.blocks_done < summary.blocks) return figures;
  const IncidentField light = load_incident(folder, summary);
  add_light(light, &figures);
  std::shared_ptr<const LightField> field;
  try {
    if (scene) field = load_field(folder, summary, *scene);
  } catch (const Error&) {  // dented, turned, or another one
  }
  figures.emplace_back("is_of_the_scene", field ? 1.0 : 0.0);
  if (field)
    add_table_of_leaving(*field, &figures);
  else
    add_table_of_arriving(light, &figures);
  return figures;
}

}  // namespace maquette
