#pragma once

#include <array>
#include <cmath>
#include <glm/glm.hpp>

namespace maquette {

/// Bilinear importance over the cell of one texel of a map: four quarters around the texel's centre, each bilinear.
/// Positions run over the cell from (0, 0) to (1, 1), the centre at (0.5, 0.5), uniformly in solid angle: within a row
/// this is bilinear except for the change of sin(latitude).
class TexelCell {
 public:
  /// `importance(dx, dy)`: non-negative, of the texel and its neighbours, dx and dy from -1 to 1.
  template <typename Importance>
  explicit TexelCell(const Importance& importance) {
    std::array<std::array<double, 3>, 3> texels;
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i)
        texels[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] = importance(i - 1, j - 1);
    for (std::size_t j = 0; j < 3; ++j) {
      const Nodes row = to_nodes(texels[j]);
      for (std::size_t i = 0; i < 3; ++i) nodes_[i][j] = row[i];
    }
    for (Nodes& column : nodes_) column = to_nodes(column);
  }

  double mean() const { return sum(along_y(0), along_y(1), along_y(2)); }
  double at(const glm::dvec2& p) const {
    return value({value(nodes_[0], p.y), value(nodes_[1], p.y), value(nodes_[2], p.y)}, p.x);
  }
  /// Samples a position with density at() / mean(), for u uniform in the unit square. Keeps u's order along both axes.
  glm::dvec2 warp(const glm::dvec2& u) const {
    const double y = invert({along_y(0), along_y(1), along_y(2)}, u.y);
    return {invert({value(nodes_[0], y), value(nodes_[1], y), value(nodes_[2], y)}, u.x), y};
  }

 private:
  using Nodes = std::array<double, 3>;  ///< at 0, 0.5 and 1; straight in between
  static Nodes to_nodes(const Nodes& t) { return {0.5 * (t[0] + t[1]), t[1], 0.5 * (t[1] + t[2])}; }
  static double sum(double a, double b, double c) { return 0.25 * (a + 2.0 * b + c); }
  /// At y's node j, as a function of x.
  double along_y(std::size_t j) const { return sum(nodes_[0][j], nodes_[1][j], nodes_[2][j]); }
  static double value(const Nodes& n, double p) {
    return p < 0.5 ? n[0] + (n[1] - n[0]) * 2.0 * p : n[1] + (n[2] - n[1]) * (2.0 * p - 1.0);
  }
  /// Position where the integral from 0 reaches the share u of the whole.
  static double invert(const Nodes& n, double u) {
    const double first = n[0] + n[1], second = n[1] + n[2], all = first + second;
    if (!(all > 0.0)) return u;
    // Without a branch, which would be mispredicted every other time.
    const double reached = u * all;
    const bool near = reached < first || !(second > 0.0);
    const double from = near ? n[0] : n[1], to = near ? n[1] : n[2];
    const double share = (near ? reached : reached - first) / (near ? first : second);
    return (near ? 0.0 : 0.5) + 0.5 * invert_straight(from, to, std::min(share, 1.0));
  }
  static double invert_straight(double a, double b, double u) {
    return u * (a + b) / std::max(a + std::sqrt(a * a + u * (b * b - a * a)), 1e-300);
  }

  std::array<Nodes, 3> nodes_;  ///< [x][y]
};

}  // namespace maquette
