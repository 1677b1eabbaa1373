#include "render/octree/cell_brdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "render/math/local_pca.h"
#include "render/octree/octree_shared.h"
#include "tests/support/cell_reference.h"

namespace maquette {
namespace {

using shared::kCellDirections;
using shared::kCellPairs;
using test::CellContent;
using test::rectangle;

CellReflectance lambert(const glm::vec3& albedo) {
  return [albedo](const glm::vec3&, const glm::vec3&) { return albedo * static_cast<float>(1.0 / std::numbers::pi); };
}

glm::dvec3 direction(int i) { return glm::normalize(glm::dvec3(shared::cell_direction(i))); }
double seen(const Eigen::VectorXf& v, int i) { return static_cast<double>(v[3 * kCellPairs + i]); }
glm::dvec3 lit(const Eigen::VectorXf& v, int i, int j) {
  const int pair = 3 * shared::cell_pair(i, j);
  return {v[pair], v[pair + 1], v[pair + 2]};
}

/// The T of Fig. 11.13: a base of one colour and an upright of another.
CellContent t_shape() {
  CellContent t;
  t.polygons = {rectangle({0.0, 0.5, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}),
                rectangle({0.5, 0.5, 0.0}, {0.0, 0.0, 1.0}, {0.0, 0.5, 0.0})};
  t.reflectance = {lambert(glm::vec3(0.5f)), lambert({0.8f, 0.1f, 0.1f})};
  return t;
}

CellContent random_content(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  CellContent content;
  const int count = 1 + static_cast<int>(seed % 6u);
  for (int k = 0; k < count; ++k) {
    ClipPolygon p;
    p.count = 3;
    for (int c = 0; c < 3; ++c) p.corners[c] = {u(random), u(random), u(random)};
    content.polygons.push_back(p);
    Material m;
    m.metallic = static_cast<float>(k % 2);
    m.roughness = static_cast<float>(0.2 + 0.8 * u(random));
    m.base_color = glm::vec4(u(random), u(random), u(random), 1.0);
    content.reflectance.push_back(CellMaterial(m).brdf(glm::vec3(1.0f)));
  }
  return content;
}

TEST(CellDirections, LookupsFindTheirPixelsAndWeighTheSphereOnce) {
  for (int i = 0; i < kCellDirections; ++i) {
    const glm::vec3 d = glm::normalize(shared::cell_direction(i));
    if ((d.z < 0.0f) != (i >= kCellDirections / 2)) continue;  // beyond the horizon: belongs to the other map
    const auto at = shared::cell_lookup(d);
    int nearest = at.first + (at.x > 0.5f ? 1 : 0) + (at.y > 0.5f ? shared::kCellSide : 0);
    EXPECT_EQ(nearest, i);
    EXPECT_LT(std::abs(at.x - std::round(at.x)) + std::abs(at.y - std::round(at.y)), 1e-4f);
  }
  double sum = 0.0;
  for (float w : cell_solid_angles()) sum += static_cast<double>(w);
  EXPECT_NEAR(sum, 4.0 * std::numbers::pi, 1e-3);
  // A constant is interpolated exactly, the cosine approximately.
  double cosine = 0.0;
  for (int i = 0; i < kCellDirections; ++i)
    cosine += static_cast<double>(cell_solid_angles()[static_cast<std::size_t>(i)]) * std::max(direction(i).z, 0.0);
  EXPECT_NEAR(cosine, std::numbers::pi, 0.03 * std::numbers::pi);
}

/// Compares the table that bakes use with the formulas.
TEST(CellMaterial, TheTableIsTheBrdf) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> u(0.0f, 1.0f);
  for (int kind = 0; kind < 6; ++kind) {
    Material m;
    m.metallic = static_cast<float>(kind % 2);
    m.roughness = 0.1f + 0.15f * static_cast<float>(kind);
    m.clearcoat = kind == 4 ? 1.0f : 0.0f;
    m.sheen_color = glm::vec3(kind == 5 ? 0.4f : 0.0f);
    m.sheen_roughness = 0.5f;
    std::shared_ptr<const BrdfTable> table;
    if (kind == 3) table = std::make_shared<const BrdfTable>(make_builtin_brdf("leather-tan")), m.measured = "x";
    CellMaterial material(m, table);
    material.make_grid();
    const glm::vec3 color(0.7f, 0.4f, 0.1f);
    const auto exact = material.brdf(color), fast = material.fast_brdf(color);
    double difference = 0.0, total = 0.0;
    for (int k = 0; k < 20000; ++k) {
      const auto direction = [&] {
        const float z = std::max(u(random), 0.02f), phi = 6.2831853f * u(random), r = std::sqrt(1.0f - z * z);
        return glm::vec3(r * std::cos(phi), r * std::sin(phi), z);
      };
      const glm::vec3 wi = direction(), wo = direction();
      const double weight = static_cast<double>(wi.z * wo.z);
      difference += weight * static_cast<double>(glm::length(exact(wi, wo) - fast(wi, wo)));
      total += weight * static_cast<double>(glm::length(exact(wi, wo)));
    }
    EXPECT_LT(difference, (table ? 0.1 : 0.05) * total) << kind;
  }
}

TEST(CellBrdf, AnEmptyCellIsTransparent) {
  const Eigen::VectorXf v = compute_cell_brdf({}, {}, glm::mat3(1.0f), {});
  EXPECT_EQ(v.squaredNorm(), 0.0f);
}

/// Part of a plane: the visible area is the projected area, and the reflected light is Lambert's.
TEST(CellBrdf, AFlatLambertCellIsLambert) {
  CellContent content;
  content.polygons = {rectangle({0.1, 0.4, 0.2}, {0.0, 0.0, 0.7}, {0.6, 0.0, 0.0})};
  content.reflectance = {lambert({0.6f, 0.3f, 0.1f})};
  const glm::vec3 up(0.0f, 1.0f, 0.0f);
  const Eigen::VectorXf v = test::bake_content(content, up, 5);
  const glm::dmat3 frame(cell_frame(up));
  for (int i = 0; i < kCellDirections; ++i) {
    const double ci = glm::dot(frame * direction(i), glm::dvec3(up));
    EXPECT_NEAR(seen(v, i), 0.42 * std::abs(ci), 1e-5);
    const double outline = static_cast<double>(shared::cell_outline(glm::vec3(frame * direction(i))));
    EXPECT_GE(1.0 - seen(v, i) / outline, 0.0);  // transparency: the uncovered share of the outline
    for (int j = 0; j < kCellDirections; ++j) {
      const double cj = glm::dot(frame * direction(j), glm::dvec3(up));
      const double expected = ci * cj > 0.0 ? 0.42 * ci * cj / std::numbers::pi : 0.0;
      const glm::dvec3 e = lit(v, i, j);
      EXPECT_NEAR(e.x, 0.6 * expected, 1e-5);
      EXPECT_NEAR(e.z, 0.1 * expected, 1e-5);
    }
  }
}

TEST(CellBrdf, AWhiteCellConservesEnergy) {
  // Under uniform light of 1 a convex white cell has radiance 1 in every visible direction; one with concavities has
  // less, never more.
  const auto omega = cell_solid_angles();
  for (int hollow = 0; hollow < 2; ++hollow) {
    CellContent content = t_shape();
    content.reflectance = {lambert(glm::vec3(1.0f)), lambert(glm::vec3(1.0f))};
    if (!hollow) content.polygons.pop_back(), content.reflectance.pop_back();
    const Eigen::VectorXf v = test::bake_content(content, {0.0f, 1.0f, 0.0f}, 200);
    for (int i = 0; i < kCellDirections; ++i) {
      double sum = 0.0;
      for (int j = 0; j < kCellDirections; ++j)
        sum += static_cast<double>(omega[static_cast<std::size_t>(j)]) * lit(v, i, j).x;
      if (hollow)
        EXPECT_LE(sum, 1.03 * seen(v, i));
      else
        EXPECT_NEAR(sum, seen(v, i), 0.03 * seen(v, i) + 1e-6);
    }
  }
}

/// A curved, glossy cell, rotated about its normal and mirrored: in its own frame it stays the same.
TEST(CellBrdf, TheFrameRotatesWithTheCell) {
  Material gloss;
  gloss.metallic = 1.0f;
  gloss.roughness = 0.3f;
  const CellMaterial material(gloss);
  const std::vector<CellReflectance> reflectance(24, material.brdf(glm::vec3(1.0f)));
  const glm::vec3 up(0.0f, 1.0f, 0.0f);
  Eigen::VectorXf first, first_plain;
  double most = 0.0, most_plain = 0.0;
  for (int k = 0; k < 16; ++k) {
    std::vector<CellSample> samples;
    const double angle = 0.4 * k, side = k & 1 ? -1.0 : 1.0;
    for (int i = 0; i < 24; ++i) {  // an arc that curves more to one side, and a little across
      const double bend = -0.5 + 1.3 * i / 23.0, x = std::sin(bend), z = side * 0.2 * i / 23.0;
      const glm::dvec3 n = glm::normalize(glm::dvec3(x, std::cos(bend), z));
      samples.push_back(
          {glm::dvec3(0.0),
           {std::cos(angle) * n.x - std::sin(angle) * n.z, n.y, std::sin(angle) * n.x + std::cos(angle) * n.z},
           1.0 / 24.0,
           i});
    }
    const auto vector = [&](const CellRotation& turn) {
      return compute_cell_brdf(samples, reflectance, cell_frame(up, turn), {});
    };
    const CellRotation turn = find_cell_rotation(samples, up);
    EXPECT_LT(turn.steps, 1u << CellRotation::kBits);
    const Eigen::VectorXf own = vector(turn), plain = vector({});
    if (k == 0) first = own, first_plain = plain;
    most = std::max(most, static_cast<double>((own - first).norm() / first.norm()));
    most_plain = std::max(most_plain, static_cast<double>((plain - first_plain).norm() / first_plain.norm()));
  }
  EXPECT_LT(most, 2e-3);
  EXPECT_GT(most_plain, 0.2);
}

/// Compares with a distant eye that looks at the cell, for the T and for random cells of matte and glossy pieces.
TEST(CellBrdf, MatchesADistantEye) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const CellContent content = seed == 0 ? t_shape() : random_content(seed);
    const glm::vec3 normal =
        seed == 0 ? glm::vec3(0.0f, 1.0f, 0.0f) : glm::vec3(glm::normalize(polygon_area_vector(content.polygons[0])));
    const Eigen::VectorXf v = test::bake_content(content, normal, 4096);
    const glm::dmat3 frame(cell_frame(normal));
    std::vector<glm::dvec3> lights;
    for (int j = 0; j < kCellDirections; j += 5) lights.push_back(frame * direction(j));
    double difference = 0.0, total = 0.0;
    for (int i = 0; i < kCellDirections; i += 7) {
      const auto view = test::compute_cell_view(content, frame * direction(i), lights, 160);
      EXPECT_NEAR(seen(v, i), view.seen, 0.02) << seed << " " << i;
      for (std::size_t k = 0; k < lights.size(); ++k) {
        difference += glm::length(lit(v, i, static_cast<int>(5 * k)) - view.lit[k]);
        total += glm::length(view.lit[k]);
      }
    }
    EXPECT_LT(difference, 0.03 * total) << seed;
  }
}

/// What a material index and a mean normal cannot represent: from above only the base is visible, from the side the
/// upright, and half of the cell is empty.
TEST(CellBrdf, TheTChangesColourAndTransparencyWithTheView) {
  const Eigen::VectorXf v = test::bake_content(t_shape(), {0.0f, 1.0f, 0.0f}, 1000);
  const glm::dmat3 frame(cell_frame({0.0f, 1.0f, 0.0f}));
  const auto nearest = [&](const glm::dvec3& world) {
    int best = 0;
    for (int i = 1; i < kCellDirections; ++i)
      if (glm::dot(frame * direction(i), world) > glm::dot(frame * direction(best), world)) best = i;
    return best;
  };
  const auto colour = [&](int view) {
    glm::dvec3 sum(0.0);
    for (int j = 0; j < kCellDirections; ++j)
      sum += static_cast<double>(cell_solid_angles()[static_cast<std::size_t>(j)]) * lit(v, view, j);
    return sum / seen(v, view);
  };
  const int above = nearest({0.0, 1.0, 0.0}), side = nearest(glm::normalize(glm::dvec3(1.0, 0.02, 0.0)));
  EXPECT_NEAR(colour(above).x, colour(above).y, 0.01);  // grey
  EXPECT_GT(colour(side).x, 2.0 * colour(side).y);      // red
  EXPECT_GT(seen(v, above), 0.95);
  const glm::vec3 d(frame * direction(side));
  EXPECT_NEAR(seen(v, side) / static_cast<double>(shared::cell_outline(d)), 0.5, 0.1);
}

/// A compression fitted to randomly rotated and scaled copies of the T reproduces the T itself.
TEST(CellBrdf, LocalPcaReproducesTheT) {
  constexpr int kTraining = 120;
  Eigen::MatrixXf vectors(kCellBrdfDimension, kTraining);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  for (int k = 0; k < kTraining; ++k) {
    const double height = 0.15 + 0.7 * u(random), at = 0.15 + 0.7 * u(random);
    CellContent t;
    t.polygons = {rectangle({0.0, height, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}),
                  rectangle({at, height, 0.0}, {0.0, 0.0, 1.0}, {0.0, 1.0 - height, 0.0})};
    t.reflectance = {lambert(glm::vec3(0.2f + 0.6f * static_cast<float>(u(random)))),
                     lambert({static_cast<float>(u(random)), 0.1f, 0.1f})};
    vectors.col(k) = test::bake_content(t, {0.0f, 1.0f, 0.0f}, 128);
  }
  const Eigen::VectorXf measure = cell_brdf_measure();
  const LocalPca pca = LocalPca::fit(vectors, measure, {.clusters = 6, .components = 4});
  const Eigen::VectorXf t = test::bake_content(t_shape(), {0.0f, 1.0f, 0.0f}, 256);
  const double energy = static_cast<double>(measure.dot(t.cwiseAbs2()));
  EXPECT_LT(std::sqrt(pca.error(t) / energy), 0.08);
  // The path through a bake file: means and components are written and read.
  Eigen::MatrixXf means(kCellBrdfDimension, pca.cluster_count());
  Eigen::MatrixXf components(kCellBrdfDimension, 4 * pca.cluster_count());
  for (int k = 0; k < pca.cluster_count(); ++k) {
    means.col(k) = pca.mean(k);
    components.middleCols(4 * k, 4) = pca.components(k);
  }
  const LocalPca again = LocalPca::restore(measure, means, components);
  EXPECT_NEAR(again.error(t), pca.error(t), 1e-3 * pca.error(t) + 1e-9);
}

}  // namespace
}  // namespace maquette
