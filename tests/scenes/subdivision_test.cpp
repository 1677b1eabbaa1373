#include "scenes/subdivision.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <random>

#include "catmull_clark_reference.h"
#include "scenes/error.h"
#include "scenes/subdivision_cage.h"

namespace maquette {
namespace {

using test::ReferenceMesh;

struct Surface {
  std::vector<glm::vec3> positions, normals;
  std::vector<float> curvatures;
  std::vector<std::uint32_t> indices;
};

Surface evaluate(const SubdivisionCage& cage) {
  const SubdivisionEvaluator evaluator(cage);
  Surface out;
  evaluator.evaluate(cage.positions, &out.positions, &out.normals, &out.curvatures);
  out.indices = evaluator.indices();
  return out;
}

SubdivisionCage cube(float half = 1.0f) {
  SubdivisionCage cage;
  for (int i = 0; i < 8; ++i)
    cage.positions.push_back(half * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  cage.face_sizes.assign(6, 4);
  cage.face_indices = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
  return cage;
}

/// A prism over an n-gon; the lid is one face of n corners, the bottom is optionally open.
SubdivisionCage prism(int n, bool open) {
  SubdivisionCage cage;
  std::vector<int> lid, floor;
  for (int i = 0; i < n; ++i) {
    const float angle = glm::two_pi<float>() * static_cast<float>(i) / static_cast<float>(n);
    const int j = (i + 1) % n;
    for (const float y : {0.0f, 1.0f}) cage.positions.emplace_back(std::cos(angle), y, -std::sin(angle));
    cage.face_indices.insert(cage.face_indices.end(), {2 * i, 2 * j, 2 * j + 1, 2 * i + 1});
    cage.face_sizes.push_back(4);
    lid.push_back(2 * i + 1);
    floor.insert(floor.begin(), 2 * i);
  }
  cage.face_indices.insert(cage.face_indices.end(), lid.begin(), lid.end());
  cage.face_sizes.push_back(n);
  if (open) return cage;
  cage.face_indices.insert(cage.face_indices.end(), floor.begin(), floor.end());
  cage.face_sizes.push_back(n);
  return cage;
}

SubdivisionCage torus(int around, int across, float major_m, float minor_m) {
  SubdivisionCage cage;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const float a = glm::two_pi<float>() * static_cast<float>(i) / static_cast<float>(around);
      const float b = glm::two_pi<float>() * static_cast<float>(j) / static_cast<float>(across);
      const float r = major_m + minor_m * std::cos(b);
      cage.positions.emplace_back(r * std::cos(a), minor_m * std::sin(b), -r * std::sin(a));
      const int i1 = (i + 1) % around, j1 = (j + 1) % across;
      cage.face_indices.insert(cage.face_indices.end(),
                               {i * across + j, i1 * across + j, i1 * across + j1, i * across + j1});
      cage.face_sizes.push_back(4);
    }
  }
  return cage;
}

void shake(SubdivisionCage* cage, std::uint32_t seed, float by) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> offset(-by, by);
  for (glm::vec3& p : cage->positions) p += glm::vec3(offset(random), offset(random), offset(random));
}

/// Every vertex of the surface is the limit of a vertex of the slow reference at the same level, and vice versa.
void expect_matches_reference(const SubdivisionCage& cage) {
  ReferenceMesh mesh(cage);
  for (int level = 0; level < cage.levels; ++level) mesh = mesh.refined();
  const std::vector<glm::dvec3> expected = mesh.limit_points();
  const Surface surface = evaluate(cage);
  EXPECT_GE(surface.positions.size(), expected.size());
  std::vector<char> met(expected.size(), 0);
  for (const glm::vec3& p : surface.positions) {
    double nearest = 1e9;
    std::size_t which = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const double distance = glm::length(glm::dvec3(p) - expected[i]);
      if (distance < nearest) nearest = distance, which = i;
    }
    EXPECT_LT(nearest, 2e-6);
    met[which] = 1;
  }
  EXPECT_EQ(std::count(met.begin(), met.end(), 0), 0);
  for (const glm::vec3& normal : surface.normals) EXPECT_NEAR(glm::length(normal), 1.0f, 1e-5f);
  EXPECT_EQ(surface.indices.size(), count_limit_indices(cage));
}

TEST(Subdivision, ReachesTheLimitOfClosedRandomCages) {
  for (const int n : {3, 4, 5, 7}) {
    SubdivisionCage cage = prism(n, false);
    cage.levels = 3;
    shake(&cage, static_cast<std::uint32_t>(n), 0.15f);
    expect_matches_reference(cage);
  }
}

TEST(Subdivision, ReachesTheLimitOfOpenRandomCages) {
  for (const int n : {3, 4, 6}) {
    SubdivisionCage cage = prism(n, true);
    cage.levels = 2;
    shake(&cage, static_cast<std::uint32_t>(10 + n), 0.15f);
    expect_matches_reference(cage);
  }
  SubdivisionCage sheet;  // one face: its corners stay in place
  sheet.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.3f}, {0, 1, 0}};
  sheet.face_sizes = {4};
  sheet.face_indices = {0, 1, 2, 3};
  expect_matches_reference(sheet);
}

TEST(Subdivision, ReachesTheLimitWithCreases) {
  for (const float sharpness : {1.0f, 2.0f, 10.0f}) {
    SubdivisionCage cage = cube();
    shake(&cage, 5, 0.2f);
    cage.levels = 3;
    cage.crease_edges = {{2, 3}, {3, 7}, {7, 6}, {6, 2}, {0, 1}};  // a loop, and one edge that ends in darts
    cage.crease_sharpness.assign(5, sharpness);
    expect_matches_reference(cage);
  }
}

/// The analytic normals against a much finer refinement: at level 7 the facets have rotated by about a degree at most.
TEST(Subdivision, NormalsMatchAMuchFinerMesh) {
  SubdivisionCage cage = prism(5, false);
  cage.levels = 1;
  shake(&cage, 21, 0.1f);
  const Surface surface = evaluate(cage);
  ReferenceMesh mesh(cage);
  for (int level = 0; level < 6; ++level) mesh = mesh.refined();
  const std::vector<glm::dvec3> limit = mesh.limit_points();
  std::vector<glm::dvec3> sums(limit.size(), glm::dvec3(0.0));
  for (const std::vector<int>& f : mesh.faces)
    for (std::size_t i = 0; i < 4; ++i) {
      const auto at = [&](std::size_t k) { return limit[static_cast<std::size_t>(f[(i + k) % 4])]; };
      sums[static_cast<std::size_t>(f[i])] += glm::cross(at(1) - at(0), at(3) - at(0));
    }
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    double nearest = 1e9;
    glm::dvec3 expected(0.0);
    for (std::size_t i = 0; i < limit.size(); ++i) {
      const double distance = glm::length(glm::dvec3(surface.positions[v]) - limit[i]);
      if (distance < nearest) nearest = distance, expected = glm::normalize(sums[i]);
    }
    EXPECT_LT(nearest, 1e-5);
    EXPECT_GT(glm::dot(glm::dvec3(surface.normals[v]), expected), std::cos(glm::radians(1.0)));
  }
}

/// By symmetry the limit of a cube's corner lies on its diagonal, at 5/9 of the way: vertex limit mask for three faces.
TEST(Subdivision, CubeCornersGoWhereTheLimitMaskSays) {
  SubdivisionCage cage = cube();
  cage.levels = 4;
  const Surface surface = evaluate(cage);
  // Halstead for n = 3: (9 v + 4 sum e + sum f) / 24 with v = (1,1,1), e = (1,1,-1)..., f = (1,-1,-1)... on the cage.
  const float along = (9.0f + 4.0f * 1.0f - 1.0f) / 24.0f;
  int corners = 0;
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    const glm::vec3 p = glm::abs(surface.positions[i]);
    const glm::vec3 outwards = glm::normalize(surface.positions[i]);
    EXPECT_GT(glm::dot(surface.normals[i], outwards), 0.9f);  // the surface is nearly a sphere, normals point out
    if (glm::distance(p, glm::vec3(along)) > 1e-5f) continue;
    ++corners;
    EXPECT_LT(glm::distance(surface.normals[i], outwards), 1e-5f);
  }
  EXPECT_EQ(corners, 8);
}

/// A uniform bicubic B-spline over a grid that is closed in both directions, in double.
struct TorusSpline {
  int around, across;
  std::vector<glm::vec3> points;

  static double basis(double t) {  // cubic B-spline centred at 0
    t = std::abs(t);
    if (t >= 2.0) return 0.0;
    return t >= 1.0 ? std::pow(2.0 - t, 3.0) / 6.0 : 2.0 / 3.0 - t * t + 0.5 * t * t * t;
  }
  glm::dvec3 at(double u, double v) const {
    glm::dvec3 sum(0.0);
    const int i0 = static_cast<int>(std::floor(u)), j0 = static_cast<int>(std::floor(v));
    for (int i = i0 - 2; i <= i0 + 3; ++i)
      for (int j = j0 - 2; j <= j0 + 3; ++j) {
        const int index = (i + around) % around * across + (j + across) % across;
        sum += basis(u - i) * basis(v - j) * glm::dvec3(points[static_cast<std::size_t>(index)]);
      }
    return sum;
  }
};

/// Without extraordinary vertices the limit surface is that B-spline; its normal and curvature by central differences.
TEST(Subdivision, RegularCagesAreBSplines) {
  SubdivisionCage cage = torus(9, 8, 2.0f, 0.8f);
  shake(&cage, 3, 0.15f);
  cage.levels = 2;
  const Surface surface = evaluate(cage);
  ASSERT_EQ(surface.positions.size(), 9u * 8u * 16u);
  const TorusSpline spline{9, 8, cage.positions};
  for (int i = 0; i < 36; ++i) {
    for (int j = 0; j < 32; ++j) {
      const double u = 0.25 * i, v = 0.25 * j, h = 1e-4;
      const glm::dvec3 p = spline.at(u, v);
      std::size_t nearest = 0;
      for (std::size_t k = 0; k < surface.positions.size(); ++k)
        if (glm::distance(p, glm::dvec3(surface.positions[k])) <
            glm::distance(p, glm::dvec3(surface.positions[nearest])))
          nearest = k;
      EXPECT_LT(glm::distance(p, glm::dvec3(surface.positions[nearest])), 2e-6);
      const glm::dvec3 du = (spline.at(u + h, v) - spline.at(u - h, v)) / (2.0 * h);
      const glm::dvec3 dv = (spline.at(u, v + h) - spline.at(u, v - h)) / (2.0 * h);
      const glm::dvec3 normal = glm::normalize(glm::cross(du, dv));
      EXPECT_LT(glm::distance(normal, glm::dvec3(surface.normals[nearest])), 2e-5);
      const glm::dvec3 duu = (spline.at(u + h, v) - 2.0 * p + spline.at(u - h, v)) / (h * h);
      const glm::dvec3 dvv = (spline.at(u, v + h) - 2.0 * p + spline.at(u, v - h)) / (h * h);
      const glm::dvec3 duv =
          (spline.at(u + h, v + h) - spline.at(u - h, v + h) - spline.at(u + h, v - h) + spline.at(u - h, v - h)) /
          (4.0 * h * h);
      // Eigenvalues of the shape operator I^-1 II.
      const glm::dmat2 first(glm::dot(du, du), glm::dot(du, dv), glm::dot(du, dv), glm::dot(dv, dv));
      const glm::dmat2 second(glm::dot(duu, normal), glm::dot(duv, normal), glm::dot(duv, normal),
                              glm::dot(dvv, normal));
      const glm::dmat2 shape = glm::inverse(first) * second;
      const double mean = 0.5 * (shape[0][0] + shape[1][1]), gauss = glm::determinant(shape);
      const double root = std::sqrt(std::max(mean * mean - gauss, 0.0));
      const double expected = std::max(std::abs(mean + root), std::abs(mean - root));
      EXPECT_NEAR(surface.curvatures[nearest], expected, 1e-3 * std::max(expected, 1.0));
    }
  }
}

TEST(Subdivision, CurvatureOfATorusIsItsTubes) {
  SubdivisionCage cage = torus(96, 48, 2.0f, 0.5f);
  cage.levels = 1;
  const Surface surface = evaluate(cage);
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    const glm::dvec3 p(surface.positions[i]);
    const glm::dvec3 out = glm::normalize(p - 2.0 * glm::normalize(glm::dvec3(p.x, 0.0, p.z)));
    EXPECT_GT(glm::dot(out, glm::dvec3(surface.normals[i])), 0.9999);
    EXPECT_NEAR(surface.curvatures[i], 2.0f, 0.03f);
  }
}

/// Irregular vertices have no second derivative; the fitted curvature must still be about that of a sphere of this
/// size.
TEST(Subdivision, CurvatureIsSaneOnASphereLikeCube) {
  SubdivisionCage cage = cube(0.5f);
  cage.levels = 4;
  const Surface surface = evaluate(cage);
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    const float expected = 1.0f / glm::length(surface.positions[i]);
    EXPECT_GT(surface.curvatures[i], 0.4f * expected);
    EXPECT_LT(surface.curvatures[i], 2.5f * expected);
  }
}

/// With all edges infinitely sharp a cube stays a cube: flat faces, three normals at each corner.
TEST(Subdivision, SharpEdgesSplitNormals) {
  SubdivisionCage cage = cube();
  cage.levels = 2;
  for (std::size_t f = 0; f < 6; ++f)
    for (std::size_t i = 0; i < 4; ++i) {
      const int a = cage.face_indices[4 * f + i], b = cage.face_indices[4 * f + (i + 1) % 4];
      if (a < b) cage.crease_edges.push_back({a, b});
    }
  ASSERT_EQ(cage.crease_edges.size(), 12u);
  cage.crease_sharpness.assign(12, 10.0f);
  const Surface surface = evaluate(cage);
  EXPECT_EQ(surface.positions.size(), 6u * 25u);
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    const glm::vec3& a = surface.positions[surface.indices[i]];
    const glm::vec3 face = glm::normalize(
        glm::cross(surface.positions[surface.indices[i + 1]] - a, surface.positions[surface.indices[i + 2]] - a));
    for (std::size_t corner = 0; corner < 3; ++corner)
      EXPECT_LT(glm::distance(surface.normals[surface.indices[i + corner]], face), 1e-5f);
  }
  for (const float curvature : surface.curvatures) EXPECT_LT(curvature, 1e-4f);
}

TEST(Subdivision, TrianglesFaceAlongTheNormals) {
  for (const SubdivisionCage& cage : {cube(), prism(6, true), torus(8, 8, 2.0f, 0.5f)}) {
    const Surface surface = evaluate(cage);
    for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
      const glm::vec3& a = surface.positions[surface.indices[i]];
      const glm::vec3 face =
          glm::cross(surface.positions[surface.indices[i + 1]] - a, surface.positions[surface.indices[i + 2]] - a);
      for (std::size_t corner = 0; corner < 3; ++corner)
        EXPECT_GT(glm::dot(surface.normals[surface.indices[i + corner]], face), 0.0f);
    }
  }
}

TEST(Subdivision, ScalesWithItsCage) {
  const Surface unit = evaluate(prism(5, false));
  for (const float scale : {1e-6f, 1e6f}) {
    SubdivisionCage cage = prism(5, false);
    for (glm::vec3& p : cage.positions) p *= scale;
    const Surface scaled = evaluate(cage);
    for (std::size_t i = 0; i < unit.positions.size(); ++i) {
      EXPECT_LT(glm::distance(scaled.positions[i] / scale, unit.positions[i]), 1e-5f);
      EXPECT_LT(glm::distance(scaled.normals[i], unit.normals[i]), 1e-4f);
      EXPECT_NEAR(scaled.curvatures[i] * scale, unit.curvatures[i], 1e-3f * std::max(unit.curvatures[i], 1.0f));
    }
  }
}

TEST(Subdivision, StaysFiniteWhenControlPointsCoincide) {
  SubdivisionCage cage = cube();
  for (const std::size_t i : {0, 1, 2, 3}) cage.positions[i] = cage.positions[0];
  for (const glm::vec3& normal : evaluate(cage).normals) EXPECT_NEAR(glm::length(normal), 1.0f, 1e-5f);
  cage.positions.assign(8, glm::vec3(3.0f));
  const Surface point = evaluate(cage);
  for (std::size_t i = 0; i < point.normals.size(); ++i) {
    EXPECT_NEAR(glm::length(point.normals[i]), 1.0f, 1e-5f);
    EXPECT_TRUE(std::isfinite(point.curvatures[i]));
  }
}

TEST(Subdivision, FillsAMeshFromItsCage) {
  SubdivisionCage cage = prism(4, true);
  for (const glm::vec3& p : cage.positions) cage.uvs.emplace_back(p.x, p.y);
  Mesh mesh;
  mesh.cage = std::make_shared<const SubdivisionCage>(cage);
  tessellate_cage(&mesh);
  ASSERT_EQ(mesh.primitives.size(), 1u);
  const Primitive& out = mesh.primitives[0];
  ASSERT_EQ(out.uvs[0].size(), out.positions.size());
  // UVs are interpolated by the same rules, so a UV made of coordinates follows the coordinates.
  for (std::size_t i = 0; i < out.positions.size(); ++i)
    EXPECT_LT(glm::distance(out.uvs[0][i], glm::vec2(out.positions[i])), 1e-6f);
}

TEST(Subdivision, DentsSmoothlyAndLocally) {
  SubdivisionCage cage = torus(96, 48, 2.0f, 0.5f);
  const SubdivisionEvaluator evaluator(cage);
  std::vector<glm::vec3> before, after, normals;
  evaluator.evaluate(cage.positions, &before, &normals);
  const glm::vec3 center(2.5f, 0.0f, 0.0f);
  const SubdivisionCage untouched = cage;
  const int moved = dent_cage(&cage, center, glm::vec3(-3.0f, 0.0f, 0.0f), 0.1f, 0.4f);
  int within = 0;
  for (std::size_t i = 0; i < cage.positions.size(); ++i) {
    const float distance = glm::distance(untouched.positions[i], center);
    within += distance < 0.4f;
    const float x = std::min(distance / 0.4f, 1.0f);
    EXPECT_NEAR(untouched.positions[i].x - cage.positions[i].x, 0.1f * std::pow(1.0f - x * x, 3.0f), 1e-6f);
  }
  EXPECT_EQ(moved, within);
  EXPECT_GT(moved, 4);
  evaluator.evaluate(cage.positions, &after, &normals);
  float deepest = 0.0f;
  for (std::size_t i = 0; i < after.size(); ++i) {
    deepest = std::max(deepest, before[i].x - after[i].x);
    if (glm::distance(before[i], center) > 0.8f) {
      EXPECT_EQ(before[i], after[i]);
    }
  }
  EXPECT_GT(deepest, 0.07f);
  EXPECT_LE(deepest, 0.1f);
  EXPECT_EQ(dent_cage(&cage, center, glm::vec3(0.0f), 0.1f, 0.4f), 0);
  EXPECT_EQ(dent_cage(&cage, center, glm::vec3(1.0f), 0.1f, 0.0f), 0);
}

void expect_refused(const SubdivisionCage& cage, const std::string& fault) {
  try {
    const SubdivisionEvaluator evaluator(cage);
    FAIL() << "accepted: " << fault;
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(fault), std::string::npos) << e.what();
  }
}

TEST(Subdivision, RefusesCagesThatAreNoSurface) {
  expect_refused({}, "empty");
  SubdivisionCage cage = cube();
  cage.face_indices[3] = 8;
  expect_refused(cage, "not there");
  cage = cube();
  cage.face_indices[3] = -1;
  expect_refused(cage, "not there");
  cage = cube();
  cage.face_sizes[0] = 2;
  expect_refused(cage, "face 0 has 2 corners");
  cage = cube();
  cage.face_sizes[5] = 1 << 30;
  expect_refused(cage, "face 5");
  cage = cube();
  cage.face_sizes.pop_back();
  expect_refused(cage, "do not match");
  cage = cube();
  cage.face_indices[1] = cage.face_indices[0];
  expect_refused(cage, "twice");
  cage = cube();
  cage.levels = 30;
  expect_refused(cage, "levels");
  cage = cube();
  cage.uvs.resize(3);
  expect_refused(cage, "UVs");
  cage = cube();
  cage.positions[2].y = std::numeric_limits<float>::quiet_NaN();
  expect_refused(cage, "finite");
  cage = cube();
  cage.crease_edges = {{0, 7}};
  cage.crease_sharpness = {1.0f};
  expect_refused(cage, "is not an edge");
  cage.crease_sharpness.clear();
  expect_refused(cage, "sharpnesses");
}

TEST(Subdivision, RefusesSurfacesThatBranch) {
  SubdivisionCage book = cube();  // a seventh face on an edge that has two
  book.positions.insert(book.positions.end(), {{-2, -1, 2}, {-2, 1, 2}});
  book.face_sizes.push_back(4);
  book.face_indices.insert(book.face_indices.end(), {4, 6, 9, 8});
  expect_refused(book, "edge 4-6");
  SubdivisionCage flipped = cube();
  std::swap(flipped.face_indices[1], flipped.face_indices[3]);
  expect_refused(flipped, "opposite");
  SubdivisionCage bow_tie;
  bow_tie.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  bow_tie.face_sizes = {3, 3};
  bow_tie.face_indices = {0, 1, 2, 0, 3, 4};
  expect_refused(bow_tie, "vertex 0");
}

TEST(Subdivision, IgnoresVerticesThatNoFaceUses) {
  SubdivisionCage cage = cube();
  const Surface expected = evaluate(cage);
  cage.positions.emplace_back(100.0f);
  const Surface surface = evaluate(cage);
  EXPECT_EQ(surface.positions.size(), expected.positions.size());
  for (const glm::vec3& p : surface.positions) EXPECT_LT(glm::length(p), 2.0f);
}

}  // namespace
}  // namespace maquette
