#include <Eigen/Dense>
#include <cmath>

#include "render/prt/transfer_bake.h"

namespace maquette {

std::optional<RigidMotion> find_rigid_motion(const std::vector<glm::vec3>& from, const std::vector<glm::vec3>& to,
                                             double tolerance) {
  if (from.size() != to.size() || from.empty()) return std::nullopt;
  glm::dvec3 middle_from(0.0), middle_to(0.0);
  for (std::size_t i = 0; i < from.size(); ++i) middle_from += glm::dvec3(from[i]), middle_to += glm::dvec3(to[i]);
  middle_from /= static_cast<double>(from.size());
  middle_to /= static_cast<double>(from.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double size = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const glm::dvec3 a = glm::dvec3(from[i]) - middle_from, b = glm::dvec3(to[i]) - middle_to;
    size = std::max({size, glm::length(a), glm::length(glm::dvec3(to[i]))});
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) covariance(row, column) += b[row] * a[column];
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1.0, 1.0, 1.0);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) sign[2] = -1.0;
  const Eigen::Matrix3d turn = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  RigidMotion motion;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) motion.rotation[column][row] = turn(row, column);
  motion.shift = middle_to - motion.rotation * middle_from;
  for (std::size_t i = 0; i < from.size(); ++i)
    if (!(glm::length(motion.rotation * glm::dvec3(from[i]) + motion.shift - glm::dvec3(to[i])) <= tolerance * size))
      return std::nullopt;
  return motion;
}

}  // namespace maquette
