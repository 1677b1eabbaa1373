#pragma once

#include <atomic>
#include <functional>
#include <vector>

#include "render/math/local_pca_fit.h"

namespace maquette {

/// How the table of Interactions is divided: the clusters of materials are as many as there is room for.
struct InteractionCounts {
  int light_clusters = 64, light_components = 8, material_components = 4;
};

/// Light or a material, by which the counts are chosen.
LocalPcaSketch sketch_interactions(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure);
struct InteractionMaterial {
  LocalPcaSketch sketch;
  double texels = 0.0;
};

/// Of seven divisions the one with the least sum of squared errors of light and materials. Both errors are sums over
/// texels of squared outgoing light; that of `light` has them in its metric. `clusters_of`: of each material, with
/// these counts.
InteractionCounts choose_interaction_counts(const LocalPcaSketch& light,
                                            const std::vector<InteractionMaterial>& materials,
                                            const std::function<int(const InteractionCounts&)>& clusters_of,
                                            const std::atomic<bool>& cancel);

}  // namespace maquette
