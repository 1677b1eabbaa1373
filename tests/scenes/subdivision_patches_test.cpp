// Limit surfaces as bicubic patches, compared with the limit positions and normals of the evaluator.
#include "scenes/subdivision_patches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "scenes/subdivision.h"

namespace maquette {
namespace {

/// A ring of `n` x `m` quads, closed in both directions: every vertex is regular.
SubdivisionCage torus(int n, int m) {
  SubdivisionCage cage;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-0.03f, 0.03f);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const float a = 6.2831853f * static_cast<float>(i) / static_cast<float>(n),
                  b = 6.2831853f * static_cast<float>(j) / static_cast<float>(m), r = 1.0f + 0.4f * std::cos(b);
      cage.positions.emplace_back(r * std::cos(a) + uniform(random), r * std::sin(a), 0.4f * std::sin(b));
      const int i2 = (i + 1) % n, j2 = (j + 1) % m;
      cage.face_indices.insert(cage.face_indices.end(), {j * n + i, j * n + i2, j2 * n + i2, j2 * n + i});
      cage.face_sizes.push_back(4);
    }
  cage.levels = 3;
  return cage;
}

/// A box, its lid one face of five corners, an edge creased.
SubdivisionCage house(float sharpness) {
  SubdivisionCage cage;
  const int n = 5;
  std::vector<int> lid, floor;
  for (int i = 0; i < n; ++i) {
    const float a = 6.2831853f * static_cast<float>(i) / static_cast<float>(n);
    const int j = (i + 1) % n;
    for (const float y : {0.0f, 1.0f}) cage.positions.emplace_back(std::cos(a), y, -std::sin(a));
    cage.face_indices.insert(cage.face_indices.end(), {2 * i, 2 * j, 2 * j + 1, 2 * i + 1});
    cage.face_sizes.push_back(4);
    lid.push_back(2 * i + 1);
    floor.insert(floor.begin(), 2 * i);
  }
  for (const std::vector<int>* face : {&lid, &floor}) {
    cage.face_indices.insert(cage.face_indices.end(), face->begin(), face->end());
    cage.face_sizes.push_back(n);
  }
  if (sharpness > 0.0f) cage.crease_edges = {{0, 1}};
  if (sharpness > 0.0f) cage.crease_sharpness = {sharpness};
  cage.levels = 4;
  return cage;
}

glm::dvec3 bezier(const std::array<glm::dvec3, 16>& points, const glm::dvec2& x) {
  const auto cubic = [](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d, double t) {
    const double s = 1.0 - t;
    return s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d;
  };
  std::array<glm::dvec3, 4> rows{};
  for (std::size_t j = 0; j < 4; ++j)
    rows[j] = cubic(points[4 * j], points[4 * j + 1], points[4 * j + 2], points[4 * j + 3], 0.5 * x.x + 0.5);
  return cubic(rows[0], rows[1], rows[2], rows[3], 0.5 * x.y + 0.5);
}

/// Nearest point of the patch to a parameter, by a descent along the axes: the parametrisation of a cap differs from
/// that of its surface.
double distance_near(const std::array<glm::dvec3, 16>& points, glm::dvec2 x, const glm::dvec3& to) {
  double best = glm::length(bezier(points, x) - to);
  for (double step = 0.2; step > 1e-3; step *= 0.5)
    for (int turn = 0; turn < 3; ++turn) {
      for (int k = 0; k < 8; ++k) {
        const double a = 0.785398 * k;
        const glm::dvec2 next = glm::clamp(x + step * glm::dvec2(std::cos(a), std::sin(a)), -1.0, 1.0);
        const double d = glm::length(bezier(points, next) - to);
        if (d < best) best = d, x = next;
      }
    }
  return best;
}

struct Off {
  double exact = 0.0, caps = 0.0;  ///< largest distance of the limit's vertices
};
Off off(const SubdivisionCage& cage, const LimitPatches& patches) {
  const SubdivisionEvaluator evaluator(cage);
  std::vector<glm::vec3> positions, normals;
  evaluator.evaluate(cage.positions, &positions, &normals);
  EXPECT_EQ(patches.patch_of_triangle.size(), evaluator.indices().size() / 3);
  Off most;
  for (std::size_t t = 0; t < patches.patch_of_triangle.size(); t += 3) {
    const int patch = patches.patch_of_triangle[t];
    EXPECT_GE(patch, 0);
    if (patch < 0) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LE(std::max(std::abs(patches.x[t][k].x), std::abs(patches.x[t][k].y)), 1.0 + 1e-9);
      const std::array<glm::dvec3, 16>& points = patches.points[static_cast<std::size_t>(patch)];
      const glm::dvec3 to(positions[evaluator.indices()[3 * t + k]]);
      if (patches.exact[static_cast<std::size_t>(patch)])
        most.exact = std::max(most.exact, glm::length(bezier(points, patches.x[t][k]) - to));
      else
        most.caps = std::max(most.caps, distance_near(points, patches.x[t][k], to));
    }
  }
  return most;
}

TEST(LimitPatches, RegularFacesAreExact) {
  const SubdivisionCage cage = torus(7, 5);
  const LimitPatches patches = make_limit_patches(cage, 2);
  EXPECT_EQ(patches.points.size(), 35u);
  for (const bool exact : patches.exact) EXPECT_TRUE(exact);
  EXPECT_LT(off(cage, patches).exact, 1e-6);  // positions of a metre, float
}

TEST(LimitPatches, CapsNearTheLimitWithEveryRefinement) {
  for (const float sharpness : {0.0f, 2.0f}) {
    const SubdivisionCage cage = house(sharpness);
    double before = 1e30;
    for (int isolation = 1; isolation <= 3; ++isolation) {
      SCOPED_TRACE(isolation);
      const LimitPatches patches = make_limit_patches(cage, isolation);
      const Off most = off(cage, patches);
      EXPECT_LT(most.exact, 2e-6);
      EXPECT_GT(most.caps, 0.0);
      EXPECT_LT(most.caps, 0.6 * before);
      before = most.caps;
    }
    EXPECT_LT(before, 2e-4);
  }
}

}  // namespace
}  // namespace maquette
