#pragma once

#include <Eigen/Core>
#include <atomic>
#include <memory>

#include "render/slf/interaction_terms.h"
#include "render/slf/outgoing.h"

namespace maquette {

/// Outgoing light that is not stored: arriving light and material, both by local PCA, and a table of what each term of
/// the one makes of each of the other. Light towards a direction is the sum over terms i, k of
/// (1, light weights)[i] (material weights)[k] table[light cluster, material cluster, i, k](direction).
/// Directions are those of the material's frame, which is turned against the texel's.
/// Source: seed 001, 10.1 (its second way).
struct Interactions {
  InteractionCodes codes;
  /// [3 bin + channel][((light cluster, material cluster), light term, material term)]: coefficients of a
  /// DirectionSpline.
  Eigen::MatrixXf table;
  std::size_t column(int light, int material, int light_term, int material_term) const {
    return ((static_cast<std::size_t>(light) * static_cast<std::size_t>(codes.material_clusters) +
             static_cast<std::size_t>(material)) *
                static_cast<std::size_t>(codes.light_terms) +
            static_cast<std::size_t>(light_term)) *
               static_cast<std::size_t>(codes.material_terms) +
           static_cast<std::size_t>(material_term);
  }
  /// Coefficients of a texel, of directions in the material's frame. [3 bin + channel]
  Eigen::VectorXf decode(std::size_t texel) const;
};

/// The table of what is compressed. Null once cancelled.
std::shared_ptr<const Interactions> compute_interactions(const InteractionTerms& terms,
                                                         const std::atomic<bool>& cancel);

/// RMS over all directions and every `step`-th texel of what they differ by from an outgoing field, relative to its
/// mean.
double interaction_error(const Interactions& interactions, const OutgoingField& field, int side, std::size_t step);

}  // namespace maquette
