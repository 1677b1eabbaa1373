#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "render/math/local_pca_fit.h"
#include "render/prt/cube_light.h"

namespace maquette {

/// Transfer of one view and component of a BTF after clustered principal component analysis:
///   T(vertex, l) = q(cluster, 0, l) + sum over c of weight(vertex, c) q(cluster, c, l).
/// Source: Mueller, Meseth and Klein 2003, "Compression and Real-Time Rendering of Measured BTFs Using Local PCA".
struct TransferMatrix {
  int clusters = 0, components = 0;
  int channels = 1;  ///< 3: q by colour, with weights in common
  /// Half floats, [channel][coefficient][cluster][1 + component]: Haar coefficients of q times the solid angle, so that
  /// the sum with the light's Haar coefficients is the integral of q times light over the sphere. The mean comes first.
  std::vector<std::uint16_t> q;
  std::vector<std::uint16_t> owner;    ///< [vertex] cluster
  std::vector<std::uint16_t> weights;  ///< half floats, [vertex][component]
  std::vector<float> squares;          ///< [vertex] squared error, integrated over the sphere
  double energy = 0.0;                 ///< mean over vertices of the squared transfer, integrated over the sphere
  double error = 0.0;                  ///< RMS relative to the RMS of the transfer, by solid angle
  /// Of one channel.
  std::size_t rows() const { return static_cast<std::size_t>(clusters * (1 + components)); }
};

struct TransferPcaOptions {
  int clusters = 32;
  int components = 6;
  std::function<bool()> stop = {};
};

/// `transfer`: [direction][vertex], or [rgb][direction][vertex]. Fewer vertices than clusters, missing rank and black
/// transfer are no errors: what is not there is 0.
TransferMatrix factorise_transfer(const Eigen::MatrixXf& transfer, const CubeDirections& directions,
                                  const TransferPcaOptions& options);

/// What came of it, [direction][vertex] or [rgb][direction][vertex], for tests and error figures.
Eigen::MatrixXf decode_transfer(const TransferMatrix& matrix, const CubeDirections& directions);

}  // namespace maquette
