// The weights of interpolated values (shaders/shared/interpolation.glsl), against simulated points with known errors.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/math/shared_formulas.h"

namespace maquette {
namespace {

/// Squared errors over many pools of points, in units of the variance of one item.
struct Errors {
  double own = 0.0, interpolated = 0.0, both = 0.0, best = 0.0;
};

/// Pools of `count` points with `items` items each, whose interpolated values are off by `bias` (in standard deviations
/// of one item), in a picture whose typical kappa is `typical`. The variance of an item is estimated only from the
/// items.
Errors simulate(int count, int items, double bias, float typical, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Errors e;
  constexpr int kPools = 1000;
  const double fall = shared::noise_fall(static_cast<float>(items));
  for (int pool = 0; pool < kPools; ++pool) {
    std::vector<double> own(static_cast<std::size_t>(count)), other = own;
    glm::vec4 sums(0.0f);
    for (std::size_t i = 0; i < own.size(); ++i) {
      own[i] = std::sqrt(fall) * normal(random);  // the true value is 0
      other[i] = bias * normal(random);
      double variance = 0.0;
      for (int k = 1; k < items; ++k) variance += std::pow(normal(random), 2.0) / (items - 1);
      sums += glm::vec4(std::pow(own[i] - other[i], 2.0), variance * fall, variance, 1.0);
    }
    const double w = shared::own_weight(static_cast<float>(items), shared::pooled_kappa(sums, typical));
    const double ideal = bias * bias / (bias * bias + fall);
    for (std::size_t i = 0; i < own.size(); ++i) {
      e.own += own[i] * own[i];
      e.interpolated += other[i] * other[i];
      e.both += std::pow(w * own[i] + (1.0 - w) * other[i], 2.0);
      e.best += std::pow(ideal * own[i] + (1.0 - ideal) * other[i], 2.0);
    }
  }
  return e;
}

TEST(InterpolationWeights, MixIsHardlyWorseThanOwnMeansWhereInterpolationIsWrong) {
  for (const int count : {3, 6, 40})
    for (const int items : {3, 8, 30})
      for (const double bias : {0.0, 0.03, 0.2, 1.0, 10.0}) {
        const Errors e = simulate(count, items, bias, 0.0f, static_cast<std::uint32_t>(count + 100 * items));
        EXPECT_LT(e.both, (count == 3 ? 1.15 : 1.05) * e.own)
            << count << " points of " << items << " items, bias " << bias;
        if (count == 40) {
          EXPECT_LT(e.both, 1.15 * e.best + 0.05 * e.own) << items << " items, bias " << bias;
        }
      }
}

TEST(InterpolationWeights, FewPointsAreNearTheBestWeightsWhereInterpolationIsRight) {
  for (const int count : {1, 3, 6})
    for (const int items : {3, 8, 30})
      for (const double bias : {0.0, 0.03, 0.2, 1.0}) {
        const Errors e = simulate(count, items, bias, static_cast<float>(bias * bias),
                                  static_cast<std::uint32_t>(count + 100 * items));
        EXPECT_LT(e.both, 1.1 * e.best + (count == 1   ? 0.26
                                          : count == 3 ? 0.15
                                                       : 0.1) *
                                             e.own)
            << count << " points of " << items << " items, bias " << bias;
        EXPECT_LT(e.both, 1.02 * e.own);
      }
}

/// Two items that contain lamps differ as much as any two random numbers: the error of their mean is not an error of
/// interpolation.
TEST(InterpolationWeights, NoiseOfTwoItemsIsNotCountedAsInterpolationError) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  glm::vec4 sums(0.0f);
  for (int i = 0; i < 20000; ++i) {
    const float a = normal(random), b = normal(random), own = 0.5f * (a + b), variance = 0.5f * (a - b) * (a - b);
    sums += glm::vec4(own * own, variance * shared::noise_fall(2.0f), variance, 1.0f);  // interpolation is exact
  }
  EXPECT_LT(shared::own_weight(2.0f, shared::pooled_kappa(sums, 0.0f)), 0.03f);
}

TEST(InterpolationWeights, EarlyNoiseJoinsTheLateOne) {
  EXPECT_FLOAT_EQ(shared::noise_fall(1.0f), 1.0f);
  EXPECT_FLOAT_EQ(shared::noise_fall(2.0f), 0.5f);
  EXPECT_FLOAT_EQ(shared::noise_fall(25.0f), 1.0f / 125.0f);
  float before = shared::noise_fall(0.5f);
  for (float n = 0.51f; n < 40.0f; n += 0.01f) {
    const float now = shared::noise_fall(n);
    EXPECT_LT(now, before);
    EXPECT_GT(now, 0.93f * before) << n;
    EXPECT_NEAR(shared::interpolation_items(now), n, 1e-4f * n);
    before = now;
  }
}

TEST(InterpolationWeights, UsesTheGivenKappaWhereNothingWasMeasured) {
  for (const float kappa : {0.0f, 0.3f, shared::kNeverInterpolate})
    EXPECT_EQ(shared::pooled_kappa(glm::vec4(0.0f), kappa), kappa);
  EXPECT_EQ(shared::own_weight(2.0f, 0.0f), 0.0f);
  EXPECT_EQ(shared::own_weight(2.0f, shared::kNeverInterpolate), 1.0f);
}

TEST(InterpolationWeights, OutliersKeepTheirOwnMeans) {
  // In the neighbourhood, interpolation is wrong by a fifth of an item's standard deviation.
  constexpr float kKappa = 0.04f;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const float items : {1.0f, 4.0f, 30.0f}) {
    const double fall = shared::noise_fall(items);
    for (const double bias : {0.2, 20.0, 200.0}) {
      double own_error = 0.0, plain_error = 0.0, error = 0.0;
      for (int k = 0; k < 10000; ++k) {
        const double own = std::sqrt(fall) * normal(random), other = bias == 0.2 ? bias * normal(random) : bias;
        const auto squared = static_cast<float>((own - other) * (own - other));
        const auto mixed = [&](float kappa) {
          const double w = shared::own_weight(items, kappa);
          return std::pow(w * own + (1.0 - w) * other, 2.0);
        };
        own_error += own * own;
        plain_error += mixed(kKappa);
        error += mixed(shared::point_kappa(kKappa, items, squared, 1.0f));
      }
      if (bias == 0.2) {
        EXPECT_LT(error, own_error) << items;
      } else {
        EXPECT_LT(error, 1.5 * own_error) << items << " items, bias " << bias;
        EXPECT_GT(plain_error, 2.0 * error) << items << " items, bias " << bias;
      }
    }
  }
  EXPECT_EQ(shared::point_kappa(kKappa, 4.0f, -1.0f, 1.0f), kKappa);  // unknown
  EXPECT_EQ(shared::point_kappa(kKappa, 4.0f, 1e6f, 0.0f), kKappa);
  EXPECT_LE(shared::point_kappa(kKappa, 4.0f, 1e30f, 1e-30f), shared::kNeverInterpolate);
}

TEST(InterpolationWeights, OwnMeansWinInTheEnd) {
  // However small the measured error, a point that keeps accumulating is shown with its own mean in the end.
  for (const float kappa : {1e-5f, 1e-2f, 1.0f}) {
    const float enough = shared::interpolation_items(kappa);
    EXPECT_NEAR(shared::own_weight(enough, kappa), 0.5f, 1e-3f) << kappa;
    EXPECT_GT(shared::own_weight(100.0f * enough, kappa), 0.99f) << kappa;
    EXPECT_LT(shared::own_weight(0.01f * enough, kappa), 0.01f) << kappa;
  }
}

TEST(InterpolationWeights, PointsEnterAtTheLargestSpacingThatDividesThem) {
  for (int top = 0; top <= 4; ++top)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        int level = top;
        while (x % (1 << level) != 0 || y % (1 << level) != 0) --level;
        EXPECT_EQ(shared::level_entered(x, y, top), level) << x << " " << y;
      }
}

}  // namespace
}  // namespace maquette
