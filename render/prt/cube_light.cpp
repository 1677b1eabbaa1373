#include "render/prt/cube_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kSmallestSide = 64, kLargestSide = 512, kSamplesOfTexel = 4;
/// Points of a texel along a side, and texels of the level that they are read from: closer than its texels, so that a
/// small sun brings the same energy wherever it stands among them.
constexpr int kSamplesOfResample = 12, kTexelsOfResample = 8;

/// Solid angle of the rectangle [0, x] x [0, y] at distance 1.
double corner_angle(double x, double y) { return std::atan2(x * y, std::sqrt(x * x + y * y + 1.0)); }

double texel_angle(int side, int x, int y) {
  const auto edge = [side](int i) { return 2.0 * i / side - 1.0; };
  return corner_angle(edge(x + 1), edge(y + 1)) - corner_angle(edge(x), edge(y + 1)) -
         corner_angle(edge(x + 1), edge(y)) + corner_angle(edge(x), edge(y));
}

/// Place of a coefficient or value in a face of `side`.
std::size_t cell(int side, int x, int y) { return static_cast<std::size_t>(y * side + x); }

void transform_face(int side, float* face, std::vector<float>* scratch) {
  for (int n = side; n > 1; n /= 2) {
    const int half = n / 2;
    scratch->assign(face, face + side * side);
    for (int y = 0; y < half; ++y)
      for (int x = 0; x < half; ++x) {
        const auto value = [&](int i, int j) { return (*scratch)[cell(side, 2 * x + i, 2 * y + j)]; };
        const float a = value(0, 0), b = value(1, 0), c = value(0, 1), d = value(1, 1);
        face[cell(side, x, y)] = 0.5f * ((a + b) + (c + d));
        face[cell(side, x + half, y)] = 0.5f * ((a - b) + (c - d));
        face[cell(side, x, y + half)] = 0.5f * ((a + b) - (c + d));
        face[cell(side, x + half, y + half)] = 0.5f * ((a - b) - (c - d));
      }
  }
}

void inverse_face(int side, float* face, std::vector<float>* scratch) {
  for (int n = 2; n <= side; n *= 2) {
    const int half = n / 2;
    scratch->assign(face, face + side * side);
    for (int y = 0; y < half; ++y)
      for (int x = 0; x < half; ++x) {
        const auto value = [&](int i, int j) { return (*scratch)[cell(side, x + i * half, y + j * half)]; };
        const float s = value(0, 0), h = value(1, 0), v = value(0, 1), d = value(1, 1);
        face[cell(side, 2 * x, 2 * y)] = 0.5f * ((s + h) + (v + d));
        face[cell(side, 2 * x + 1, 2 * y)] = 0.5f * ((s - h) + (v - d));
        face[cell(side, 2 * x, 2 * y + 1)] = 0.5f * ((s + h) - (v + d));
        face[cell(side, 2 * x + 1, 2 * y + 1)] = 0.5f * ((s - h) - (v - d));
      }
  }
}

}  // namespace

glm::dvec3 cube_direction(int face, double u, double v) {
  switch (face) {
    case 0:
      return {1.0, v, -u};
    case 1:
      return {-1.0, v, u};
    case 2:
      return {u, 1.0, -v};
    case 3:
      return {u, -1.0, v};
    case 4:
      return {u, v, 1.0};
    default:
      return {-u, v, -1.0};
  }
}

CubePoint cube_point(const glm::dvec3& d) {
  const glm::dvec3 a = glm::abs(d);
  if (a.x >= a.y && a.x >= a.z)
    return d.x > 0.0 ? CubePoint{0, -d.z / a.x, d.y / a.x} : CubePoint{1, d.z / a.x, d.y / a.x};
  if (a.y >= a.z) return d.y > 0.0 ? CubePoint{2, d.x / a.y, -d.z / a.y} : CubePoint{3, d.x / a.y, d.z / a.y};
  return d.z > 0.0 ? CubePoint{4, d.x / a.z, d.y / a.z} : CubePoint{5, -d.x / a.z, d.y / a.z};
}

CubeDirections::CubeDirections(int side) : side_(side), solid_angles_(6 * side * side) {
  assert(side > 0 && (side & (side - 1)) == 0);
  for (int face = 0; face < 6; ++face)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        solid_angles_[static_cast<Eigen::Index>(directions_.size())] = texel_angle(side, x, y);
        directions_.push_back(
            glm::normalize(cube_direction(face, 2.0 * (x + 0.5) / side - 1.0, 2.0 * (y + 0.5) / side - 1.0)));
      }
}

glm::dvec3 CubeDirections::direction_within(Eigen::Index i, const glm::dvec2& at) const {
  const int n = static_cast<int>(i), face = n / (side_ * side_), y = n / side_ % side_, x = n % side_;
  return glm::normalize(cube_direction(face, 2.0 * (x + at.x) / side_ - 1.0, 2.0 * (y + at.y) / side_ - 1.0));
}

glm::vec3 CubePyramid::Level::bilinear(const glm::vec3& direction) const {
  const CubePoint p = cube_point(glm::dvec3(direction));
  const float x = static_cast<float>((p.u + 1.0) * 0.5 * side - 0.5),
              y = static_cast<float>((p.v + 1.0) * 0.5 * side - 0.5);
  const float fx = std::floor(x), fy = std::floor(y), sx = x - fx, sy = y - fy;
  const int ix = std::clamp(static_cast<int>(fx), -1, side - 1), iy = std::clamp(static_cast<int>(fy), -1, side - 1);
  return (at(p.face, ix, iy) * (1.0f - sx) + at(p.face, ix + 1, iy) * sx) * (1.0f - sy) +
         (at(p.face, ix, iy + 1) * (1.0f - sx) + at(p.face, ix + 1, iy + 1) * sx) * sy;
}

CubePyramid::CubePyramid(const Environment& environment) {
  int side = kSmallestSide;
  while (side < kLargestSide && 4 * side < environment.width) side *= 2;
  levels_.push_back(make_finest(environment, side));
  while (levels_.back().side > 1) levels_.push_back(halved(levels_.back()));
}

CubePyramid::Level CubePyramid::make_finest(const Environment& environment, int side) {
  Level level;
  level.side = side;
  level.texels.resize(static_cast<std::size_t>(6 * (side + 2) * (side + 2)));
  parallel_for(0, 6 * side, [&](int row) {
    const int face = row / side, y = row % side;
    for (int x = 0; x < side; ++x) {
      glm::dvec3 sum(0.0);
      double weights = 0.0;
      for (int j = 0; j < kSamplesOfTexel; ++j)
        for (int i = 0; i < kSamplesOfTexel; ++i) {
          const double u = 2.0 * (x + (i + 0.5) / kSamplesOfTexel) / side - 1.0;
          const double v = 2.0 * (y + (j + 0.5) / kSamplesOfTexel) / side - 1.0;
          const glm::dvec3 d = cube_direction(face, u, v);
          const double length2 = glm::dot(d, d), weight = 1.0 / (length2 * std::sqrt(length2));
          sum += weight * evaluate_environment(environment, d / std::sqrt(length2));
          weights += weight;
        }
      level.at(face, x, y) = glm::vec3(sum / weights);
    }
  });
  fill_borders(&level);
  return level;
}

CubePyramid::Level CubePyramid::halved(const Level& fine) {
  Level level;
  level.side = fine.side / 2;
  level.texels.resize(static_cast<std::size_t>(6 * (level.side + 2) * (level.side + 2)));
  for (int face = 0; face < 6; ++face)
    for (int y = 0; y < level.side; ++y)
      for (int x = 0; x < level.side; ++x) {
        glm::dvec3 sum(0.0);
        double weights = 0.0;
        for (int k = 0; k < 4; ++k) {
          const int fx = 2 * x + (k & 1), fy = 2 * y + (k >> 1);
          const double weight = texel_angle(fine.side, fx, fy);
          sum += weight * glm::dvec3(fine.at(face, fx, fy));
          weights += weight;
        }
        level.at(face, x, y) = glm::vec3(sum / weights);
      }
  fill_borders(&level);
  return level;
}

/// A border texel takes the nearest texel of the face that its direction is of.
void CubePyramid::fill_borders(Level* level) {
  const int side = level->side;
  const auto inside = [&](double u) { return std::clamp(static_cast<int>((u + 1.0) * 0.5 * side), 0, side - 1); };
  for (int face = 0; face < 6; ++face)
    for (int i = -1; i <= side; ++i)
      for (const auto& [x, y] : {std::pair(i, -1), std::pair(i, side), std::pair(-1, i), std::pair(side, i)}) {
        const CubePoint p =
            cube_point(cube_direction(face, 2.0 * (x + 0.5) / side - 1.0, 2.0 * (y + 0.5) / side - 1.0));
        level->at(face, x, y) = level->at(p.face, inside(p.u), inside(p.v));
      }
}

CubeLight CubePyramid::resample(const CubeDirections& directions, const glm::dmat3& environment_from_cube) const {
  constexpr int kPoints = kSamplesOfResample;
  std::size_t k = 0;
  while (k + 1 < levels_.size() && levels_[k + 1].side >= kTexelsOfResample * directions.side()) ++k;
  const Level& level = levels_[k];
  CubeLight light(directions.count(), 3);
  const int side = directions.side();
  const glm::mat3 turn(environment_from_cube);
  parallel_for(0, 6 * side, [&](int row) {
    const int face = row / side, y = row % side;
    for (int x = 0; x < side; ++x) {
      glm::vec3 sum(0.0f);
      float weights = 0.0f;
      for (int p = 0; p < kPoints * kPoints; ++p) {
        const double u = 2.0 * (x + (p % kPoints + 0.5) / kPoints) / side - 1.0;
        const double v = 2.0 * (y + (p / kPoints + 0.5) / kPoints) / side - 1.0;
        const glm::vec3 d(cube_direction(face, u, v));
        const float length2 = glm::dot(d, d), weight = 1.0f / (length2 * std::sqrt(length2));
        sum += weight * level.bilinear(turn * d);
        weights += weight;
      }
      for (int c = 0; c < 3; ++c) light((face * side + y) * side + x, c) = sum[c] / weights;
    }
  });
  return light;
}

std::size_t CubePyramid::bytes() const {
  std::size_t sum = 0;
  for (const Level& level : levels_) sum += level.texels.size() * sizeof(glm::vec3);
  return sum;
}

glm::dmat3 environment_rotation(double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {glm::dvec3(c, 0.0, s), glm::dvec3(0.0, 1.0, 0.0), glm::dvec3(-s, 0.0, c)};
}

void haar_transform_faces(int side, float* values) {
  std::vector<float> scratch;
  for (int face = 0; face < 6; ++face) transform_face(side, values + face * side * side, &scratch);
}

void inverse_haar_faces(int side, float* values) {
  std::vector<float> scratch;
  for (int face = 0; face < 6; ++face) inverse_face(side, values + face * side * side, &scratch);
}

}  // namespace maquette
