#include "scenes/linear_algebra.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace maquette {

SymmetricEigen::SymmetricEigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  values_ = solver.eigenvalues();
  vectors_ = solver.eigenvectors();
}

Eigen::MatrixXf orthonormal_columns(const Eigen::MatrixXf& m) {
  return Eigen::HouseholderQR<Eigen::MatrixXf>(m).householderQ() * Eigen::MatrixXf::Identity(m.rows(), m.cols());
}

}  // namespace maquette
