#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

namespace maquette {

struct LocalPcaOptions {
  int clusters = 32;
  int components = 4;
  int rounds = 20;  ///< at most; ends earlier when the error falls by less than `least_gain` of itself
  double least_gain = 1e-4;
  std::uint32_t seed = 1;
  /// Asked before each round; true ends the fit where it is.
  std::function<bool()> stop = {};
};

/// One vector, compressed.
struct LocalPcaCode {
  int cluster = 0;
  Eigen::VectorXf weights;  ///< [component]
};

/// Clustered principal component analysis: every vector is the mean of its cluster plus a few of the cluster's own
/// components. Fitted on a sample; the rest is encoded one by one. Knows no OpenGL.
/// Source: Kambhatla and Leen 1997, "Dimension Reduction by Local Principal Component Analysis", Sec. 3.2.
class LocalPca {
 public:
  LocalPca() = default;
  /// `samples`: [dimension][sample]. `measure`: what each dimension counts, 0 or more (the solid angle of its
  /// direction); errors are sums of measure * difference^2. Empty: all count 1. Fewer samples than clusters give fewer
  /// clusters. Cost per round: samples * clusters * components * dimension.
  static LocalPca fit(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure, const LocalPcaOptions& options);

  /// One that was fitted before, from what mean() and components() gave. `means`: [dimension][cluster]; `components`:
  /// [dimension][cluster * count + component].
  static LocalPca restore(const Eigen::VectorXf& measure, const Eigen::MatrixXf& means,
                          const Eigen::MatrixXf& components);

  /// The cluster that reconstructs `x` best, and its weights. A dimension that counts nothing comes back as 0.
  LocalPcaCode encode(const Eigen::VectorXf& x) const;
  /// Of each column; many at once cost a fraction, because all means and components are then read once.
  std::vector<LocalPcaCode> encode_all(const Eigen::MatrixXf& x) const;
  Eigen::VectorXf decode(const LocalPcaCode& code) const;
  /// Sum of measure * difference^2 between `x` and its reconstruction.
  double error(const Eigen::VectorXf& x) const;

  int dimension() const { return static_cast<int>(roots_.size()); }
  int cluster_count() const { return static_cast<int>(clusters_.size()); }
  int component_count() const { return components_; }
  /// Mean of a cluster and its components [dimension][component], as they enter the reconstruction.
  Eigen::VectorXf mean(int cluster) const;
  Eigen::MatrixXf components(int cluster) const;
  /// Mean over the samples of the fit of their error, after each round; never grows.
  const std::vector<double>& history() const { return history_; }

 private:
  struct Cluster {
    Eigen::VectorXf mean;   ///< scaled by the roots of the measure
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
