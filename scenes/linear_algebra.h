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

/// Orthonormal columns that span those of `m` [rows][columns <= rows].
Eigen::MatrixXf orthonormal_columns(const Eigen::MatrixXf& m);

}  // namespace maquette
