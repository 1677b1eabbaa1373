#pragma once

#include <Eigen/Core>
#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "render/slf/btf_response.h"
#include "render/slf/incident.h"
#include "render/slf/interaction_counts.h"
#include "render/slf/response.h"

namespace maquette {

struct PathScene;

struct InteractionOptions {
  std::optional<InteractionCounts> counts = {};     ///< none: those that leave the least error
  std::size_t most_bytes = std::size_t{128} << 20;  ///< of the table: decides the number of material clusters
  float texel_m = 0.0f;                             ///< textures are filtered over this; 0: not
};

/// What light and materials of texels are compressed to. Weights are at most 1 for each term of each cluster, so that
/// sunlit and dark clusters both fit half floats.
struct InteractionCodes {
  int light_terms = 1, material_terms = 1;  ///< 1 + components
  int light_clusters = 0, material_clusters = 0;
  std::vector<std::uint16_t> light_cluster, material_cluster;  ///< [texel]
  std::vector<BtfTurn> turns;                                  ///< [texel]
  Eigen::MatrixXf light_weights;                               ///< [component][texel]
  Eigen::MatrixXf material_weights;  ///< [3 term + channel][texel]: coloured, for tints and base colours
};

/// What one cluster of a material makes of light: a linear map for each term.
struct MaterialCluster {
  Eigen::Index terms() const { return btf ? factors.cols() : static_cast<Eigen::Index>(responses.size()); }
  std::shared_ptr<const BtfResponse> btf;  ///< may outlive its Btf: only light and views are read
  Eigen::MatrixXf factors;                 ///< of a BTF: [(view, factor), 3 channels][term]
  std::vector<LightResponse> responses;    ///< of others: [term]
};

/// Arriving light and materials, both by local PCA in the materials' frames. Source: seed 001, 10.1 (its second way).
struct InteractionTerms {
  InteractionCodes codes;
  Eigen::MatrixXf light;  ///< [3 bin + channel][light cluster * light_terms + term]
  std::vector<MaterialCluster> materials;
};

/// From incident light and the materials of `scene`, as compute_outgoing. Throws Error for materials of which every
/// texel has a response of its own. Null once cancelled.
std::shared_ptr<const InteractionTerms> compress_interactions(const PathScene& scene, const LightFieldAtlas& atlas,
                                                              const IncidentField& incident,
                                                              const InteractionOptions& options,
                                                              const std::atomic<bool>& cancel);

}  // namespace maquette
