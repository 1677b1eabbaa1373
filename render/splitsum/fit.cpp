#include "render/splitsum/fit.h"

#include <algorithm>
#include <cmath>

namespace maquette {

namespace {

/// Channels 0 and 1 of the table, bilinear.
glm::dvec2 split_sum(const Image& table, double nv, double roughness) {
  const auto locate = [](double v, int size, int* cell) {
    const double at = std::clamp(v * size - 0.5, 0.0, size - 1.0);
    *cell = std::min(static_cast<int>(at), size - 2);
    return at - *cell;
  };
  int x = 0, y = 0;
  const double fx = locate(nv, table.width, &x), fy = locate(roughness, table.height, &y);
  glm::dvec2 value(0.0);
  for (int c = 0; c < 2; ++c) {
    const auto row = [&](int j) { return (1.0 - fx) * table.at(x, j, c) + fx * table.at(x + 1, j, c); };
    value[c] = (1.0 - fy) * row(y) + fy * row(y + 1);
  }
  return value;
}

/// Least squares of (f0 a + f90 b - 1) over the columns, both >= 0.
glm::dvec2 solve(const std::vector<glm::dvec2>& columns, const std::vector<double>& weights) {
  double aa = 0.0, ab = 0.0, bb = 0.0, a = 0.0, b = 0.0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double w = weights[i];
    aa += w * columns[i].x * columns[i].x;
    ab += w * columns[i].x * columns[i].y;
    bb += w * columns[i].y * columns[i].y;
    a += w * columns[i].x;
    b += w * columns[i].y;
  }
  const double determinant = aa * bb - ab * ab;
  if (determinant > 1e-12 * aa * bb) {
    const glm::dvec2 both((bb * a - ab * b) / determinant, (aa * b - ab * a) / determinant);
    if (both.x >= 0.0 && both.y >= 0.0) return both;
  }
  // On an edge: the better of the two.
  const glm::dvec2 only_f0(aa > 0.0 ? a / aa : 0.0, 0.0), only_f90(0.0, bb > 0.0 ? b / bb : 0.0);
  return a * only_f0.x >= b * only_f90.y ? only_f0 : only_f90;
}

}  // namespace

SplitsumFit fit_energy(const GgxFit& shape, const std::vector<glm::vec3>& albedo, const Image& table) {
  SplitsumFit fit;
  fit.alpha = shape.alpha;
  // Seven eighths of a right angle: beyond, tables are extrapolated and little is seen.
  const std::size_t used = albedo.size() * 7 / 8;
  for (int c = 0; c < 3; ++c) {
    double least = 1e30;
    for (std::size_t i = 0; i < used; ++i) least = std::min(least, static_cast<double>(albedo[i][c]));
    const double diffuse = std::min(static_cast<double>(shape.diffuse[c]), least);
    std::vector<glm::dvec2> columns;
    std::vector<double> weights;
    for (std::size_t i = 0; i < used; ++i) {
      const double theta = 1.5707963267948966 * static_cast<double>(i) / static_cast<double>(albedo.size() - 1);
      const double rest = static_cast<double>(albedo[i][c]) - diffuse, whole = static_cast<double>(albedo[i][c]);
      if (rest <= 0.0) continue;
      columns.push_back(split_sum(table, std::cos(theta), std::sqrt(static_cast<double>(shape.alpha))) / rest);
      const double relative = rest / whole;
      weights.push_back(std::cos(theta) * std::sin(theta) * relative * relative);
    }
    const glm::dvec2 f = solve(columns, weights);
    fit.diffuse[c] = static_cast<float>(diffuse);
    fit.f0[c] = static_cast<float>(f.x);
    fit.f90[c] = static_cast<float>(f.y);
  }
  return fit;
}

}  // namespace maquette
