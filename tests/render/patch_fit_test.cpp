// Patches fitted to meshes: known surfaces are reproduced, bad meshes are reported, and the stated error is the true
// one, compared with an independent search for the nearest point.
#include "render/bezier/patch_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "render/bezier/reflector_patch.h"
#include "scenes/subdivision.h"

namespace maquette {
namespace {

/// A pane of 1.2 by 0.7 m, curved in both directions, with a curved border and uneven control points.
BezierPatch uneven_pane(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  BezierPatch patch;
  for (std::size_t k = 0; k < 16; ++k) {
    const float x = static_cast<float>(k % 4) / 1.5f - 1.0f, y = static_cast<float>(k / 4) / 1.5f - 1.0f;
    patch.points[k] = {0.6f * x + 0.01f * uniform(random), 0.35f * y + 0.01f * uniform(random),
                       0.12f * x * x - 0.04f * y * y + 0.01f * uniform(random)};
  }
  return patch;
}

/// A surface over [-1, 1]^2 as a mesh of `side` x `side` quads; `hole`: of quads that are left out.
Primitive mesh_of(const std::function<glm::dvec3(double, double)>& at, std::uint32_t side,
                  const std::function<bool(std::uint32_t, std::uint32_t)>& hole = {}) {
  Primitive mesh;
  for (std::uint32_t j = 0; j <= side; ++j)
    for (std::uint32_t i = 0; i <= side; ++i) {
      const double u = 2.0 * i / side - 1.0, v = 2.0 * j / side - 1.0, h = 1e-5;
      mesh.positions.emplace_back(at(u, v));
      mesh.normals.emplace_back(glm::normalize(glm::cross(at(u + h, v) - at(u - h, v), at(u, v + h) - at(u, v - h))));
      if (i == side || j == side || (hole && hole(i, j))) continue;
      const std::uint32_t a = j * (side + 1) + i, b = a + side + 1;
      for (const std::uint32_t k : {a, a + 1, b + 1, a, b + 1, b}) mesh.indices.push_back(k);
    }
  return mesh;
}

/// Distance from one patch, by a grid search and a descent along the axes.
double distance_from(const FittedPatch& patch, const glm::dvec3& point) {
  const ReflectorPatch ready = make_reflector_patch(patch.points);
  const glm::dvec3 at = point - ready.origin;
  glm::dvec2 x(0.0);
  double best = 1e300;
  const auto try_at = [&](const glm::dvec2& node) {
    const double d = glm::length(bezier_position(ready.exact, node) - at);
    if (!(d < best)) return false;
    best = d, x = node;
    return true;
  };
  for (int j = 0; j <= 20; ++j)
    for (int i = 0; i <= 20; ++i) try_at({-1.0 + 0.1 * i, -1.0 + 0.1 * j});
  for (double step = 0.05; step > 1e-8; step *= 0.5)
    for (bool moved = true; moved;) {
      moved = false;
      for (const glm::dvec2& way :
           {glm::dvec2(step, 0), glm::dvec2(-step, 0), glm::dvec2(0, step), glm::dvec2(0, -step),
            glm::dvec2(step, step), glm::dvec2(-step, -step), glm::dvec2(step, -step), glm::dvec2(-step, step)})
        moved = try_at(glm::clamp(x + way, -1.0, 1.0)) || moved;
    }
  return best;
}

/// Largest distance of points from the nearest patch.
double distance_from(const PatchFit& fit, const std::vector<glm::vec3>& truth) {
  double most = 0.0;
  for (const glm::vec3& p : truth) {
    double least = 1e300;
    for (const FittedPatch& patch : fit.patches) least = std::min(least, distance_from(patch, glm::dvec3(p)));
    most = std::max(most, least);
  }
  return most;
}

PatchFit fit_mesh(const Primitive& mesh) {
  return fit_patches(mesh.positions, mesh.normals, mesh.uvs[0], mesh.indices);
}

/// Every triangle has a patch, its corners are where their parameters say, no vertex is farther from its patch than
/// stated, and the stated distance is reached within a twentieth.
void expect_true(const PatchFit& fit, const Primitive& mesh, double rounding_m) {
  ASSERT_EQ(fit.triangles.size(), mesh.indices.size() / 3);
  double most = 0.0;
  std::vector<std::pair<std::uint32_t, int>> looked_at;
  for (std::size_t t = 0; t < fit.triangles.size(); ++t) {
    const FittedTriangle& triangle = fit.triangles[t];
    ASSERT_GE(triangle.patch, 0);
    const FittedPatch& patch = fit.patches[static_cast<std::size_t>(triangle.patch)];
    const ReflectorPatch ready = make_reflector_patch(patch.points);
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3 at(mesh.positions[mesh.indices[3 * t + k]]);
      const double stated = glm::length(bezier_position(ready.exact, triangle.x[k]) + ready.origin - at);
      EXPECT_LE(stated, fit.largest_m + rounding_m);
      if (stated < 0.9 * fit.largest_m) continue;  // only the largest decide
      if (looked_at.size() < 40) most = std::max(most, distance_from(patch, at));
      looked_at.emplace_back(mesh.indices[3 * t + k], triangle.patch);
    }
  }
  EXPECT_GE(most + rounding_m, 0.95 * fit.largest_m);
}

TEST(PatchFit, RecoversAPatchFromItsMesh) {
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    const BezierPatch patch = uneven_pane(seed);
    const Primitive mesh = tessellate_patch(patch, 24);
    const PatchFit fit = fit_mesh(mesh);
    ASSERT_EQ(fit.patches.size(), 1u);
    EXPECT_TRUE(fit.met);
    EXPECT_LT(fit.largest_m, 2e-7);  // positions of half a metre are rounded by 3e-8
    EXPECT_LT(distance_from(fit, tessellate_patch(patch, 7).positions), 4e-7);
    EXPECT_LT(fit.normal_rad, 1e-5);
    const PatchFit blind = fit_patches(mesh.positions, {}, {}, mesh.indices);
    ASSERT_EQ(blind.patches.size(), 1u);
    EXPECT_LT(blind.largest_m, 0.25 * kFitTolerance_m);
    expect_true(blind, mesh, 1e-7);
  }
}

/// A cap of a sphere is no bicubic: the stated error is the true one, and a deep cap takes several patches.
TEST(PatchFit, KnownSurfacesMeetTheTolerance) {
  constexpr double kRadius = 0.5;
  const auto cap = [](double half_angle) {
    return [=](double u, double v) {
      return kRadius * glm::normalize(glm::dvec3(std::tan(half_angle) * u, std::tan(half_angle) * v, 1.0));
    };
  };
  const auto cylinder = [](double u, double v) {
    return glm::dvec3(kRadius * std::sin(0.7 * u), 0.6 * v, kRadius * std::cos(0.7 * u));
  };
  const auto saddle = [](double u, double v) { return glm::dvec3(0.5 * u, 0.4 * v, 0.06 * (u * u - v * v)); };
  const auto flat = [](double u, double v) { return glm::dvec3(0.5 * u + 0.1 * v, 0.4 * v, 0.2 * u - 0.1 * v); };
  const std::pair<std::function<glm::dvec3(double, double)>, std::size_t> cases[] = {
      {cap(0.1), 1}, {cap(0.4), 4}, {cap(0.9), 16}, {cylinder, 2}, {saddle, 1}, {flat, 1}};
  for (std::size_t c = 0; c < std::size(cases); ++c) {
    SCOPED_TRACE(c);
    const auto& [at, patches] = cases[c];
    const Primitive mesh = mesh_of(at, 40);
    const PatchFit fit = fit_mesh(mesh);
    EXPECT_TRUE(fit.met) << fit.largest_m;
    EXPECT_LE(fit.patches.size(), patches);
    EXPECT_LT(fit.normal_rad, 0.02);
    expect_true(fit, mesh, 1e-7);
    std::vector<glm::vec3> between;
    for (int k = 0; k < 40; ++k) between.emplace_back(at(std::sin(12.9 * k), std::sin(78.2 * k)));
    EXPECT_LT(distance_from(fit, between), 1.5 * kFitTolerance_m);
  }
}

TEST(PatchFit, SizeAndPositionDoNotMatter) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    SCOPED_TRACE(scale);
    const glm::dvec3 offset = scale * glm::dvec3(3.0, -2.0, 1.0);
    const Primitive mesh = mesh_of(
        [&](double u, double v) { return offset + scale * glm::dvec3(0.5 * u, 0.3 * v, 0.1 * u * u - 0.05 * v * v); },
        20);
    const PatchFit fit = fit_patches(mesh.positions, {}, {}, mesh.indices);
    EXPECT_GE(fit.patches.size(), 1u);
    EXPECT_LT(fit.largest_m, 1e-6 * scale);
    expect_true(fit, mesh, 1e-9 * scale);
  }
}

TEST(PatchFit, HolesAndTrimmedOutlinesAreFitted) {
  const auto at = [](double u, double v) {
    return glm::dvec3(0.5 * u, 0.4 * v, 0.1 * u * u + 0.05 * v * v + 0.02 * u * v);
  };
  const Primitive mesh = mesh_of(at, 40, [](std::uint32_t i, std::uint32_t j) {
    const double x = i - 20.0, y = j - 20.0;
    return x * x + y * y < 36.0 || x + y > 18.0;  // a round hole, a corner cut off
  });
  const PatchFit fit = fit_mesh(mesh);
  ASSERT_EQ(fit.patches.size(), 1u);
  EXPECT_TRUE(fit.met);
  expect_true(fit, mesh, 1e-7);
}

/// Two sheets 4 mm apart and the rim between them.
TEST(PatchFit, AClosedBodyIsSplitIntoSheets) {
  Primitive body;
  const auto add = [&](const Primitive& part) {
    const auto first = static_cast<std::uint32_t>(body.positions.size());
    body.positions.insert(body.positions.end(), part.positions.begin(), part.positions.end());
    body.normals.insert(body.normals.end(), part.normals.begin(), part.normals.end());
    for (const std::uint32_t k : part.indices) body.indices.push_back(first + k);
  };
  const auto sheet = [](double lift) {
    return [=](double u, double v) { return glm::dvec3(0.5 * u, 0.3 * v, lift + 0.08 * u * u + 0.03 * v * v); };
  };
  add(mesh_of(sheet(0.0), 24));
  add(mesh_of(sheet(0.004), 24));
  for (const double side : {-1.0, 1.0}) {
    add(mesh_of([&](double u, double w) { return sheet(0.002 + 0.002 * w)(u, side); }, 24));
    add(mesh_of([&](double v, double w) { return sheet(0.002 + 0.002 * w)(side, v); }, 24));
  }
  const PatchFit fit = fit_mesh(body);
  EXPECT_TRUE(fit.met) << fit.largest_m;
  EXPECT_EQ(fit.patches.size(), 6u);
  EXPECT_LT(fit.normal_rad, 1e-3);
  expect_true(fit, body, 1e-7);
}

TEST(PatchFit, NoiseIsSmoothedAndStated) {
  const BezierPatch patch = uneven_pane(3);
  Primitive mesh = tessellate_patch(patch, 40);
  std::mt19937 random(4);
  std::normal_distribution<float> noise(0.0f, 3e-4f);
  for (glm::vec3& p : mesh.positions) p.z += noise(random);
  const PatchFit fit = fit_mesh(mesh);
  ASSERT_EQ(fit.patches.size(), 1u);
  EXPECT_FALSE(fit.met);
  EXPECT_GT(fit.rms_m, 1.5e-4);
  EXPECT_LT(fit.rms_m, 4e-4);
  expect_true(fit, mesh, 1e-7);
  EXPECT_LT(distance_from(fit, tessellate_patch(patch, 9).positions), 1.5e-4);
}

TEST(PatchFit, BadMeshesAreReportedOrFitted) {
  const Primitive mesh = tessellate_patch(uneven_pane(5), 12);
  const auto fit = [&](auto&& spoil) {
    Primitive bad = mesh;
    spoil(&bad);
    const PatchFit result = fit_mesh(bad);
    for (const FittedPatch& patch : result.patches)
      for (const glm::dvec3& p : patch.points) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z) && glm::length(p) < 10.0);
    EXPECT_EQ(result.patches.empty(), !result.why.empty());
    return result;
  };
  EXPECT_TRUE(fit([](Primitive* p) { p->indices.clear(); }).patches.empty());
  EXPECT_TRUE(
      fit([](Primitive* p) { p->positions.assign(p->positions.size(), glm::vec3(1.0f, 2.0f, 3.0f)); }).patches.empty());
  EXPECT_TRUE(fit([](Primitive* p) {
                for (glm::vec3& at : p->positions) at = {at.x, 0.5f * at.x, 0.0f};
              }).patches.empty());
  EXPECT_TRUE(fit([](Primitive* p) { p->positions.assign(p->positions.size(), glm::vec3(NAN)); }).patches.empty());
  const auto flipped = fit([](Primitive* p) {
    for (glm::vec3& n : p->normals) n = -n;
  });
  EXPECT_LT(flipped.normal_rad, 1e-4);
  EXPECT_TRUE(fit([](Primitive* p) { p->normals.clear(); }).met);
  EXPECT_TRUE(fit([](Primitive* p) {  // wrong normals do not matter
                for (std::size_t k = 0; k < p->normals.size(); ++k)
                  p->normals[k] = glm::normalize(glm::vec3(std::sin(7.3f * static_cast<float>(k)), 1.0f, 0.2f));
              })
                  .met);
  EXPECT_TRUE(fit([](Primitive* p) { p->normals.assign(p->normals.size(), glm::vec3(NAN)); }).met);
  EXPECT_TRUE(fit([](Primitive* p) {  // slivers: triangles of no height between the others
                for (std::uint32_t k = 0; k + 2 < 60; k += 3) p->indices.insert(p->indices.end(), {k, k, k + 1});
              })
                  .met);
  EXPECT_GE(fit([](Primitive* p) {  // one edge collapsed to a point
              for (std::size_t i = 0; i < 13; ++i) p->positions[i] = p->positions[0];
            })
                .patches.size(),
            1u);
  EXPECT_TRUE(fit([](Primitive* p) { p->indices.resize(12); }).met);  // fewer vertices than control points
}

/// An unmodified subdivision surface gets its own patches, whatever the transform of its node; a dented one does not.
TEST(PatchFit, SubdivisionSurfacesGiveTheirPatches) {
  SubdivisionCage cage;  // 6 x 6 quads of a bowl, open
  for (int j = 0; j <= 6; ++j)
    for (int i = 0; i <= 6; ++i) {
      const float x = 0.1f * static_cast<float>(i) - 0.3f, y = 0.1f * static_cast<float>(j) - 0.3f;
      cage.positions.emplace_back(x, y, 0.8f * (x * x + 2.0f * y * y));
      if (i == 6 || j == 6) continue;
      cage.face_indices.insert(cage.face_indices.end(), {7 * j + i, 7 * j + i + 1, 7 * j + i + 8, 7 * j + i + 7});
      cage.face_sizes.push_back(4);
    }
  Mesh mesh;
  mesh.cage = std::make_shared<const SubdivisionCage>(cage);
  tessellate_cage(&mesh);
  for (const float turn : {1.0f, -1.0f}) {
    glm::dmat4 world(1.0);
    world[0][0] = turn;  // a node that mirrors rewinds its triangles
    world[3] = glm::dvec4(1.0, 2.0, 3.0, 1.0);
    Primitive shown = mesh.primitives[0];
    for (glm::vec3& p : shown.positions) p = glm::vec3(world * glm::dvec4(glm::dvec3(p), 1.0));
    for (glm::vec3& n : shown.normals) n.x *= turn;
    for (std::size_t k = 0; k < shown.indices.size() && turn < 0.0f; k += 3)
      std::swap(shown.indices[k + 1], shown.indices[k + 2]);
    const auto fit = limit_patches_of(cage, world, shown.positions, shown.normals, shown.indices);
    ASSERT_TRUE(fit.has_value());
    EXPECT_EQ(fit->exact, fit->patches.size());  // its corners are sharp, its sides and its inside regular
    EXPECT_LT(fit->largest_m, 1e-6);
    EXPECT_LT(fit->normal_rad, 1e-3);
    expect_true(*fit, shown, 1e-6);
    shown.positions[shown.positions.size() / 2].z += 0.01f;
    EXPECT_FALSE(limit_patches_of(cage, world, shown.positions, shown.normals, shown.indices).has_value());
  }
}

/// A sub-patch equals the patch there.
TEST(PatchFit, PartsOfAPatchAreThePatch) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int k = 0; k < 100; ++k) {
    std::array<glm::dvec3, 16> points{};
    for (glm::dvec3& p : points) p = {uniform(random), uniform(random), uniform(random)};
    glm::dvec4 within(uniform(random), uniform(random), 0.0, 0.0);
    within.z = within.x + 1e-3 + std::abs(uniform(random));
    within.w = within.y + 1e-3 + std::abs(uniform(random));
    const ReflectorPatch whole = make_reflector_patch(points),
                         part = make_reflector_patch(part_of_patch(points, within));
    for (int n = 0; n < 20; ++n) {
      const glm::dvec2 x(uniform(random), uniform(random)),
          at = glm::mix(glm::dvec2(within), glm::dvec2(within.z, within.w), 0.5 * x + 0.5);
      if (std::max(std::abs(at.x), std::abs(at.y)) > 1.0) continue;  // beyond that `whole` is continued linearly
      const glm::dvec3 d =
          bezier_position(whole.exact, at) + whole.origin - bezier_position(part.exact, x) - part.origin;
      EXPECT_LT(glm::length(d), 1e-12);
    }
  }
}

}  // namespace
}  // namespace maquette
