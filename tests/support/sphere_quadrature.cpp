#include "tests/support/sphere_quadrature.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/luminance.h"
#include "scenes/parallel.h"
#include "tests/support/quadrature.h"

namespace maquette::test {
SphereQuadrature integrate_sphere(const Environment& environment, const BrdfTable& brdf, const SphereView& view,
                                  const Image* normals) {
  const EnvironmentMoments moments(environment);
  SphereQuadrature result;
  std::vector<LitPoint> points;
  const double scale = std::tan(0.5 * view.fov_y_rad);
  for (int y = 0; y < view.side; ++y) {
    for (int x = 0; x < view.side; ++x) {
      const glm::dvec3 ray = glm::normalize(
          glm::dvec3((2.0 * (x + 0.5) / view.side - 1.0) * scale, (1.0 - 2.0 * (y + 0.5) / view.side) * scale, -1.0));
      const glm::dvec3 eye(0.0, 0.0, view.distance);
      const double b = glm::dot(eye, ray), root = b * b - view.distance * view.distance + 1.0;
      if (root <= 0.0) continue;
      LitPoint point;
      point.normal = eye + ray * (-b - std::sqrt(root));
      point.wo = -ray;
      if (normals && normals->at(x, y, 3) >= 1.0f)
        point.normal = glm::normalize(glm::dvec3(normals->at(x, y, 0), normals->at(x, y, 1), normals->at(x, y, 2)));
      points.push_back(point);
      result.pixels.push_back({x, y, glm::dvec3(0.0)});
    }
  }
  std::vector<double> errors(points.size());
  parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const DirectQuadrature q = evaluate_direct(moments, brdf, points[i]);
    result.pixels[i].radiance = q.radiance;
    errors[i] = q.relative_error;
  });
  double sum = 0.0;
  for (const double e : errors) sum += e * e;
  result.estimated_error = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(errors.size(), 1)));
  return result;
}

double relative_rmse(const Image& picture, const SphereQuadrature& quadrature) {
  double square = 0.0, mean = 0.0;
  std::size_t count = 0;
  for (const SpherePixel& p : quadrature.pixels) {
    if (picture.at(p.x, p.y, 3) < 1.0f) continue;  // the tessellated silhouette lies inside the sphere's
    for (int c = 0; c < 3; ++c) square += std::pow(picture.at(p.x, p.y, c) - p.radiance[c], 2.0);
    mean += luminance(glm::dvec3(p.radiance));
    ++count;
  }
  const double n = static_cast<double>(std::max<std::size_t>(count, 1));
  return std::sqrt(square / (3.0 * n)) / (mean / n);
}

double peak_over_mean(const Environment& environment) {
  double peak = 0.0, sum = 0.0, weight = 0.0;
  for (int y = 0; y < environment.height; ++y) {
    const double area = std::cos(std::numbers::pi * ((y + 0.5) / environment.height - 0.5));
    for (int x = 0; x < environment.width; ++x) {
      const double l = luminance(glm::dvec3(environment.rgb[static_cast<std::size_t>(y * environment.width + x)]));
      peak = std::max(peak, l);
      sum += area * l;
      weight += area;
    }
  }
  return sum > 0.0 ? peak * weight / sum : 0.0;
}

}  // namespace maquette::test
