#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace maquette {

/// What compression of a bake costs: RMS error relative to the mean of what is stored, over clusters and components.
struct CompressionTable {
  std::vector<int> clusters, components;
  std::vector<double> errors;  ///< [component][cluster]
  std::size_t vectors = 0;     ///< that it was computed of
  double error(std::size_t component, std::size_t cluster) const {
    return errors[component * clusters.size() + cluster];
  }
};

/// Computes one on any thread, without OpenGL; nothing once cancelled or where nothing is stored. Throws Error.
using CompressionTableJob =
    std::function<std::optional<CompressionTable>(const std::atomic<bool>& cancel, const std::function<void(double)>&)>;

}  // namespace maquette
