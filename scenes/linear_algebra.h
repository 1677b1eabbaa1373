#pragma once

#include <Eigen/Core>

namespace maquette {

/// Eigenvalues (increasing) and orthonormal eigenvectors (columns) of a symmetric matrix [n][n]; of its lower triangle
/// only. Compiled once: Eigen's own solver costs every file that uses it seconds.
class SymmetricEigen {
 public:
  explicit SymmetricEigen(const Eigen::MatrixXd& matrix);
  const Eigen::VectorXd& eigenvalues() const { return values_; }
  const Eigen::MatrixXd& eigenvectors() const { return vectors_; }

 private:
  Eigen::VectorXd values_;
  Eigen::MatrixXd vectors_;
};

/// Products of matrices of any size: a b, the transposed a with b, a with the transposed b. Compiled once, too.
using FloatMatrix = Eigen::Ref<const Eigen::MatrixXf>;
using DoubleMatrix = Eigen::Ref<const Eigen::MatrixXd>;
Eigen::MatrixXf times(const FloatMatrix& a, const FloatMatrix& b);
Eigen::MatrixXd times(const DoubleMatrix& a, const DoubleMatrix& b);
Eigen::MatrixXf transposed_times(const FloatMatrix& a, const FloatMatrix& b);
Eigen::MatrixXd transposed_times(const DoubleMatrix& a, const DoubleMatrix& b);
Eigen::MatrixXf times_transposed(const FloatMatrix& a, const FloatMatrix& b);
Eigen::MatrixXd times_transposed(const DoubleMatrix& a, const DoubleMatrix& b);

/// Orthonormal columns that span those of `m` [rows][columns <= rows].
Eigen::MatrixXf orthonormal_columns(const Eigen::MatrixXf& m);

}  // namespace maquette
