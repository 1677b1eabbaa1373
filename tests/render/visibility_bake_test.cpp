#include "render/visibility/visibility_bake.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "render/math/shared_formulas.h"
#include "render/visibility/visibility_kind.h"
#include "render/visibility/visibility_points.h"
#include "render/visibility/visibility_sides.h"
#include "tests/support/flat_scenes.h"
#include "tests/support/never.h"

namespace maquette {
namespace {

using namespace test;

bool is_open(const VisibilityBake& bake, std::size_t vertex, int bit) {
  return ((bake.vertices[vertex][static_cast<std::size_t>(bit >> 5)] >> (bit & 31)) & 1u) != 0;
}

glm::vec3 cell_direction(int bit) { return shared::visibility_cell_direction(glm::ivec2(bit & 15, bit >> 4)); }

VisibilityBake bake_opaque(const FlatGeometry& g) {
  auto bake = bake_visibility(g, std::vector<bool>(g.items.size(), false), {}, kNever);
  EXPECT_TRUE(bake.has_value());
  return bake.value_or(VisibilityBake{});
}

void transform(FlatGeometry* g, float scale, const glm::vec3& shift) {
  for (glm::vec3& p : g->positions) p = p * scale + shift;
}

/// Share of the hemisphere of `normal`, weighted by cosine, that is open by the bits.
double open_share(const VisibilityBake& bake, std::size_t vertex, const glm::vec3& normal) {
  double open = 0.0;
  double all = 0.0;
  for (int b = 0; b < 256; ++b) {
    const glm::vec3 d = cell_direction(b);
    const double weight = std::pow(std::abs(d.x) + std::abs(d.y) + std::abs(d.z), 3.0) * glm::dot(d, normal);
    if (weight <= 0.0) continue;
    all += weight;
    if (is_open(bake, vertex, b)) open += weight;
  }
  return open / all;
}

/// Reference in double: all triangles, no acceleration. Nearest parameter of a hit with t > t_min, or infinity.
double cast_ray(const FlatGeometry& g, const glm::dvec3& o, const glm::dvec3& d, double* edge_margin) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 2 < g.indices.size(); i += 3) {
    const glm::dvec3 a(g.positions[g.indices[i]]);
    const glm::dvec3 e1 = glm::dvec3(g.positions[g.indices[i + 1]]) - a;
    const glm::dvec3 e2 = glm::dvec3(g.positions[g.indices[i + 2]]) - a;
    const glm::dvec3 p = glm::cross(d, e2);
    const double det = glm::dot(e1, p);
    if (std::abs(det) < 1e-14) continue;
    const double u = glm::dot(o - a, p) / det;
    const glm::dvec3 q = glm::cross(o - a, e1);
    const double v = glm::dot(d, q) / det;
    const double t = glm::dot(e2, q) / det;
    const double inside = std::min({u, v, 1.0 - u - v});
    if (t > -1e-4) *edge_margin = std::min(*edge_margin, std::max(std::abs(inside), t < 0.0 ? -t : 0.0));
    if (inside >= 0.0 && t > 0.0) nearest = std::min(nearest, t);
  }
  return nearest;
}

TEST(VisibilityBake, OpenPlaneSeesTheWholeSkyFromBothSides) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 0.25f, -1.0f}, {0.3f, 0.1f, 2.0f}, {2.0f, 0.2f, 0.0f}, 7);
  const VisibilityBake bake = bake_opaque(g);
  for (std::size_t v = 0; v < bake.vertices.size(); ++v) {
    for (int b = 0; b < 256; ++b) ASSERT_TRUE(is_open(bake, v, b)) << "vertex " << v << " bit " << b;
    EXPECT_EQ(bake.bandwidth[v], 0.0f);
  }
}

TEST(VisibilityBake, InsideOfAClosedBoxSeesNothing) {
  FlatGeometry g;
  add_box(&g, {-0.7f, 0.1f, -2.0f}, {1.1f, 1.3f, 0.4f});
  const VisibilityBake bake = bake_opaque(g);
  for (std::size_t v = 0; v < bake.vertices.size(); ++v) {
    for (int b = 0; b < 256; ++b) {
      // The lift keeps the origin above the face; the inset keeps it off the walls.
      const bool outside = glm::dot(g.normals[v], cell_direction(b)) > 0.0f;
      ASSERT_EQ(is_open(bake, v, b), outside) << "vertex " << v << " bit " << b;
    }
  }
}

TEST(VisibilityBake, ScaleAndPositionDoNotMatter) {
  FlatGeometry g;
  add_box(&g, {-0.5f, 0.0f, -0.5f}, {0.5f, 1.0f, 0.5f});
  add_grid(&g, {-2.0f, 0.0f, -2.0f}, {0.0f, 0.0f, 4.0f}, {4.0f, 0.0f, 0.0f}, 8);
  const VisibilityBake bake = bake_opaque(g);
  for (float scale : {1e-6f, 1e6f}) {
    FlatGeometry scaled = g;
    transform(&scaled, scale, glm::vec3(0.0f));
    const VisibilityBake other = bake_opaque(scaled);
    int different = 0;
    for (std::size_t v = 0; v < bake.vertices.size(); ++v) {
      for (int b = 0; b < 256; ++b) different += is_open(bake, v, b) != is_open(other, v, b) ? 1 : 0;
      EXPECT_NEAR(other.bandwidth[v] * scale, bake.bandwidth[v], 2e-2f * bake.bandwidth[v] + 1e-6f);
    }
    EXPECT_LE(different, static_cast<int>(bake.vertices.size())) << scale;  // rounding at silhouettes only
  }
}

TEST(VisibilityBake, AgreesWithBruteForceInRandomScenes) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  const auto point = [&] { return glm::vec3(uniform(random), uniform(random), uniform(random)); };
  int compared = 0;
  int open = 0;
  for (int scene = 0; scene < 6; ++scene) {
    FlatGeometry g;
    for (int i = 0; i < 30; ++i) add_grid(&g, point(), 0.7f * point(), 0.7f * point());
    const VisibilityBake bake = bake_opaque(g);
    const VisibilityPoints points = build_visibility_points(g, std::vector<bool>(g.items.size(), false), kNever);
    for (std::size_t v = 0; v < g.positions.size(); ++v) {
      const VisibilityPoint& at = points.points[points.point_of_vertex[v]];
      for (int b = 0; b < 256; ++b) {
        const glm::dvec3 d(cell_direction(b));
        const double elevation = glm::dot(glm::dvec3(at.normal), d);
        if (std::abs(elevation) < 0.02) continue;
        const glm::dvec3 local = glm::dvec3(at.position + at.inset) +
                                 glm::dvec3(at.normal) * (elevation > 0.0 ? 1.0 : -1.0) * static_cast<double>(at.lift);
        double margin = 1.0;
        const double t = cast_ray(g, points.center + points.scale_m * local, d, &margin);
        if (margin < 1e-4) continue;  // within rounding of an edge
        ASSERT_EQ(is_open(bake, v, b), std::isinf(t)) << "scene " << scene << " vertex " << v << " bit " << b;
        ++compared;
        open += std::isinf(t) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(compared, 80000);
  EXPECT_GT(open, compared / 5);
  EXPECT_LT(open, compared * 4 / 5);
}

/// An infinite wall of height H at distance D from a point of the floor hides (1 - cos(atan(H / D))) / 2 of the
/// cosine-weighted sky.
TEST(VisibilityBake, WallAtAKnownDistanceHidesItsClosedForm) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {1.0f, 0.0f, 0.0f}, 40);
  const float height = 0.6f;
  add_grid(&g, {0.0f, 0.0f, -1000.0f}, {0.0f, 0.0f, 2000.0f}, {0.0f, height, 0.0f});
  const VisibilityBake bake = bake_opaque(g);
  double square = 0.0;
  int count = 0;
  for (std::size_t v = 0; v < 41 * 41; ++v) {
    const double distance = -static_cast<double>(g.positions[v].x);
    const double hidden = 0.5 * (1.0 - distance / std::hypot(distance, static_cast<double>(height)));
    const double error = open_share(bake, v, {0.0f, 1.0f, 0.0f}) - (1.0 - hidden);
    EXPECT_LT(std::abs(error), 0.06) << distance;  // 256 directions, no finer
    square += error * error;
    ++count;
  }
  EXPECT_LT(std::sqrt(square / count), 0.02);
}

/// Floor vertices exactly at the foot of the wall belong to the side of the wall on which the floor is.
TEST(VisibilityBake, VertexOnAnotherSurfaceTakesItsOwnSide) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {1.0f, 0.0f, 0.0f}, 10);  // x in [-1, 0]
  add_grid(&g, {0.0f, 0.0f, -50.0f}, {0.0f, 0.0f, 100.0f}, {0.0f, 80.0f, 0.0f});   // wall at x = 0
  add_grid(&g, {0.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {1.0f, 0.0f, 0.0f}, 10);   // x in [0, 1]
  const VisibilityBake bake = bake_opaque(g);
  for (std::size_t v = 0; v < g.positions.size(); ++v) {
    if (g.positions[v].x != 0.0f || g.positions[v].y != 0.0f || std::abs(g.positions[v].z) > 1.0f) continue;
    const bool left = v < g.items[0].vertex_count;
    for (int b = 0; b < 256; ++b) {
      const glm::vec3 d = cell_direction(b);
      if (d.y < 0.1f || std::abs(d.x) < 0.1f) continue;
      ASSERT_EQ(is_open(bake, v, b), left == (d.x < 0.0f)) << "vertex " << v << " bit " << b;
    }
  }
}

/// A tall box beside a low one, with touching sides; the top edge of the low one lies on the tall one's side.
TEST(VisibilityBake, TouchingBoxes) {
  FlatGeometry g;
  add_box(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.5f, 1.0f});
  add_box(&g, {0.0f, 0.0f, -100.0f}, {1.0f, 100.0f, 100.0f});
  const VisibilityBake bake = bake_opaque(g);
  const std::size_t top = g.items[3].first_vertex;
  for (std::size_t v = top; v < top + 4; ++v) {
    if (g.positions[v].x != 0.0f) continue;
    EXPECT_NEAR(open_share(bake, v, {0.0f, 1.0f, 0.0f}), 0.5, 0.06);
    for (int b = 0; b < 256; ++b) {
      const glm::vec3 d = cell_direction(b);
      if (d.y > 0.0f && std::abs(d.x) > 0.05f) {
        EXPECT_EQ(is_open(bake, v, b), d.x < 0.0f) << b;
      }
    }
  }
  // The low box's face that touches the tall one is dark.
  const std::size_t side = g.items[1].first_vertex;
  for (std::size_t v = side; v < side + 4; ++v) EXPECT_LT(open_share(bake, v, {1.0f, 0.0f, 0.0f}), 0.05);
}

TEST(VisibilityBake, CoincidentPanelsDoNotHideEachOther) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {2.0f, 0.0f, 0.0f}, 5);  // normal +y
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.0f}, 3);  // normal -y, other vertices
  const VisibilityBake bake = bake_opaque(g);
  for (std::size_t v = 0; v < g.positions.size(); ++v) {
    EXPECT_EQ(open_share(bake, v, {0.0f, 1.0f, 0.0f}), 1.0) << v;
    EXPECT_EQ(open_share(bake, v, {0.0f, -1.0f, 0.0f}), 1.0) << v;
  }
}

/// One sheet as roof over a closed room: lit above, dark below, from the same vertices.
TEST(VisibilityBake, OneSheetHasTwoSides) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 1.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {2.0f, 0.0f, 0.0f}, 8);
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {2.0f, 0.0f, 0.0f});
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {0.0f, 1.0f, 0.0f});
  add_grid(&g, {1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {0.0f, 1.0f, 0.0f});
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f});
  add_grid(&g, {-1.0f, 0.0f, 1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f});
  const VisibilityBake bake = bake_opaque(g);
  for (std::size_t v = 0; v < g.items[0].vertex_count; ++v) {
    EXPECT_EQ(open_share(bake, v, {0.0f, 1.0f, 0.0f}), 1.0) << v;
    EXPECT_EQ(open_share(bake, v, {0.0f, -1.0f, 0.0f}), 0.0) << v;
  }
}

/// Between the vertices of a coarse smooth sphere nothing above the interpolated horizon is dark.
TEST(VisibilityBake, SmoothConvexBodyHasNoDarkHorizon) {
  FlatGeometry g;
  const int n = 16;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= 2 * n; ++i) {
      const double t = std::numbers::pi * j / n;
      const double p = std::numbers::pi * (i % (2 * n)) / n;
      const glm::vec3 d(std::sin(t) * std::cos(p), std::cos(t), std::sin(t) * std::sin(p));
      g.positions.push_back(d);
      g.normals.push_back(d);
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < 2 * n; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (2 * n + 1) + i);
      const auto b = static_cast<std::uint32_t>(a + 2 * n + 1);
      for (std::uint32_t k : {a, a + 1, b, a + 1, b + 1, b}) g.indices.push_back(k);
    }
  }
  DrawItem item;
  item.index_count = static_cast<std::uint32_t>(g.indices.size());
  item.vertex_count = static_cast<std::uint32_t>(g.positions.size());
  g.items.push_back(item);
  const VisibilityBake bake = bake_opaque(g);
  const std::vector<VisibilitySides> sides = visibility_sides(bake.vertices, g.normals);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  double closed = 0.0;
  int tried = 0;
  for (std::size_t i = 0; i < g.indices.size(); i += 3) {
    const std::uint32_t* c = &g.indices[i];
    const glm::vec3 normal = glm::normalize(g.normals[c[0]] + g.normals[c[1]] + g.normals[c[2]]);
    for (int k = 0; k < 20; ++k) {
      const glm::vec3 d = glm::normalize(glm::vec3(uniform(random), uniform(random), uniform(random)) - 0.5f);
      if (glm::dot(d, normal) <= 0.0f) continue;
      const shared::VisibilityCorner around = shared::visibility_corner(d);
      const shared::VisibilityBitPosition address = shared::visibility_bit_position(around.lower);
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t word = sides[c[corner]][0][static_cast<std::size_t>(address.word)];
        closed += shared::visibility_bits(word, address.shift) == glm::vec4(1.0f) ? 0.0 : 1.0;
      }
      tried += 3;
    }
  }
  EXPECT_GT(tried, 20000);
  EXPECT_EQ(closed, 0.0);
}

TEST(VisibilityBake, PanesDimWhatIsBehindThem) {
  FlatGeometry g;
  add_grid(&g, {-0.1f, 0.0f, -0.1f}, {0.0f, 0.0f, 0.2f}, {0.2f, 0.0f, 0.0f}, 2);
  add_grid(&g, {-9.0f, 0.1f, -8.0f}, {0.0f, 0.0f, 18.0f}, {18.0f, 0.0f, 0.0f});
  const auto mean = [&](const Passage& passage) {
    const auto bake = bake_visibility(g, {false, true}, {Passage{}, passage}, kNever);
    EXPECT_EQ(bake->transmittance[4].y, 1.0f);  // no pane below
    EXPECT_EQ(open_share(*bake, 4, {0.0f, 1.0f, 0.0f}), 1.0);
    return static_cast<double>(bake->transmittance[4].x);
  };
  // 2 cos sin T integrated over the angle from the normal.
  const auto expected = [](const Passage& p) {
    double sum = 0.0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double c = (i + 0.5) / kSteps;
      sum += 2.0 * c / kSteps * static_cast<double>(shared::fresnel_pane(static_cast<float>(c), p.ior, p.inside).y);
    }
    return sum * static_cast<double>(p.share);
  };
  EXPECT_EQ(mean({}), 1.0);
  EXPECT_NEAR(mean({0.5f, 1.0f, 1.0f}), 0.5, 1e-6);
  EXPECT_NEAR(mean({0.8f, 1.0f, 0.5f}), 0.4, 1e-6);
  for (const Passage& p : {Passage{1.0f, 1.52f, 1.0f}, Passage{1.0f, 1.52f, 0.7f}, Passage{0.9f, 2.4f, 0.9f}})
    EXPECT_NEAR(mean(p), expected(p), 0.03);  // sixteen directions
}

TEST(VisibilityBake, PanesNeitherOccludeNorMatter) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {2.0f, 0.0f, 0.0f}, 2);
  add_grid(&g, {-9.0f, 0.1f, -9.0f}, {0.0f, 0.0f, 18.0f}, {18.0f, 0.0f, 0.0f});
  const auto through = bake_visibility(g, {false, true}, {}, kNever);
  const auto blocked = bake_visibility(g, {false, false}, {}, kNever);
  ASSERT_TRUE(through && blocked);
  EXPECT_EQ(open_share(*through, 4, {0.0f, 1.0f, 0.0f}), 1.0);
  EXPECT_LT(open_share(*blocked, 4, {0.0f, 1.0f, 0.0f}), 0.02);
  for (std::size_t v = g.items[1].first_vertex; v < g.positions.size(); ++v) {
    EXPECT_EQ(open_share(*through, v, {0.0f, 1.0f, 0.0f}), 1.0);
  }
}

TEST(VisibilityBake, BadGeometryIsLeftOut) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {2.0f, 0.0f, 0.0f}, 2);
  const auto first = static_cast<std::uint32_t>(g.positions.size());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  g.positions.insert(g.positions.end(),
                     {{nan, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 2.0f, 0.0f}, {0.5f, 3.0f, 0.0f}});
  g.normals.insert(g.normals.end(), {{0, 1, 0}, {nan, 0, 0}, {0, 0, 0}, {0, 1, 0}});
  DrawItem item;
  item.first_index = static_cast<std::uint32_t>(g.indices.size());
  for (std::uint32_t k : {0u, 1u, 2u, 1u, 1u, 2u, 1u, 2u, 99u, 1u, 2u, 3u}) g.indices.push_back(first + k);
  item.index_count = 12;
  g.items.push_back(item);
  const VisibilityBake bake = bake_opaque(g);
  ASSERT_EQ(bake.vertices.size(), g.positions.size());
  for (float bandwidth : bake.bandwidth) EXPECT_TRUE(std::isfinite(bandwidth) && bandwidth >= 0.0f);
  EXPECT_EQ(open_share(bake, first, {0.0f, 1.0f, 0.0f}), 1.0);
  FlatGeometry empty;
  EXPECT_TRUE(bake_opaque(empty).vertices.empty());
}

/// Long thin triangles: a floor of needles of 10 m by 10 micrometres must not shadow itself.
TEST(VisibilityBake, NeedlesDoNotShadeThemselves) {
  FlatGeometry g;
  for (int i = 0; i < 200; ++i) {
    const float x = 1e-5f * static_cast<float>(i);
    add_grid(&g, {x, 0.3f * x, -5.0f}, {0.0f, 0.0f, 10.0f}, {1e-5f, 0.3e-5f, 0.0f});
  }
  const VisibilityBake bake = bake_opaque(g);
  for (std::size_t v = 0; v < g.positions.size(); ++v) EXPECT_EQ(open_share(bake, v, g.normals[v]), 1.0) << v;
}

TEST(VisibilityBake, SameAtAnyThreadCount) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {2.0f, 0.0f, 0.0f}, 30);
  add_box(&g, {-0.3f, 0.2f, -0.3f}, {0.4f, 0.6f, 0.5f});
  const VisibilityBake all = bake_opaque(g);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const VisibilityBake single = bake_opaque(g);
  EXPECT_EQ(all.vertices, single.vertices);
  EXPECT_EQ(all.bandwidth, single.bandwidth);
}

TEST(VisibilityBake, ProgressRisesAndCancelStops) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {2.0f, 0.0f, 0.0f}, 100);
  std::atomic<bool> cancel{false};
  double last = 0.0;
  int calls = 0;
  const std::vector<bool> opaque(g.items.size(), false);
  const auto whole = bake_visibility(g, opaque, {}, cancel, [&](double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
    ++calls;
  });
  EXPECT_TRUE(whole.has_value());
  EXPECT_EQ(last, 1.0);
  EXPECT_GT(calls, 20);
  double reached = 0.0;
  const auto stopped = bake_visibility(g, opaque, {}, cancel, [&](double fraction) {
    reached = fraction;
    if (fraction > 0.1) cancel = true;
  });
  EXPECT_FALSE(stopped.has_value());
  EXPECT_LT(reached, 0.9);
  EXPECT_FALSE(bake_visibility(g, opaque, {}, cancel).has_value());
}

}  // namespace
}  // namespace maquette
