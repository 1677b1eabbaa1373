#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

namespace maquette {

struct LocalPcaOptions {
  int clusters = 32;
  int components = 4;
  int rounds = 20;  ///< at most; ends earlier when the relative improvement falls below `least_gain`
  double least_gain = 1e-4;
  std::uint32_t seed = 1;
  /// Polled before each round; returning true ends the fit with the result so far.
  std::function<bool()> stop = {};
};

/// One vector, compressed.
struct LocalPcaCode {
  int cluster = 0;
  Eigen::VectorXf weights;  ///< [component]
};

/// Clustered principal component analysis: every vector is approximated by the mean of its cluster plus a few
/// components of that cluster. Fitted to a sample of the vectors; the others are encoded one by one. Does not use
/// OpenGL.
/// Source: Kambhatla and Leen 1997, "Dimension Reduction by Local Principal Component Analysis", Sec. 3.2.
class LocalPca {
 public:
  LocalPca() = default;
  /// `samples`: [dimension][sample]. `measure`: weight of each dimension, 0 or more (the solid angle of its direction);
  /// errors are sums of measure * difference^2. Empty: all weights are 1. Fewer samples than clusters give fewer
  /// clusters. Cost per round: samples * clusters * components * dimension.
  static LocalPca fit(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure, const LocalPcaOptions& options);

  /// Restores a fitted one from the results of mean() and components(). `means`: [dimension][cluster]; `components`:
  /// [dimension][cluster * count + component].
  static LocalPca restore(const Eigen::VectorXf& measure, const Eigen::MatrixXf& means,
                          const Eigen::MatrixXf& components);

  /// The cluster that reconstructs `x` best, and its weights. A dimension of weight 0 is reconstructed as 0.
  LocalPcaCode encode(const Eigen::VectorXf& x) const;
  /// Encodes each column; many at once cost a fraction, because all means and components are read only once.
  std::vector<LocalPcaCode> encode_all(const Eigen::MatrixXf& x) const;
  Eigen::VectorXf decode(const LocalPcaCode& code) const;
  /// Sum of measure * difference^2 between `x` and its reconstruction.
  double error(const Eigen::VectorXf& x) const;

  int dimension() const { return static_cast<int>(roots_.size()); }
  int cluster_count() const { return static_cast<int>(clusters_.size()); }
  /// Mean of a cluster and its components [dimension][component], in the form used for reconstruction.
  Eigen::VectorXf mean(int cluster) const;
  Eigen::MatrixXf components(int cluster) const;
  /// Mean error over the samples of the fit after each round; never increases.
  const std::vector<double>& history() const { return history_; }

 private:
  struct Cluster {
    Eigen::VectorXf mean;   ///< scaled by the square roots of the measure
    Eigen::MatrixXf basis;  ///< orthonormal columns, in the scaled space
  };
  static Cluster fit_cluster(const Eigen::MatrixXf& scaled, const std::vector<int>& members, int components,
                             std::uint32_t seed);
  Eigen::VectorXf unscale(const Eigen::VectorXf& scaled) const;
  void gather();

  Eigen::VectorXf roots_;  ///< square roots of the measure
  std::vector<Cluster> clusters_;
  Eigen::MatrixXf gathered_;  ///< mean and basis of each cluster, one after the other
  int components_ = 0;
  std::vector<double> history_;
};

}  // namespace maquette
