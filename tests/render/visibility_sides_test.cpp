#include "render/visibility/visibility_sides.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/math/shared_formulas.h"

namespace maquette {
namespace {

bool is_open(const VisibilityBits& bits, const glm::ivec2& cell) {
  const auto b = static_cast<std::size_t>(cell.y * shared::kVisibilityCells + cell.x);
  return ((bits[b >> 5] >> (b & 31u)) & 1u) != 0;
}

/// The bits as shaders read them.
float value_towards(const VisibilitySides& sides, std::size_t side, const glm::vec3& d) {
  const shared::VisibilityCorner corner = shared::visibility_corner(d);
  const shared::VisibilityBitPosition address = shared::visibility_bit_position(corner.lower);
  const std::uint32_t word = sides[side].at(static_cast<std::size_t>(address.word));
  return glm::dot(shared::visibility_shares(corner.fraction), shared::visibility_bits(word, address.shift));
}

/// Expected content of a side, cell by cell: cells below the horizon repeat, in three rows, the nearest neighbour with
/// a known value.
std::array<bool, 256> obvious_side(const VisibilityBits& bits, const glm::vec3& n) {
  std::array<glm::vec3, 256> direction{};
  std::array<bool, 256> known{}, side{};
  for (int b = 0; b < 256; ++b) {
    const auto i = static_cast<std::size_t>(b);
    direction[i] = shared::visibility_cell_direction({b % 16, b / 16});
    known[i] = glm::dot(n, direction[i]) > 0.0f;
    side[i] = known[i] && is_open(bits, {b % 16, b / 16});
  }
  for (int row = 1; row <= 3; ++row) {
    const std::array<bool, 256> before = known;
    for (int b = 0; b < 256; ++b) {
      const auto i = static_cast<std::size_t>(b);
      if (before[i] || glm::dot(n, direction[i]) < -0.22f * static_cast<float>(row)) continue;
      float nearest = -2.0f;
      for (int k = 0; k < 9; ++k) {
        const glm::ivec2 cell = shared::visibility_wrap({b % 16 + k % 3 - 1, b / 16 + k / 3 - 1});
        const auto j = static_cast<std::size_t>(cell.y * 16 + cell.x);
        if (k == 4 || !before[j] || glm::dot(direction[i], direction[j]) <= nearest) continue;
        nearest = glm::dot(direction[i], direction[j]);
        known[i] = true;
        side[i] = side[j];
      }
    }
  }
  return side;
}

class VisibilitySidesTest : public ::testing::Test {
 protected:
  std::mt19937 random_{3};
  glm::vec3 direction() {
    std::normal_distribution<float> normal;
    return glm::normalize(glm::vec3(normal(random_), normal(random_), normal(random_)));
  }
  VisibilityBits random_bits() {
    VisibilityBits bits;
    for (std::uint32_t& word : bits) word = static_cast<std::uint32_t>(random_());
    return bits;
  }
};

/// Every bit that shaders may read, of random bits and planes, some along the axes.
TEST_F(VisibilitySidesTest, MatchACellByCellConstruction) {
  for (int trial = 0; trial < 3000; ++trial) {
    glm::vec3 n = direction();
    if (trial % 3 == 0) {
      n = glm::vec3(0.0f);
      n[trial % 9 / 3] = trial % 2 ? 1.0f : -1.0f;
    }
    const VisibilityBits bits = random_bits();
    const VisibilitySides sides = visibility_sides({bits}, {n})[0];
    for (const std::size_t side : {0u, 1u}) {
      const std::array<bool, 256> expected = obvious_side(bits, side == 0 ? n : -n);
      for (int y = -1; y < 16; ++y)
        for (int x = -1; x < 16; ++x) {
          const shared::VisibilityBitPosition address = shared::visibility_bit_position({x, y});
          const glm::vec4 found =
              shared::visibility_bits(sides[side].at(static_cast<std::size_t>(address.word)), address.shift);
          for (int k = 0; k < 4; ++k) {
            const glm::ivec2 cell = shared::visibility_wrap({x + (k & 1), y + (k >> 1)});
            ASSERT_EQ(found[k] > 0.5f, expected[static_cast<std::size_t>(cell.y * 16 + cell.x)])
                << trial << " " << side << " " << x << " " << y << " " << k;
          }
        }
    }
  }
}

/// Far above the horizon both sides read the map itself, including folds and corners.
TEST_F(VisibilitySidesTest, AboveTheHorizonIsTheMap) {
  for (int trial = 0; trial < 20000; ++trial) {
    glm::vec3 d = direction();
    if (trial % 4 == 0) d = glm::normalize(glm::vec3(0.1f * d.x, -1.0f, 0.1f * d.z));     // the corners
    if (trial % 4 == 1) d = glm::normalize(glm::vec3(d.x, -std::abs(d.y), 0.01f * d.z));  // the fold
    const VisibilityBits bits = random_bits();
    const shared::VisibilityCorner corner = shared::visibility_corner(d);
    float value = 0.0f;
    for (int k = 0; k < 4; ++k)
      value += is_open(bits, shared::visibility_wrap(corner.lower + glm::ivec2(k & 1, k >> 1)))
                   ? shared::visibility_shares(corner.fraction)[k]
                   : 0.0f;
    const std::vector<VisibilitySides> sides = visibility_sides({bits, bits}, {d, -d});
    ASSERT_NEAR(value_towards(sides[0], 0, d), value, 1e-6) << trial;
    ASSERT_NEAR(value_towards(sides[1], 1, d), value, 1e-6) << trial;
  }
}

/// Lookups in upward directions do not read the other side, also for a plane that leans by 0.2 rad.
TEST_F(VisibilitySidesTest, TheOtherSideIsNotSeen) {
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  int near_horizon = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const glm::vec3 n = direction();
    VisibilityBits bits{}, other;
    for (int b = 0; b < 256; ++b) {
      const glm::vec3 cell = shared::visibility_cell_direction({b % 16, b / 16});
      if (glm::dot(cell, n) > 0.0f) bits[static_cast<std::size_t>(b >> 5)] |= 1u << (b & 31);
    }
    for (std::size_t w = 0; w < other.size(); ++w) other[w] = ~bits[w];
    const std::vector<VisibilitySides> sides = visibility_sides({bits, other}, {n, n});
    glm::vec3 d = direction();
    d = glm::normalize(d - n * glm::dot(n, d));
    const float elevation = trial % 2 ? 0.5f * uniform(random_) : -0.2f * uniform(random_);
    d = std::cos(elevation) * d + std::sin(elevation) * n;
    near_horizon += std::abs(elevation) < 0.2f ? 1 : 0;
    ASSERT_NEAR(value_towards(sides[0], 0, d), 1.0f, 1e-6) << elevation;
    ASSERT_NEAR(value_towards(sides[1], 0, d), 0.0f, 1e-6) << elevation;
    ASSERT_NEAR(value_towards(sides[0], 1, -d), 0.0f, 1e-6) << elevation;
    ASSERT_NEAR(value_towards(sides[1], 1, -d), 1.0f, 1e-6) << elevation;
  }
  EXPECT_GT(near_horizon, 5000);
}

/// On a floor whose horizon passes through the centres of cells, and on one that leans a little: half of the sky above
/// is open, and the same half below, up to their edges.
TEST_F(VisibilitySidesTest, AFloorsHorizonKeepsItsPosition) {
  for (const glm::vec3& n : {glm::vec3(0, 1, 0), glm::vec3(0, -1, 0), glm::normalize(glm::vec3(0.02f, 1.0f, -0.01f))}) {
    VisibilityBits bits{};
    for (int b = 0; b < 256; ++b) {
      const glm::vec3 cell = shared::visibility_cell_direction({b % 16, b / 16});
      if (glm::dot(cell, n) > 0.0f && cell.x > 0.0f) bits[static_cast<std::size_t>(b >> 5)] |= 1u << (b & 31);
    }
    const VisibilitySides sides = visibility_sides({bits}, {n})[0];
    for (int i = 0; i < 64; ++i) {
      const float azimuth = (static_cast<float>(i) + 0.5f) * 6.2831853f / 64.0f;
      if (std::abs(std::cos(azimuth)) < 0.5f) continue;  // close to an edge of the open part
      for (const float elevation : {0.05f, 0.0f, -0.05f, -0.1f}) {
        const glm::vec3 d(std::cos(azimuth), elevation * n.y, std::sin(azimuth));
        EXPECT_NEAR(value_towards(sides, 0, glm::normalize(d)), std::cos(azimuth) > 0.0f ? 1.0f : 0.0f, 1e-6)
            << n.x << " " << azimuth << " " << elevation;
      }
    }
  }
}

/// Below the horizon the cells repeat the visibility close above it.
TEST_F(VisibilitySidesTest, TheHorizonContinuesBelow) {
  int tried = 0, wrong = 0;  // neighbours are far apart at the map's corners
  for (int trial = 0; trial < 2000; ++trial) {
    const glm::vec3 n = direction(), towards = direction();
    VisibilityBits bits{};
    for (int b = 0; b < 256; ++b) {
      const glm::vec3 cell = shared::visibility_cell_direction({b % 16, b / 16});
      if (glm::dot(cell, n) > 0.0f && glm::dot(cell, towards) > 0.0f)
        bits[static_cast<std::size_t>(b >> 5)] |= 1u << (b & 31);
    }
    const VisibilitySides sides = visibility_sides({bits}, {n})[0];
    glm::vec3 d = direction();
    d = glm::normalize(d - n * glm::dot(n, d));
    if (std::abs(glm::dot(d, towards)) < 0.7f) continue;  // close to an edge of the open part
    d = std::cos(0.15f) * d - std::sin(0.15f) * n;
    wrong += std::abs(value_towards(sides, 0, d) - (glm::dot(d, towards) > 0.0f ? 1.0f : 0.0f)) > 0.1f ? 1 : 0;
    ++tried;
  }
  EXPECT_GT(tried, 400);
  EXPECT_LT(wrong, tried / 50);
}

/// The value varies linearly with the direction: interpolation of the cell centres reproduces it, also across folds.
TEST_F(VisibilitySidesTest, SharesAreBilinearAcrossTheFold) {
  double worst = 0.0;
  for (int trial = 0; trial < 4000; ++trial) {
    glm::vec3 d = direction();
    if (trial % 4 == 1) d = glm::normalize(glm::vec3(d.x, -0.5f, 0.01f * d.z));  // on the fold
    const shared::VisibilityCorner corner = shared::visibility_corner(d);
    glm::dvec3 mean(0.0);
    for (int k = 0; k < 4; ++k) {
      const glm::ivec2 cell = shared::visibility_wrap(corner.lower + glm::ivec2(k & 1, k >> 1));
      ASSERT_TRUE(cell.x >= 0 && cell.x < 16 && cell.y >= 0 && cell.y < 16);
      const glm::dvec3 c(shared::visibility_cell_direction(cell));
      mean += c / (std::abs(c.x) + std::abs(c.y) + std::abs(c.z)) *
              static_cast<double>(shared::visibility_shares(corner.fraction)[k]);
    }
    worst = std::max(worst, std::acos(std::min(1.0, glm::dot(glm::normalize(mean), glm::dvec3(d)))));
  }
  EXPECT_LT(worst, 0.09);
}

TEST_F(VisibilitySidesTest, InterpolationReproducesCellCentres) {
  for (int b = 0; b < 256; ++b)
    EXPECT_EQ(shared::visibility_bit(shared::visibility_cell_direction({b % 16, b / 16})), b);
}

}  // namespace
}  // namespace maquette
