#include "tests/support/quadrature.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

namespace maquette::test {

namespace {

using Moments = EnvironmentMoments::Moments;
/// Largest width of an initial cell; it is also at most half the distance from the lobe's centre plus kLobeCore.
constexpr double kLargestCell_rad = 0.16;
constexpr double kLobeCore_rad = 4e-4;
/// A cell with more than this share of the hemisphere's light starts proportionally smaller, down to
/// kSmallestStart_rad: tables are rough at the scale of their bins (1 degree), which an error estimate from a few nodes
/// around a sun can miss.
constexpr double kOrdinaryShare = 1e-3;
constexpr double kSmallestStart_rad = 0.003;
constexpr int kSmallestLevel = -24;

/// Adds a child's moments to its parent's: the parent's coordinate is (a + shift) / 2, shift -1 or +1.
void add_child(const Moments& child, double shift_x, double shift_y, Moments* parent) {
  const auto transform = [](double shift) {
    return std::array<std::array<double, 3>, 3>{{{1.0, 0.0, 0.0}, {0.5 * shift, 0.5, 0.0}, {0.25, 0.5 * shift, 0.25}}};
  };
  const auto tx = transform(shift_x);
  const auto ty = transform(shift_y);
  for (std::size_t p = 0; p < 3; ++p) {
    for (std::size_t q = 0; q < 3; ++q) {
      for (std::size_t i = 0; i <= p; ++i) {
        for (std::size_t j = 0; j <= q; ++j) (*parent)[3 * p + q] += tx[p][i] * ty[q][j] * child[3 * i + j];
      }
    }
  }
}

double side_of(int level) { return std::ldexp(1.0, level - 1); }

}  // namespace

EnvironmentMoments::EnvironmentMoments(const Environment& environment)
    : width_(environment.width), height_(environment.height), top_level_(1), rgb_(environment.rgb) {
  while (side_of(top_level_ + 1) * 64.0 <= width_) ++top_level_;
  for (int level = 2; level <= top_level_; ++level) {
    Level made;
    const double side = side_of(level);
    made.columns = static_cast<int>(std::ceil(width_ / side));
    made.rows = static_cast<int>(std::ceil(height_ / side));
    made.blocks.assign(static_cast<std::size_t>(made.columns) * static_cast<std::size_t>(made.rows), Moments{});
    for (int row = 0; row < made.rows; ++row) {
      for (int column = 0; column < made.columns; ++column) {
        Moments& block = made.blocks[static_cast<std::size_t>(row) * static_cast<std::size_t>(made.columns) +
                                     static_cast<std::size_t>(column)];
        for (int child = 0; child < 4; ++child) {
          const int right = child & 1;
          const int down = child >> 1;
          add_child(moments(level - 1, side * (column + 0.5 * right), side * (row + 0.5 * down)), 2.0 * right - 1.0,
                    2.0 * down - 1.0, &block);
        }
      }
    }
    levels_.push_back(std::move(made));
  }
}

glm::dvec3 EnvironmentMoments::texel(long x, long y) const {
  const long column = ((x % width_) + width_) % width_;
  const long row = std::clamp(y, 0L, static_cast<long>(height_) - 1);
  return glm::dvec3(rgb_[static_cast<std::size_t>(row * width_ + column)]);
}

glm::dvec3 EnvironmentMoments::radiance(double x, double y) const {
  const double u = x - 0.5;
  const double v = y - 0.5;
  const auto i = static_cast<long>(std::floor(u));
  const auto j = static_cast<long>(std::floor(v));
  const double a = u - static_cast<double>(i);
  const double b = v - static_cast<double>(j);
  return (1.0 - b) * ((1.0 - a) * texel(i, j) + a * texel(i + 1, j)) +
         b * ((1.0 - a) * texel(i, j + 1) + a * texel(i + 1, j + 1));
}

/// Exact: L = c0 + c1 a + c2 b + c3 a b inside a half texel.
Moments EnvironmentMoments::bilinear_moments(double x, double y, double side) const {
  Moments m{};
  if (x >= width_ || y >= height_) return m;  // blocks that overhang the map
  const double h = 0.5 * side;
  const double low =
      0.25;  // corners are taken inside the cell, so that the lookup's floor cannot round across its edge
  glm::dvec3 corner[4]{};
  for (int k = 0; k < 4; ++k) {
    corner[k] = radiance(x + side * (low + 0.5 * (k & 1)), y + side * (low + 0.5 * (k >> 1)));
  }
  const glm::dvec3 c0 = 0.25 * (corner[0] + corner[1] + corner[2] + corner[3]);
  const glm::dvec3 c1 = 0.5 * (corner[1] + corner[3] - corner[0] - corner[2]);  // at a = -+ 1/2
  const glm::dvec3 c2 = 0.5 * (corner[2] + corner[3] - corner[0] - corner[1]);
  const glm::dvec3 c3 = corner[0] + corner[3] - corner[1] - corner[2];
  constexpr double kPower[4] = {2.0, 0.0, 2.0 / 3.0, 0.0};  // integral of a^p over [-1, 1]
  for (std::size_t p = 0; p < 3; ++p) {
    for (std::size_t q = 0; q < 3; ++q) {
      m[3 * p + q] = h * h *
                     (c0 * kPower[p] * kPower[q] + c1 * kPower[p + 1] * kPower[q] + c2 * kPower[p] * kPower[q + 1] +
                      c3 * kPower[p + 1] * kPower[q + 1]);
    }
  }
  return m;
}

Moments EnvironmentMoments::moments(int level, double x, double y) const {
  const double side = side_of(level);
  if (level <= 0) return bilinear_moments(x, y, side);
  if (level == 1) {
    Moments m{};
    for (int child = 0; child < 4; ++child) {
      const int right = child & 1;
      const int down = child >> 1;
      add_child(bilinear_moments(x + 0.5 * right, y + 0.5 * down, 0.5), 2.0 * right - 1.0, 2.0 * down - 1.0, &m);
    }
    return m;
  }
  const Level& stored = levels_[static_cast<std::size_t>(level - 2)];
  const auto column = static_cast<int>(x / side);
  const auto row = static_cast<int>(y / side);
  if (column >= stored.columns || row >= stored.rows) return {};
  return stored.blocks[static_cast<std::size_t>(row) * static_cast<std::size_t>(stored.columns) +
                       static_cast<std::size_t>(column)];
}

namespace {

/// A leaf of the adaptive tree: G = weight * d omega / (dx dy) on a 5 x 5 grid.
struct Cell {
  int level = 0;
  double x = 0.0, y = 0.0;
  std::array<glm::dvec3, 25> g{};
  glm::dvec3 value{0.0};
  double error = 0.0;
};

class Integrator {
 public:
  Integrator(const EnvironmentMoments& environment, const std::function<glm::dvec3(const glm::dvec3&)>& weight,
             const glm::dvec3& normal, const glm::dvec3& focus)
      : environment_(environment), weight_(weight), normal_(normal), focus_(focus) {}

  DirectQuadrature run(const DirectQuadratureOptions& options) {
    const double side = side_of(environment_.top_level());
    const auto for_roots = [&](const auto& visit) {
      for (double y = 0.0; y < environment_.height(); y += side) {
        for (double x = 0.0; x < environment_.width(); x += side) visit(environment_.top_level(), x, y);
      }
    };
    for_roots([&](int level, double x, double y) { light_ += is_above(x, y, side) ? light_of(level, x, y) : 0.0; });
    if (light_ > 0.0) for_roots([&](int level, double x, double y) { start(level, x, y); });
    while (error_ > options.relative_tolerance * total() && cells_.size() < options.max_cells && !order_.empty()) {
      const std::size_t worst = order_.top().second;
      order_.pop();
      split(worst);
    }
    // The running sums have lost digits because the first estimates are large.
    glm::dvec3 value(0.0);
    double error = 0.0;
    for (const Cell& cell : cells_) {
      value += cell.value;
      error += cell.error;
    }
    value_ = value;
    return {value, total() > 0.0 ? error / total() : 0.0, evaluations_};
  }

 private:
  double total() const { return value_.x + value_.y + value_.z; }

  /// Half the diagonal, an upper bound (rad).
  double radius_of(double y, double side) const {
    const double lat_a = std::numbers::pi * (0.5 - y / environment_.height());
    const double lat_b = std::numbers::pi * (0.5 - (y + side) / environment_.height());
    const double widest = lat_a * lat_b <= 0.0 ? 1.0 : std::max(std::cos(lat_a), std::cos(lat_b));
    return 0.5 * side *
           std::hypot(2.0 * std::numbers::pi / environment_.width() * std::min(1.0, std::abs(widest) + 1e-9),
                      std::numbers::pi / environment_.height());
  }

  glm::dvec3 centre_of(double x, double y, double side) const {
    return direction_from_latlong(x + 0.5 * side, y + 0.5 * side, environment_.width(), environment_.height());
  }

  bool is_above(double x, double y, double side) const {
    const double elevation = std::asin(std::clamp(glm::dot(centre_of(x, y, side), normal_), -1.0, 1.0));
    return elevation >= -radius_of(y, side) - 1e-9;
  }

  /// Proportional to the light of a cell.
  double light_of(int level, double x, double y) const {
    const glm::dvec3 mass = environment_.moments(level, x, y)[0];
    const double latitude = std::numbers::pi * (0.5 - (y + 0.5 * side_of(level)) / environment_.height());
    return (mass.x + mass.y + mass.z) * std::max(std::cos(latitude), 0.0);
  }

  void start(int level, double x, double y) {
    const double side = side_of(level);
    if (x >= environment_.width() || y >= environment_.height() || !is_above(x, y, side)) return;
    const double share = light_of(level, x, y) / light_;
    const double radius = radius_of(y, side);
    const double away = std::acos(std::clamp(glm::dot(centre_of(x, y, side), focus_), -1.0, 1.0));
    const double allowed = 0.5 * kLargestCell_rad * std::min(1.0, kOrdinaryShare / std::max(share, 1e-9));
    const bool wide = radius > std::max(allowed, kSmallestStart_rad) || radius > 0.25 * away + kLobeCore_rad;
    if (wide && level > kSmallestLevel) {
      for (int child = 0; child < 4; ++child) {
        start(level - 1, x + 0.5 * side * (child & 1), y + 0.5 * side * (child >> 1));
      }
      return;
    }
    Cell cell;
    cell.level = level;
    cell.x = x;
    cell.y = y;
    for (int k = 0; k < 25; ++k) cell.g[static_cast<std::size_t>(k)] = evaluate(cell, k % 5, k / 5);
    finish(cell);
  }

  /// G at node (i, j) of the 5 x 5 grid.
  glm::dvec3 evaluate(const Cell& cell, int i, int j) {
    ++evaluations_;
    const double step = 0.25 * side_of(cell.level);
    const double y = cell.y + step * j;
    const glm::dvec3 w = direction_from_latlong(cell.x + step * i, y, environment_.width(), environment_.height());
    const double area =
        2.0 * std::numbers::pi * std::numbers::pi / (static_cast<double>(environment_.width()) * environment_.height());
    return weight_(w) * (std::cos(std::numbers::pi * (0.5 - y / environment_.height())) * area);
  }

  /// Integral of the biquadratic through the nodes i, i + step, i + 2 step (and j alike) of the 5 x 5 grid.
  static glm::dvec3 integrate(const Cell& cell, int i, int j, int step, const Moments& m) {
    std::array<std::array<glm::dvec3, 3>, 3> along{};  // [row][power of a]
    for (int r = 0; r < 3; ++r) {
      const auto at = [&](int c) { return cell.g[static_cast<std::size_t>(5 * (j + step * r) + i + step * c)]; };
      along[static_cast<std::size_t>(r)] = {at(1), 0.5 * (at(2) - at(0)), 0.5 * (at(2) + at(0)) - at(1)};
    }
    glm::dvec3 sum(0.0);
    for (std::size_t p = 0; p < 3; ++p) {
      const glm::dvec3& low = along[0][p];
      const glm::dvec3& mid = along[1][p];
      const glm::dvec3& high = along[2][p];
      sum += mid * m[3 * p] + 0.5 * (high - low) * m[3 * p + 1] + (0.5 * (high + low) - mid) * m[3 * p + 2];
    }
    return sum;
  }

  /// Value (four quarters) and error (against the whole) of a cell whose nodes are known.
  void finish(Cell& cell) {
    Moments whole{};
    glm::dvec3 fine(0.0);
    const double half = 0.5 * side_of(cell.level);
    for (int child = 0; child < 4; ++child) {
      const int right = child & 1;
      const int down = child >> 1;
      const Moments m = environment_.moments(cell.level - 1, cell.x + half * right, cell.y + half * down);
      add_child(m, 2.0 * right - 1.0, 2.0 * down - 1.0, &whole);
      fine += integrate(cell, 2 * right, 2 * down, 1, m);
    }
    const glm::dvec3 difference = glm::abs(fine - integrate(cell, 0, 0, 2, whole));
    cell.value = fine;
    cell.error = 0.25 * (difference.x + difference.y + difference.z);  // second order at least, where there are kinks
    value_ += cell.value;
    error_ += cell.error;
    cells_.push_back(cell);
    if (cell.error > 0.0 && cell.level > kSmallestLevel) order_.emplace(cell.error, cells_.size() - 1);
  }

  void split(std::size_t index) {
    const Cell parent = cells_[index];
    value_ -= parent.value;
    error_ -= parent.error;
    cells_[index].value = glm::dvec3(0.0);
    cells_[index].error = 0.0;
    const double half = 0.5 * side_of(parent.level);
    for (int child = 0; child < 4; ++child) {
      const int right = child & 1;
      const int down = child >> 1;
      Cell cell;
      cell.level = parent.level - 1;
      cell.x = parent.x + half * right;
      cell.y = parent.y + half * down;
      for (int k = 0; k < 25; ++k) {
        const int i = k % 5;
        const int j = k / 5;
        const bool known = i % 2 == 0 && j % 2 == 0;
        cell.g[static_cast<std::size_t>(k)] =
            known ? parent.g[static_cast<std::size_t>(5 * (2 * down + j / 2) + 2 * right + i / 2)]
                  : evaluate(cell, i, j);
      }
      finish(cell);
    }
  }

  const EnvironmentMoments& environment_;
  const std::function<glm::dvec3(const glm::dvec3&)>& weight_;
  glm::dvec3 normal_{}, focus_{};
  std::vector<Cell> cells_;
  std::priority_queue<std::pair<double, std::size_t>> order_;
  glm::dvec3 value_{0.0};
  double error_ = 0.0;
  double light_ = 0.0;  // above the horizon
  std::size_t evaluations_ = 0;
};

}  // namespace

DirectQuadrature integrate_environment(const EnvironmentMoments& environment,
                                       const std::function<glm::dvec3(const glm::dvec3&)>& weight,
                                       const glm::dvec3& normal, const glm::dvec3& focus,
                                       const DirectQuadratureOptions& options) {
  return Integrator(environment, weight, normal, focus).run(options);
}

DirectQuadrature evaluate_direct(const EnvironmentMoments& environment, const BrdfTable& brdf, const LitPoint& point,
                                 const DirectQuadratureOptions& options) {
  // Into the frame of the map, without rotation.
  const double c = std::cos(point.env_rotation_rad);
  const double s = std::sin(point.env_rotation_rad);
  const auto unturn = [c, s](const glm::dvec3& d) { return glm::dvec3(c * d.x - s * d.z, d.y, c * d.z + s * d.x); };
  const auto rotate = [c, s](const glm::dvec3& d) { return glm::dvec3(c * d.x + s * d.z, d.y, c * d.z - s * d.x); };
  const glm::dvec3 n = unturn(point.normal);
  const glm::dvec3 wo = unturn(point.wo);
  if (glm::dot(n, wo) <= 0.0) return {};
  const glm::dvec3 any = std::abs(n.x) < 0.7 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 0.0, 1.0);
  const glm::dvec3 t = glm::normalize(glm::cross(any, n));
  const glm::dvec3 b = glm::cross(n, t);
  const auto to_local = [&](const glm::dvec3& d) { return glm::dvec3(glm::dot(d, t), glm::dot(d, b), glm::dot(d, n)); };
  const glm::dvec3 wo_local = to_local(wo);
  const std::function<glm::dvec3(const glm::dvec3&)> weight = [&](const glm::dvec3& w) {
    const glm::dvec3 wi = to_local(w);
    if (wi.z <= 0.0) return glm::dvec3(0.0);
    const glm::dvec3 f = evaluate_brdf(brdf, wi, wo_local) * wi.z;
    return point.visibility ? f * point.visibility(rotate(w)) : f;
  };
  return integrate_environment(environment, weight, n, 2.0 * glm::dot(n, wo) * n - wo, options);
}

}  // namespace maquette::test
