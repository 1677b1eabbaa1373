#include "scenes/linear_algebra.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace maquette {

SymmetricEigen::SymmetricEigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  values_ = solver.eigenvalues();
  vectors_ = solver.eigenvectors();
}

Eigen::MatrixXf times(const FloatMatrix& a, const FloatMatrix& b) { return a * b; }
Eigen::MatrixXd times(const DoubleMatrix& a, const DoubleMatrix& b) { return a * b; }
Eigen::MatrixXf transposed_times(const FloatMatrix& a, const FloatMatrix& b) { return a.transpose() * b; }
Eigen::MatrixXd transposed_times(const DoubleMatrix& a, const DoubleMatrix& b) { return a.transpose() * b; }
Eigen::MatrixXf times_transposed(const FloatMatrix& a, const FloatMatrix& b) { return a * b.transpose(); }
Eigen::MatrixXd times_transposed(const DoubleMatrix& a, const DoubleMatrix& b) { return a * b.transpose(); }

Eigen::MatrixXf orthonormal_columns(const Eigen::MatrixXf& m) {
  return Eigen::HouseholderQR<Eigen::MatrixXf>(m).householderQ() * Eigen::MatrixXf::Identity(m.rows(), m.cols());
}

}  // namespace maquette
