#pragma once

#include <Eigen/Core>
#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "render/slf/btf_response.h"
#include "render/slf/incident.h"
#include "render/slf/interaction_counts.h"
#include "render/slf/outgoing.h"

namespace maquette {

struct InteractionOptions {
  std::optional<InteractionCounts> counts = {};     ///< none: those that leave the least error
  std::size_t most_bytes = std::size_t{128} << 20;  ///< of the table: decides the number of material clusters
  float texel_m = 0.0f;                             ///< textures are filtered over this; 0: not
};

/// Outgoing light that is not stored: arriving light and material, both by local PCA, and a table of what each term of
/// the one makes of each of the other. Light towards a direction is the sum over terms i, k of
/// (1, light weights)[i] (1, material weights)[k] table[light cluster, material cluster, i, k](direction).
/// Directions are those of the material's frame, which is turned against the texel's.
/// Source: seed 001, 10.1 (its second way).
struct Interactions {
  int light_terms = 1, material_terms = 1;  ///< 1 + components
  int light_clusters = 0, material_clusters = 0;
  std::vector<std::uint16_t> light_cluster, material_cluster;  ///< [texel]
  std::vector<BtfTurn> turns;                                  ///< [texel]
  Eigen::MatrixXf light_weights;                               ///< [component][texel], at most 1, as the next
  Eigen::MatrixXf material_weights;  ///< [3 term + channel][texel]: coloured, for tints and base colours
  /// [3 bin + channel][((light cluster, material cluster), light term, material term)]: coefficients of a
  /// DirectionSpline.
  Eigen::MatrixXf table;
  std::size_t column(int light, int material, int light_term, int material_term) const {
    return ((static_cast<std::size_t>(light) * static_cast<std::size_t>(material_clusters) +
             static_cast<std::size_t>(material)) *
                static_cast<std::size_t>(light_terms) +
            static_cast<std::size_t>(light_term)) *
               static_cast<std::size_t>(material_terms) +
           static_cast<std::size_t>(material_term);
  }
  /// Coefficients of a texel, of directions in the material's frame. [3 bin + channel]
  Eigen::VectorXf decode(std::size_t texel) const;
};

/// From incident light and the materials of `scene`, as compute_outgoing. Throws Error for materials of which every
/// texel has a response of its own. Null once cancelled.
std::shared_ptr<const Interactions> compute_interactions(const PathScene& scene, const LightFieldAtlas& atlas,
                                                         const IncidentField& incident,
                                                         const InteractionOptions& options,
                                                         const std::atomic<bool>& cancel);

/// RMS over all directions and every `step`-th texel of what they differ by from an outgoing field, relative to its
/// mean.
double interaction_error(const Interactions& interactions, const OutgoingField& field, int side, std::size_t step);

}  // namespace maquette
