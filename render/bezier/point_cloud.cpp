#include "render/bezier/point_cloud.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace maquette {

namespace {

glm::dmat3 principal_axes(const std::vector<glm::dvec3>& points, double* flatness) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const glm::dvec3& p : points) {
    const Eigen::Vector3d v(p.x, p.y, p.z);
    covariance += v * v.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const auto axis = [&](int k) {
    return glm::dvec3(solver.eigenvectors()(0, k), solver.eigenvectors()(1, k), solver.eigenvectors()(2, k));
  };
  *flatness = solver.eigenvalues()(1) / std::max(solver.eigenvalues()(2), 1e-300);
  return {axis(2), glm::cross(axis(0), axis(2)), axis(0)};
}

}  // namespace

bool make_cloud(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                std::span<const std::uint32_t> indices, Cloud* cloud) {
  cloud->vertices.assign(indices.begin(), indices.end());
  std::sort(cloud->vertices.begin(), cloud->vertices.end());
  cloud->vertices.erase(std::unique(cloud->vertices.begin(), cloud->vertices.end()), cloud->vertices.end());
  for (const std::uint32_t v : cloud->vertices) {
    cloud->points.emplace_back(positions[v]);
    cloud->origin += cloud->points.back() / static_cast<double>(cloud->vertices.size());
  }
  cloud->scale = 0.0;
  for (glm::dvec3& p : cloud->points) {
    p -= cloud->origin;
    cloud->scale = std::max(cloud->scale, glm::length(p));
  }
  if (!(cloud->scale > 0.0) || !std::isfinite(cloud->scale)) return false;
  double flatness = 0.0;
  for (glm::dvec3& p : cloud->points) p /= cloud->scale;
  glm::dmat3 axes = principal_axes(cloud->points, &flatness);
  if (flatness < 1e-10) return false;  // all on a line
  constexpr int kAngles = 90;
  double least = 1e300, best = 0.0;
  for (int k = 0; k < kAngles; ++k) {
    const double angle = 0.5 * std::numbers::pi * k / kAngles, c = std::cos(angle), s = std::sin(angle);
    glm::dvec2 low(1e300), high(-1e300);
    for (const glm::dvec3& p : cloud->points) {
      const glm::dvec2 q(glm::dot(p, c * axes[0] + s * axes[1]), glm::dot(p, c * axes[1] - s * axes[0]));
      low = glm::min(low, q);
      high = glm::max(high, q);
    }
    const double area = (high.x - low.x) * (high.y - low.y);
    if (area < 0.999 * least) least = area, best = angle;
  }
  const double c = std::cos(best), s = std::sin(best);
  axes = {c * axes[0] + s * axes[1], c * axes[1] - s * axes[0], axes[2]};
  cloud->world_from_local = axes;
  for (glm::dvec3& p : cloud->points) p = glm::transpose(axes) * p;
  for (std::size_t n = 0; n < cloud->vertices.size() && !normals.empty(); ++n) {
    const glm::dvec3 normal = glm::transpose(axes) * glm::dvec3(normals[cloud->vertices[n]]);
    const double length = glm::length(normal);
    cloud->normals.push_back(length > 0.0 && std::isfinite(length) ? normal / length : glm::dvec3(0.0));
  }
  return true;
}

}  // namespace maquette
