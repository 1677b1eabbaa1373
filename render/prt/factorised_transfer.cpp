#include "render/prt/factorised_transfer.h"

#include <cmath>

#include "scenes/btf/half_floats.h"
#include "scenes/parallel.h"

namespace maquette {

TransferMatrix factorise_transfer(const Eigen::MatrixXf& transfer, const CubeDirections& directions,
                                  const TransferPcaOptions& options) {
  LocalPcaOptions pca;
  pca.clusters = options.clusters;
  pca.components = options.components;
  pca.rounds = 10;
  pca.stop = options.stop;
  const Eigen::Index channels = transfer.rows() / directions.count();
  const Eigen::VectorXf measure = directions.solid_angles().cast<float>().replicate(channels, 1);
  const LocalPcaFit fit = fit_local_pca(transfer, measure, pca);
  const int dimensions = static_cast<int>(directions.count()), terms = 1 + options.components;
  TransferMatrix matrix;
  matrix.clusters = fit.pca.cluster_count();
  matrix.components = options.components;
  matrix.channels = static_cast<int>(channels);
  const std::size_t rows = matrix.rows();
  matrix.q.assign(rows * static_cast<std::size_t>(dimensions * channels), 0);
  // Components have the norm 1 over the sphere; scaled by the RMS of their weights they are as large as what they
  // bring, and the weights are about 1: both well within half floats.
  Eigen::MatrixXf scales = Eigen::MatrixXf::Ones(options.components, matrix.clusters);
  Eigen::VectorXf members = Eigen::VectorXf::Zero(matrix.clusters);
  Eigen::MatrixXf squares = Eigen::MatrixXf::Zero(options.components, matrix.clusters);
  for (std::size_t v = 0; v < fit.owner.size(); ++v) {
    squares.col(fit.owner[v]) += fit.weights.col(static_cast<Eigen::Index>(v)).cwiseAbs2();
    members[fit.owner[v]] += 1.0f;
  }
  for (int k = 0; k < matrix.clusters; ++k)
    for (int c = 0; c < options.components; ++c)
      if (const float scale = std::sqrt(squares(c, k) / std::max(members[k], 1.0f)); scale > 0.0f) scales(c, k) = scale;
  parallel_for(0, matrix.clusters, [&](int k) {
    Eigen::MatrixXf q(measure.size(), terms);
    q.col(0) = fit.pca.mean(k);
    q.rightCols(options.components) = fit.pca.components(k);
    q = measure.asDiagonal() * q;
    for (int c = 0; c < terms; ++c) {
      if (c > 0) q.col(c) *= scales(c - 1, k);
      for (Eigen::Index n = 0; n < channels; ++n)
        haar_transform_faces(directions.side(), q.col(c).data() + n * dimensions);
      const std::size_t row = static_cast<std::size_t>(k * terms + c);
      for (Eigen::Index j = 0; j < q.rows(); ++j)
        matrix.q[static_cast<std::size_t>(j) * rows + row] = half_of_float(q(j, c));
    }
  });
  for (std::size_t v = 0; v < fit.owner.size(); ++v) {
    matrix.owner.push_back(static_cast<std::uint16_t>(fit.owner[v]));
    for (int c = 0; c < options.components; ++c)
      matrix.weights.push_back(half_of_float(fit.weights(c, static_cast<Eigen::Index>(v)) / scales(c, fit.owner[v])));
  }
  double squared = 0.0, all = 0.0;
  for (std::size_t v = 0; v < fit.errors.size(); ++v) {
    matrix.squares.push_back(static_cast<float>(fit.errors[v]));
    squared += fit.errors[v];
    all += measure.cast<double>().dot(transfer.col(static_cast<Eigen::Index>(v)).cast<double>().cwiseAbs2());
  }
  matrix.energy = fit.errors.empty() ? 0.0 : all / static_cast<double>(fit.errors.size());
  matrix.error = all > 0.0 ? std::sqrt(squared / all) : 0.0;
  return matrix;
}

Eigen::MatrixXf decode_transfer(const TransferMatrix& matrix, const CubeDirections& directions) {
  const Eigen::Index dimensions = directions.count() * matrix.channels;
  const std::size_t rows = matrix.rows();
  const auto terms = static_cast<std::size_t>(1 + matrix.components);
  Eigen::MatrixXf q(dimensions, static_cast<Eigen::Index>(rows));
  for (std::size_t row = 0; row < rows; ++row) {
    const auto column = static_cast<Eigen::Index>(row);
    for (Eigen::Index j = 0; j < dimensions; ++j)
      q(j, column) = float_of_half(matrix.q[static_cast<std::size_t>(j) * rows + row]);
    for (int n = 0; n < matrix.channels; ++n) {
      inverse_haar_faces(directions.side(), q.col(column).data() + n * directions.count());
      q.col(column).segment(n * directions.count(), directions.count()).array() /=
          directions.solid_angles().cast<float>().array();
    }
  }
  Eigen::MatrixXf transfer(dimensions, static_cast<Eigen::Index>(matrix.owner.size()));
  for (std::size_t v = 0; v < matrix.owner.size(); ++v) {
    const auto first = static_cast<Eigen::Index>(matrix.owner[v] * terms);
    auto column = transfer.col(static_cast<Eigen::Index>(v));
    column = q.col(first);
    for (std::size_t c = 1; c < terms; ++c)
      column += float_of_half(matrix.weights[v * (terms - 1) + c - 1]) * q.col(first + static_cast<Eigen::Index>(c));
  }
  return transfer;
}

}  // namespace maquette
