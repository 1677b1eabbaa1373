// Splines over the directions of a lumisphere: constants exactly, means as they are given, smooth lobes closely.
#include "render/slf/direction_spline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace maquette {
namespace {

glm::vec3 random_direction(std::mt19937* random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const float z = 0.02f + 0.98f * unit(*random), phi = 6.2831853f * unit(*random), r = std::sqrt(1.0f - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// A lobe of 0.3 rad about a direction.
float lobe(const glm::vec3& about, const glm::vec3& d) { return std::exp((glm::dot(about, d) - 1.0f) / 0.09f); }

TEST(DirectionSpline, SharesSumToOneAndKeepConstants) {
  std::mt19937 random(3);
  for (const int side : {1, 2, 8, 16}) {
    const DirectionSpline spline{Lumisphere(side)};
    const int bins = spline.lumisphere().count();
    const Eigen::VectorXf ones = Eigen::VectorXf::Ones(bins);
    for (int i = 0; i < 500; ++i) {
      float sum = 0.0f;
      for (const DirectionSpline::Share& s : spline.shares(random_direction(&random))) {
        ASSERT_GE(s.weight, 0.0f);
        ASSERT_LT(s.bin, bins);
        sum += s.weight;
      }
      ASSERT_NEAR(sum, 1.0f, 1e-5f);
    }
    const Eigen::VectorXf views = Eigen::VectorXf::Ones(static_cast<Eigen::Index>(spline.views().size()));
    EXPECT_LT((spline.fit() * views - ones).cwiseAbs().maxCoeff(), 1e-4f) << side;
    EXPECT_LT((spline.interpolate() * ones - ones).cwiseAbs().maxCoeff(), 1e-4f) << side;
    EXPECT_LT((spline.from_means(4) * ones - ones).cwiseAbs().maxCoeff(), 1e-4f) << side;
  }
}

TEST(DirectionSpline, LightKeepsTheMeansOfItsBins) {
  const DirectionSpline spline{Lumisphere()};
  const Lumisphere& sphere = spline.lumisphere();
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  Eigen::VectorXf means(sphere.count());
  for (Eigen::Index k = 0; k < means.size(); ++k) means[k] = unit(random);
  means[40] = 100.0f;  // a lamp
  const Eigen::VectorXf coefficients = spline.from_means(8) * means;
  for (int k = 0; k < sphere.count(); ++k) {
    float mean = 0.0f;
    for (const DirectionSpline::BinSample& s : spline.bin_samples(k, 8))
      mean += s.weight * spline.value(coefficients, s.direction);
    EXPECT_NEAR(mean, means[k], 0.01f * 100.0f) << k;
  }
}

TEST(DirectionSpline, SmoothLobesAreClose) {
  const DirectionSpline spline{Lumisphere()};
  const Lumisphere& sphere = spline.lumisphere();
  std::mt19937 random(7);
  double fitted2 = 0.0, interpolated2 = 0.0, blurred2 = 0.0, all2 = 0.0;
  for (int i = 0; i < 40; ++i) {
    const glm::vec3 about = random_direction(&random);
    Eigen::VectorXf views(static_cast<Eigen::Index>(spline.views().size())), own(sphere.count());
    for (Eigen::Index v = 0; v < views.size(); ++v) views[v] = lobe(about, spline.views()[static_cast<std::size_t>(v)]);
    for (int k = 0; k < sphere.count(); ++k) own[k] = lobe(about, sphere.direction(k));
    const Eigen::VectorXf fitted = spline.fit() * views, interpolated = spline.interpolate() * own;
    for (int k = 0; k < 100; ++k) {
      const glm::vec3 d = random_direction(&random);
      const float exact = lobe(about, d);
      fitted2 += std::pow(spline.value(fitted, d) - exact, 2.0f);
      interpolated2 += std::pow(spline.value(interpolated, d) - exact, 2.0f);
      blurred2 += std::pow(spline.value(own, d) - exact, 2.0f);
      all2 += exact * exact;
    }
  }
  EXPECT_LT(std::sqrt(fitted2 / all2), 0.02);
  EXPECT_LT(std::sqrt(interpolated2 / all2), 0.04);
  EXPECT_GT(std::sqrt(blurred2 / all2), 0.06);  // values as coefficients blur
}

}  // namespace
}  // namespace maquette
