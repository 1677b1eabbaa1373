#pragma once

#include <functional>

#include "render/prt/factorised_transfer.h"

namespace maquette {

struct JointTransferOptions {
  int clusters = 8;
  int components = 6;
  std::function<bool()> stop = {};
};

/// Transfer of one function of a joint BTF for all its views, after clustered principal component analysis of vectors
/// over views and directions: clusters and weights of vertices are common to all views.
///   T(vertex, v, l) = q(v, cluster, 0, l) + sum over c of weight(vertex, c) q(v, cluster, c, l).
/// `transfer`: of a view, [direction][vertex] or [rgb][direction][vertex]; called twice for each view in order, so that
/// one matrix is in memory at a time. Every view's matrix has `clusters` clusters, empty ones too, and the same owner;
/// the first one holds the weights, the others none.
///
/// A first round over the views keeps the leading subspace of the vertices: rows of each view's matrix, mixed by random
/// signs, are merged into it one view at a time. Clusters and weights are found there. A second round computes q by
/// least squares for the weights as they are stored, in full dimension.
/// Source: incremental merging, Brand 2002, "Incremental Singular Value Decomposition of Uncertain Data with Missing
/// Values", Sec. 3; mixed rows, Halko, Martinsson and Tropp 2011, Sec. 4; seed 001, 10.2.6.
/// Deterministic, whatever the number of threads. Empty once stopped.
std::vector<TransferMatrix> factorise_joint_transfer(const std::function<Eigen::MatrixXf(std::size_t view)>& transfer,
                                                     std::size_t views, const CubeDirections& directions,
                                                     const JointTransferOptions& options);

/// What came of one view, as decode_transfer.
Eigen::MatrixXf decode_joint_transfer(const std::vector<TransferMatrix>& joint, std::size_t view,
                                      const CubeDirections& directions);

}  // namespace maquette
