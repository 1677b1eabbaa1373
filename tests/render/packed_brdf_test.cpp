#include "render/reference/packed_brdf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace maquette {
namespace {

double largest(const glm::dvec3& c) { return std::max({c.x, c.y, c.z}); }

glm::dvec3 entry(const BrdfTable& table, int theta_h, int theta_d, int phi_d) {
  return table.rgb[static_cast<std::size_t>(shared::merl_index(theta_h, theta_d, phi_d))];
}

/// The table itself in double, and the sum of the allowed errors of its entries.
struct Exact {
  glm::dvec3 value{0.0};
  double bound = 0.0;
};

Exact interpolate(const BrdfTable& table, const shared::MerlCell& cell) {
  Exact exact;
  for (int corner = 0; corner < 8; ++corner) {
    const bool h = (corner & 4) != 0, d = (corner & 2) != 0, phi = (corner & 1) != 0;
    const glm::dvec3 f(cell.fraction);
    const double weight = (h ? f.x : 1.0 - f.x) * (d ? f.y : 1.0 - f.y) * (phi ? f.z : 1.0 - f.z);
    const glm::dvec3 value = entry(table, h ? cell.upper.x : cell.lower.x, d ? cell.upper.y : cell.lower.y,
                                   phi ? cell.upper.z : cell.lower.z);
    exact.value += weight * value;
    exact.bound += weight * largest(value) * 0x1p-16;
  }
  return exact;
}

BrdfTable empty_table() {
  BrdfTable table;
  table.rgb.assign(kBrdfEntryCount, glm::vec3(0.0f));
  return table;
}

shared::MerlCell random_cell(std::mt19937* random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  return shared::merl_cell({unit(*random) * 90.0f - 0.5f, unit(*random) * 90.0f - 0.5f, unit(*random) * 180.0f - 0.5f});
}

TEST(PackedBrdf, EveryEntryIsWhereInterpolationReadsIt) {
  BrdfTable table = empty_table();
  // Whole numbers below 65,536 are kept as they are.
  for (std::size_t i = 0; i < table.rgb.size(); ++i) table.rgb[i] = glm::vec3(i % 65521 + 1, i % 499, i % 32749);
  const PackedBrdf packed(table);
  for (int h = 0; h < kThetaHCount; ++h)
    for (int d = 0; d < kThetaDCount; ++d)
      for (int phi = 0; phi < kPhiDCount; ++phi) {
        const shared::MerlCell cell = shared::merl_cell(glm::vec3(h, d, phi));
        const glm::vec3 value = packed.look_up(PackedBrdf::cell_of(cell));
        ASSERT_EQ(glm::dvec3(value), entry(table, h, d, phi)) << h << " " << d << " " << phi;
      }
}

/// Neighbouring values of fifteen orders of magnitude, single channels, zeros.
TEST(PackedBrdf, ErrsByTheRoundingOfItsEntriesAlone) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (const float most : {1e-12f, 3.0f, 1e20f, 3e38f}) {
    BrdfTable table = empty_table();
    for (glm::vec3& f : table.rgb) {
      const float scale = most * std::pow(10.0f, -8.0f * unit(random));
      f = scale * glm::vec3(unit(random), unit(random) * unit(random), unit(random) < 0.2f ? 0.0f : unit(random));
      if (unit(random) < 0.05f) f = glm::vec3(0.0f);
    }
    const PackedBrdf packed(table);
    for (int i = 0; i < 200000; ++i) {
      const shared::MerlCell cell = random_cell(&random);
      const Exact exact = interpolate(table, cell);
      const glm::dvec3 error = glm::abs(glm::dvec3(packed.look_up(PackedBrdf::cell_of(cell))) - exact.value);
      // The rounding of eight floats in addition to that of the entries.
      ASSERT_LE(largest(error), exact.bound * (1.0 + 1e-1)) << most;
    }
  }
}

TEST(PackedBrdf, RoundingDoesNotShiftTheMean) {
  for (const char* name : {"metal-chrome", "paint-red-metallic", "plastic-matte-black"}) {
    const BrdfTable table = make_builtin_brdf(name);
    const PackedBrdf packed(table);
    double most = 0.0;
    for (const glm::vec3& f : table.rgb) most = std::max(most, largest(f));
    std::mt19937 random(2);
    glm::dvec3 sum(0.0), exact_sum(0.0), square(0.0);
    for (int i = 0; i < 200000; ++i) {
      const shared::MerlCell cell = random_cell(&random);
      const glm::dvec3 exact = interpolate(table, cell).value;
      const double scale = std::max(largest(exact), most * 0x1p-31);
      const glm::dvec3 error = (glm::dvec3(packed.look_up(PackedBrdf::cell_of(cell))) - exact) / scale;
      sum += error;
      exact_sum += exact / scale;
      square += error * error;
    }
    EXPECT_LE(largest(glm::abs(sum)) / largest(exact_sum), 1e-6) << name;
    // Even the rounding errors of the shortest mantissa.
    EXPECT_LE(std::sqrt(largest(square) / 200000.0), 1.0 / (32768.0 * std::sqrt(12.0))) << name;
  }
}

/// The largest float, values that round up to the next exponent, and values below the normal floats.
TEST(PackedBrdf, EndsOfTheRange) {
  BrdfTable table = empty_table();
  const std::array<float, 6> ends{3.4028235e38f, 0x1.fffffep100f, 0x1.fffffep-1f, 0x1p-126f, 0x1p-140f, 0x1p-149f};
  for (std::size_t i = 0; i < ends.size(); ++i)
    table.rgb[static_cast<std::size_t>(shared::merl_index(static_cast<int>(10 * i), 5, 7))] = glm::vec3(ends[i]);
  const PackedBrdf packed(table);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const float value = packed.look_up(PackedBrdf::cell_of(shared::merl_cell(glm::vec3(10 * i, 5, 7)))).x;
    EXPECT_TRUE(std::isfinite(value)) << i;
    EXPECT_NEAR(value, ends[i], static_cast<double>(ends[i]) * 0x1p-16 + 0x1p-127) << i;
  }
}

TEST(PackedBrdf, BlackStaysBlack) {
  const PackedBrdf packed(empty_table());
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(packed.look_up(PackedBrdf::cell_of(random_cell(&random))), glm::vec3(0.0f));
}

}  // namespace
}  // namespace maquette
