#pragma once

#include <vector>

#include "render/math/local_pca.h"

namespace maquette {

/// Vectors and their codes.
struct LocalPcaFit {
  LocalPca pca;
  std::vector<int> owner;      ///< [sample] cluster
  Eigen::MatrixXf weights;     ///< [component][sample]
  std::vector<double> errors;  ///< [sample] sum of measure * difference^2
  double lost = 0.0;           ///< share of the energy about the mean that the sketch does not hold
};

/// As LocalPca::fit, for many vectors of many dimensions, all of which are encoded: clusters are found in a sketch of
/// so many dimensions that holds nearly all energy, and means, components, weights and errors are then computed in full
/// dimension. The sketch is the leading subspace of an evenly spaced subset, from 1,025 dimensions on an approximate
/// one that is found at random. Deterministic, whatever the number of threads. The largest entry of a component is
/// positive. Cost per round: samples * clusters * components * `sketch`.
LocalPcaFit fit_local_pca(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure,
                          const LocalPcaOptions& options, int sketch = 64);

/// What a fit is told apart by at a fraction of its cost: evenly spaced vectors in the coordinates of their sketch.
struct LocalPcaSketch {
  Eigen::MatrixXf samples;  ///< [sketch][sample]; errors are sums of difference^2
  double lost = 0.0;        ///< mean squared error of a vector that the sketch does not hold
};
LocalPcaSketch sketch_for_local_pca(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure,
                                    Eigen::Index most_samples, int sketch = 64);

}  // namespace maquette
