// Lights chosen by the illuminance that they may cause: exact probabilities, no light left out, no outliers.
#include "render/lights/light_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace maquette {
namespace {

/// With probabilities by power, as build_light_list makes them.
LightList list_of(std::vector<LightRecord> lights, const std::vector<double>& powers) {
  const std::vector<float> cdf = cumulative_in_steps(powers);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    lights[i].selection_pdf = cdf[i] - (i > 0 ? cdf[i - 1] : 0.0f);
    lights[i].cdf = cdf[i];
  }
  LightList list;
  list.lights = std::move(lights);
  list.diagonal_m = 5.0;
  return list;
}

LightRecord point_at(const glm::vec3& position, float candela) {
  LightRecord light{};
  light.kind = shared::kLightPoint;
  light.position = position;
  light.color = glm::vec3(candela);
  return light;
}

LightRecord sun() {
  LightRecord light{};
  light.kind = shared::kLightDirectional;
  light.direction = {0.0f, -1.0f, 0.0f};
  light.color = glm::vec3(100.0f);
  return light;
}

/// A glowing strip of 2,000 small triangles along x from 0 to 2 m, and a lamp of 5,000 times its power 3 m away.
LightList strip_and_lamp() {
  std::vector<LightRecord> lights{point_at({0.0f, 0.0f, 3.0f}, 1000.0f)};
  std::vector<double> powers{4.0 * 3.14159 * 1000.0};
  for (int i = 0; i < 2000; ++i) {
    LightRecord light{};
    light.kind = shared::kLightTriangle;
    light.position = {0.001f * static_cast<float>(i), 0.0f, 0.0f};
    light.direction = {0.001f, 0.0f, 0.0f};
    light.edge2 = {0.0f, 0.0f, 0.004f};
    light.range_m = 1.0f;
    light.color = glm::vec3(100.0f);
    lights.push_back(light);
    powers.push_back(2.0 * 3.14159 * 100.0 * 0.5 * 0.001 * 0.004);
  }
  return list_of(lights, powers);
}

/// Bound of a light's illuminance at a point, without the cosine at the point.
double flux_at(const LightRecord& light, const glm::dvec3& p) {
  if (light.kind == shared::kLightDirectional) return static_cast<double>(light.color.y);
  const glm::dvec3 to = glm::dvec3(light.position) - p;
  const double area = light.kind == shared::kLightTriangle
                          ? 0.5 * glm::length(glm::cross(glm::dvec3(light.direction), glm::dvec3(light.edge2)))
                          : 1.0;
  return static_cast<double>(light.color.y) * area / std::max(glm::dot(to, to), 1e-8);
}

void check_rows(const LightList& list) {
  const LightGrid grid = build_light_grid(list);
  ASSERT_EQ(grid.lights.size(), list.lights.size());
  ASSERT_EQ(grid.stride % 4, 0);
  ASSERT_LE(grid.stride, LightGrid::kMaxNodes);
  std::vector<int> seen = grid.order;
  std::sort(seen.begin(), seen.end());
  for (std::size_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen[i], static_cast<int>(i));
  const auto whole = [](float v) {
    const double steps = static_cast<double>(v) * 0x1p24;
    return steps == std::floor(steps);
  };
  const auto rows = static_cast<std::size_t>(grid.cells.x) * static_cast<std::size_t>(grid.cells.y) *
                    static_cast<std::size_t>(grid.cells.z);
  ASSERT_EQ(grid.cumulative.size(), rows * static_cast<std::size_t>(grid.stride));
  ASSERT_EQ(grid.cut.size(), grid.cumulative.size());
  ASSERT_EQ(grid.lux.size(), rows);
  std::vector<int> times(grid.lights.size());
  for (std::size_t row = 0; row < rows; ++row) {
    float before = 0.0f;
    std::fill(times.begin(), times.end(), 0);
    for (int k = 0; k < grid.stride; ++k) {
      const std::size_t at = row * static_cast<std::size_t>(grid.stride) + static_cast<std::size_t>(k);
      // Whole steps: a number of 24 bits is below the entry exactly as often as the difference says.
      ASSERT_TRUE(whole(grid.cumulative[at]));
      if (before < 1.0f) {
        ASSERT_GT(grid.cumulative[at], before) << row << " " << k;
        const LightNode& node = grid.nodes[grid.cut[at]];
        for (int i = 0; i < node.count; ++i) ++times[static_cast<std::size_t>(node.first + i)];
      } else {
        ASSERT_EQ(grid.cumulative[at], 1.0f);
      }
      before = grid.cumulative[at];
    }
    ASSERT_EQ(before, 1.0f);
    ASSERT_EQ(std::count(times.begin(), times.end(), 1), static_cast<std::ptrdiff_t>(times.size()))
        << "a cut holds each light once";
  }
  float before = 0.0f;
  for (const LightRecord& light : grid.lights) {
    ASSERT_TRUE(whole(light.cdf));
    ASSERT_EQ(light.cdf - before, light.selection_pdf);
    before = light.cdf;
  }
  ASSERT_EQ(before, 1.0f);
  for (const LightNode& node : grid.nodes) {
    const auto first = static_cast<std::size_t>(node.first);
    ASSERT_EQ(node.before, first > 0 ? grid.lights[first - 1].cdf : 0.0f);
    ASSERT_EQ(node.before + node.share, grid.lights[first + static_cast<std::size_t>(node.count) - 1].cdf);
    ASSERT_GT(node.share, 0.0f);
  }
  for (const std::size_t cell : {std::size_t{0}, rows / 2, rows - 1}) {
    double sum = 0.0;
    for (std::size_t i = 0; i < grid.lights.size(); ++i) {
      const double p = static_cast<double>(light_probability(grid, cell, i));
      const double by_power = list.lights[static_cast<std::size_t>(grid.order[i])].selection_pdf;
      // Single steps of 2^-24 are rounded; larger probabilities keep their quarter by power.
      if (by_power > 1e-5) {
        EXPECT_GT(p, 0.24 * by_power) << i;
      }
      sum += p;
    }
    EXPECT_NEAR(sum, 1.0, 1e-5);
  }
}

TEST(LightGrid, ProbabilitiesMatchTheTables) {
  check_rows(strip_and_lamp());
  check_rows(list_of({point_at({1, 2, 3}, 5.0f)}, {1.0}));
  check_rows(list_of({sun()}, {1.0}));
  check_rows(list_of({sun(), sun(), point_at({0, 0, 0}, 1.0f)}, {1e9, 1.0, 1e-9}));
  // All at one point, far away, tiny and huge scenes.
  check_rows(list_of({point_at({1, 1, 1}, 1.0f), point_at({1, 1, 1}, 2.0f)}, {1.0, 2.0}));
  check_rows(list_of({point_at({1e6f, 0, 0}, 1.0f), point_at({1e6f, 1, 0}, 2.0f)}, {1.0, 2.0}));
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (const float scale : {1e-6f, 1.0f, 1e6f}) {
    std::vector<LightRecord> lights;
    std::vector<double> powers;
    for (int i = 0; i < 500; ++i) {
      lights.push_back(i % 50 == 0 ? sun()
                                   : point_at(scale * glm::vec3(unit(random), unit(random), unit(random)), 1.0f));
      powers.push_back(std::pow(10.0, 8.0 * static_cast<double>(unit(random)) - 4.0));
    }
    check_rows(list_of(lights, powers));
  }
}

// In every cell, with few lights among many: lights are drawn with the stated probability, down to the one of least
// power.
TEST(LightGrid, DrawsFollowTheProbabilities) {
  std::mt19937 random(31);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::vector<LightRecord> lights{sun()};
  std::vector<double> powers{5.0};
  for (int i = 0; i < 150; ++i) {
    lights.push_back(point_at({unit(random), unit(random), unit(random)}, 1.0f));
    powers.push_back(std::pow(10.0, 3.0 * static_cast<double>(unit(random)) - 3.0));
  }
  const LightGrid grid = build_light_grid(list_of(lights, powers));
  for (int trial = 0; trial < 8; ++trial) {
    const std::size_t cell = light_cell(grid, 1.5f * glm::vec3(unit(random), unit(random), unit(random)) - 0.25f);
    constexpr int kDraws = 1 << 18;
    std::vector<int> times(lights.size());
    for (int i = 0; i < kDraws; ++i) {
      // Stratified in the number that chooses the node.
      const float u = (static_cast<float>(i) + unit(random)) / static_cast<float>(kDraws);
      const LightPick pick = choose_light(grid, cell, u, static_cast<std::uint32_t>(random()));
      ASSERT_LT(pick.index, lights.size());
      ASSERT_EQ(pick.probability, light_probability(grid, cell, pick.index)) << pick.index;
      ++times[pick.index];
    }
    double chi_square = 0.0;
    int classes = 0;
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const double expected = kDraws * static_cast<double>(light_probability(grid, cell, i));
      if (expected < 8.0) continue;
      chi_square += (times[i] - expected) * (times[i] - expected) / expected;
      ++classes;
    }
    ASSERT_GT(classes, 50);
    EXPECT_LT(chi_square, classes + 4.0 * std::sqrt(2.0 * classes)) << trial;
  }
  const glm::vec3 nowhere(std::nanf(""), 1e30f, -1e30f);
  EXPECT_LT(light_cell(grid, nowhere), grid.lux.size());
}

TEST(LightGrid, NearLightsMakeNoOutliers) {
  // Second moment of one sample over the squared true value: 1 would be a perfect choice, and its root is how far a
  // single sample may stand out. By power alone it is thousands beside the strip.
  const LightList list = strip_and_lamp();
  const LightGrid grid = build_light_grid(list);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  double worst = 0.0, worst_by_power = 0.0, worst_far = 0.0;
  for (int trial = 0; trial < 200; ++trial) {
    const bool far = trial % 4 == 0;
    const glm::vec3 p =
        far ? glm::vec3(8.0f * unit(random) - 4.0f, 1.0f + 3.0f * unit(random), 9.0f * unit(random) - 4.0f)
            : glm::vec3(2.0f * unit(random), 0.01f + 0.02f * unit(random), 0.02f * unit(random));
    double truth = 0.0, square = 0.0, square_by_power = 0.0;
    for (std::size_t i = 0; i < grid.lights.size(); ++i) {
      const double flux = flux_at(grid.lights[i], glm::dvec3(p));
      truth += flux;
      square += flux * flux / static_cast<double>(light_probability(grid, light_cell(grid, p), i));
      square_by_power += flux * flux / list.lights[static_cast<std::size_t>(grid.order[i])].selection_pdf;
    }
    if (far) worst_far = std::max(worst_far, square / (truth * truth));
    if (!far) worst = std::max(worst, square / (truth * truth));
    if (!far) worst_by_power = std::max(worst_by_power, square_by_power / (truth * truth));
  }
  RecordProperty("near", std::to_string(worst));
  RecordProperty("far", std::to_string(worst_far));
  RecordProperty("by power", std::to_string(worst_by_power));
  EXPECT_LT(worst, 30.0);
  EXPECT_LT(worst_far, 8.0);
  EXPECT_GT(worst_by_power, 300.0);
}

LightRecord triangle_at(const glm::vec3& position, const glm::vec3& edge1, const glm::vec3& edge2, float radiance) {
  LightRecord light{};
  light.kind = shared::kLightTriangle;
  light.position = position;
  light.direction = edge1;
  light.edge2 = edge2;
  light.color = glm::vec3(radiance);
  return light;
}

/// Luminous flux on the emitting side.
double power_of(const LightRecord& light) {
  return 1.5707963 * static_cast<double>(light.color.y) *
         glm::length(glm::cross(glm::dvec3(light.direction), glm::dvec3(light.edge2)));
}

/// Illuminance by a one-sided triangle at a point, without the cosine there; 0 from behind.
double lux_at(const LightRecord& light, const glm::dvec3& p) {
  const glm::dvec3 a(light.direction), b(light.edge2), to = p - glm::dvec3(light.position) - (a + b) / 3.0;
  const double facing = 0.5 * glm::dot(glm::cross(a, b), to) / glm::length(to);
  return facing > 0.0 ? static_cast<double>(light.color.y) * facing / glm::dot(to, to) : 0.0;
}

// Headlamps in front of a cabin do not light what its display lights.
TEST(LightGrid, LightsThatFaceAwayAreHardlyDrawn) {
  std::vector<LightRecord> lights;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 300; ++i)
    lights.push_back(triangle_at({unit(random), 0.1f * unit(random), 2.0f}, {0.02f, 0, 0}, {0, 0.02f, 0}, 20000.0f));
  for (int i = 0; i < 40; ++i)
    lights.push_back(triangle_at({0.01f * static_cast<float>(i), 0.2f, 0.5f}, {0, 0.02f, 0}, {0.01f, 0, 0}, 200.0f));
  std::vector<double> powers;
  for (const LightRecord& light : lights) powers.push_back(power_of(light));
  const LightGrid grid = build_light_grid(list_of(lights, powers));
  for (int trial = 0; trial < 100; ++trial) {
    const glm::vec3 p(unit(random), 0.4f * unit(random), 0.3f * unit(random));
    double display = 0.0;
    for (std::size_t i = 0; i < lights.size(); ++i)
      if (grid.order[i] >= 300) display += static_cast<double>(light_probability(grid, light_cell(grid, p), i));
    EXPECT_GT(display, 0.99) << p.x << " " << p.y << " " << p.z;
  }
}

// At all points, near and far and beyond the inner cells: no light that reaches a point is much rarer than by power,
// and the lux of the cell is close to the true value.
TEST(LightGrid, LightsThatReachAPointAreDrawn) {
  std::mt19937 random(23);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const auto vector = [&] { return 2.0f * glm::vec3(unit(random), unit(random), unit(random)) - 1.0f; };
  for (const float scale : {1e-6f, 1.0f, 1e6f}) {
    std::vector<LightRecord> lights;
    std::vector<double> powers;
    for (int i = 0; i < 400; ++i) {
      const float side = scale * std::pow(10.0f, -1.0f - 3.0f * unit(random));
      lights.push_back(
          triangle_at(scale * vector(), side * vector(), side * vector(), std::pow(10.0f, 4.0f * unit(random))));
      powers.push_back(power_of(lights.back()));
    }
    const LightList list = list_of(lights, powers);
    const LightGrid grid = build_light_grid(list);
    double least = 1.0;
    std::vector<double> said;
    for (int trial = 0; trial < 300; ++trial) {
      const bool outside = trial % 3 == 0;
      const glm::vec3 p = (outside ? 4.0f : 1.0f) * scale * vector();
      const std::size_t cell = light_cell(grid, p);
      double sum = 0.0;
      for (std::size_t i = 0; i < grid.lights.size(); ++i) {
        const double lux = lux_at(grid.lights[i], glm::dvec3(p));
        if (!(lux > 0.0)) continue;
        sum += lux;
        const double by_power = list.lights[static_cast<std::size_t>(grid.order[i])].selection_pdf;
        if (by_power > 1e-4) least = std::min(least, static_cast<double>(light_probability(grid, cell, i)) / by_power);
      }
      if (outside) continue;
      said.push_back(static_cast<double>(grid.lux[cell]) / sum);
    }
    EXPECT_GT(least, 0.24) << scale;
    std::sort(said.begin(), said.end());
    EXPECT_GT(said[said.size() / 20], 0.5) << scale;
    EXPECT_LT(said[said.size() * 19 / 20], 4.0) << scale;
  }
}

// A light that is seen at a grazing angle from points near it may shine straight at a point far outside the grid.
TEST(LightGrid, OuterLayerIsUnbounded) {
  std::vector<LightRecord> lights;
  std::vector<double> powers;
  for (int i = 0; i < 64; ++i) {
    lights.push_back(
        triangle_at({0.0f, static_cast<float>(i) / 64.0f, 0.0f}, {0.0f, 0.0f, 0.01f}, {0.008f, 0.006f, 0.0f}, 100.0f));
    powers.push_back(power_of(lights.back()));
  }
  const LightList list = list_of(lights, powers);
  const LightGrid grid = build_light_grid(list);
  for (const glm::vec3& p :
       {glm::vec3(-10, -3, 0), glm::vec3(-10, -3, 2), glm::vec3(-300, -90, 10), glm::vec3(-2, 40, 3)}) {
    double truth = 0.0, square = 0.0;
    for (std::size_t i = 0; i < grid.lights.size(); ++i) {
      const double lux = lux_at(grid.lights[i], glm::dvec3(p));
      truth += lux;
      square += lux * lux / static_cast<double>(light_probability(grid, light_cell(grid, p), i));
    }
    ASSERT_GT(truth, 0.0);
    EXPECT_LT(square, 8.0 * truth * truth) << p.x;
  }
}

}  // namespace
}  // namespace maquette
