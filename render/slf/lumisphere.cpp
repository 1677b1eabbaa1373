#include "render/slf/lumisphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/slf/parabolic.h"

namespace maquette {

namespace {

/// Points of the quadrature over a bin: columns, and Gauss points along each.
constexpr int kQuadratureColumns = 512;
constexpr std::array<double, 3> kGaussAt{0.238619186083197, 0.661209386466265, 0.932469514203152};
constexpr std::array<double, 3> kGaussWeight{0.467913934572691, 0.360761573048139, 0.171324492379170};
/// Bins with less of their area above the horizon would be sampled by rounding alone.
constexpr double kLeastArea = 1e-6;

/// Solid angle of the map's area, sr. Source: Heidrich and Seidel 1998, Sec. 3.
double jacobian(double r2) { return 4.0 / ((1.0 + r2) * (1.0 + r2)); }
double cosine(double r2) { return (1.0 - r2) / (1.0 + r2); }
/// Of a bin's columns: keeps densities above 0 at the rim, where the projected solid angle ends.
constexpr float kSteepest = 0.95f;

}  // namespace

Lumisphere::Lumisphere(int side) : side_(side), bin_of_cell_(static_cast<std::size_t>(side * side), -1) {
  const double width = 2.0 / side;
  double all_solid = 0.0, all_projected = 0.0;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      Bin bin;
      bin.cell = y * side + x;
      const double x0 = -1.0 + width * x, y0 = -1.0 + width * y;
      double area = 0.0;
      for (int i = 0; i < kQuadratureColumns; ++i) {
        const double u = x0 + width * (i + 0.5) / kQuadratureColumns;
        const double rim = std::sqrt(std::max(1.0 - u * u, 0.0));
        const double a = std::max(y0, -rim), b = std::min(y0 + width, rim);
        if (b <= a) continue;
        const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
        area += (b - a) * width / kQuadratureColumns;
        for (std::size_t g = 0; g < 3; ++g)
          for (const double sign : {-1.0, 1.0}) {
            const double v = middle + sign * half * kGaussAt[g], r2 = u * u + v * v;
            const double w = kGaussWeight[g] * half * width / kQuadratureColumns * jacobian(r2);
            bin.solid_angle += w;
            bin.projected += w * cosine(r2);
          }
      }
      if (area < kLeastArea) continue;
      glm::dvec2 center(x0 + 0.5 * width, y0 + 0.5 * width);
      center *= std::min(1.0, static_cast<double>(kGrazing) / std::max(glm::length(center), 1e-9));
      bin.direction = glm::normalize(shared::direction_from_parabolic(glm::vec2(center)));
      all_solid += bin.solid_angle;
      all_projected += bin.projected;
      bin_of_cell_[static_cast<std::size_t>(bin.cell)] = static_cast<int>(bins_.size());
      bins_.push_back(bin);
    }
  for (Bin& bin : bins_) {
    bin.solid_angle *= 2.0 * std::numbers::pi / all_solid;
    bin.projected *= std::numbers::pi / all_projected;
    const float x0 = low(bin.cell % side_), step = low(1) - low(0);
    float sum = 0.0f;
    for (int c = 0; c < kColumns; ++c) {
      constexpr int kPoints = 16;
      for (int k = 0; k < kPoints; ++k) {
        const float at = (static_cast<float>(c) + (static_cast<float>(k) + 0.5f) / kPoints) / kColumns;
        sum += column(bin, x0 + step * at).mass;
      }
      bin.running[c + 1] = sum;
    }
    for (float& r : bin.running) r /= sum;
  }
}

Lumisphere::Column Lumisphere::column(const Bin& bin, float x) const {
  const float rim = std::sqrt(std::max(1.0f - x * x, 0.0f));
  const int row = bin.cell / side_;
  Column column{std::max(low(row), -rim), std::min(low(row + 1), rim)};
  if (!(column.high > column.low)) return column;
  const auto projected = [&](float y) {
    const double r2 = std::min(static_cast<double>(x) * x + static_cast<double>(y) * y, 1.0);
    return static_cast<float>(jacobian(r2) * cosine(r2));
  };
  const float below = projected(column.low), above = projected(column.high);
  column.mass = 0.5f * (below + above) * (column.high - column.low);
  column.slope = std::clamp((above - below) / std::max(above + below, 1e-20f), -kSteepest, kSteepest);
  return column;
}

int Lumisphere::bin_of(const glm::vec3& direction) const {
  const glm::vec2 p = shared::parabolic_from_direction(direction);
  const auto index = [&](float v) {
    return std::clamp(static_cast<int>((v + 1.0f) * 0.5f * static_cast<float>(side_)), 0, side_ - 1);
  };
  int x = index(p.x), y = index(p.y);
  // A direction on the horizon may fall into a cell that has no area above it.
  while (bin_of_cell(y * side_ + x) < 0) {
    if (std::abs(p.x) > std::abs(p.y))
      x += p.x < 0.0f ? 1 : -1;
    else
      y += p.y < 0.0f ? 1 : -1;
  }
  return bin_of_cell(y * side_ + x);
}

int Lumisphere::bin_near_cell(int x, int y) const {
  const bool inside = x >= 0 && y >= 0 && x < side_ && y < side_;
  if (const int bin = inside ? bin_of_cell(y * side_ + x) : -1; bin >= 0) return bin;
  const glm::vec2 p = (glm::vec2(x, y) + 0.5f) * (2.0f / static_cast<float>(side_)) - 1.0f;
  return bin_of(shared::direction_from_parabolic(p * (0.999f / std::max(glm::length(p), 1e-6f))));
}

float Lumisphere::area_density(const Bin& bin, const glm::vec2& p) const {
  const float step = low(1) - low(0);
  const float along = std::clamp((p.x - low(bin.cell % side_)) / step, 0.0f, 0x1.fffffep-1f);
  const int c = static_cast<int>(along * kColumns);
  const Column at = column(bin, p.x);
  if (!(at.high > at.low)) return 0.0f;
  const float t = std::clamp((p.y - at.low) / (at.high - at.low), 0.0f, 1.0f);
  return (bin.running[c + 1] - bin.running[c]) * kColumns / (step * (at.high - at.low)) *
         (1.0f + at.slope * (2.0f * t - 1.0f));
}

Lumisphere::Sample Lumisphere::draw(int index, const glm::vec2& uv) const {
  const Bin& bin = bins_[static_cast<std::size_t>(index)];
  const float step = low(1) - low(0);
  int c = 0;
  while (c + 1 < kColumns && uv.x >= bin.running[c + 1]) ++c;
  const float share = bin.running[c + 1] - bin.running[c];
  if (!(share > 0.0f)) return {};
  const float within = std::clamp((uv.x - bin.running[c]) / share, 0.0f, 1.0f);
  glm::vec2 p{};
  p.x = low(bin.cell % side_) + step * (static_cast<float>(c) + within) / kColumns;
  const Column at = column(bin, p.x);
  if (!(at.high > at.low)) return {};
  // Inverse of the running density t + slope (t^2 - t), without cancellation.
  const float flat = 1.0f - at.slope;
  p.y = at.low + (at.high - at.low) * (2.0f * uv.y / (flat + std::sqrt(flat * flat + 4.0f * at.slope * uv.y)));
  const float r2 = glm::dot(p, p);
  if (r2 >= 1.0f) return {};
  Sample sample;
  sample.direction = glm::normalize(shared::direction_from_parabolic(p));
  sample.density = area_density(bin, p) / static_cast<float>(jacobian(static_cast<double>(r2)));
  sample.weight = sample.direction.z / (sample.density * static_cast<float>(bin.projected));
  return sample;
}

float Lumisphere::density(int bin, const glm::vec3& direction) const {
  const glm::vec2 p = shared::parabolic_from_direction(direction);
  return area_density(bins_[static_cast<std::size_t>(bin)], p) /
         static_cast<float>(jacobian(static_cast<double>(glm::dot(p, p))));
}

}  // namespace maquette
