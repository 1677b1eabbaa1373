#include "scenes/btf/btf.h"

#include <OpenEXR/ImfRgba.h>
#include <gtest/gtest.h>
#include <xmmintrin.h>

#include <Eigen/SVD>
#include <cmath>
#include <numbers>
#include <random>

#include "scenes/btf/factorise.h"
#include "scenes/btf/half_floats.h"

namespace {

using namespace maquette;

glm::dvec3 random_direction(std::mt19937* random, double least_z = 0.0) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double z = least_z + (1.0 - least_z) * uniform(*random), phi = 2.0 * std::numbers::pi * uniform(*random);
  return {std::sqrt(1.0 - z * z) * std::cos(phi), std::sqrt(1.0 - z * z) * std::sin(phi), z};
}

glm::dvec3 interpolate(const DirectionMesh& mesh, const DirectionWeights& w) {
  glm::dvec3 sum(0.0);
  for (std::size_t k = 0; k < 3; ++k)
    sum += static_cast<double>(w.weight[static_cast<int>(k)]) * mesh.directions()[static_cast<std::size_t>(w.index[k])];
  return sum;
}

std::vector<std::vector<glm::dvec3>> direction_sets() {
  std::vector<std::vector<glm::dvec3>> sets = {ubo_directions()};
  std::mt19937 random(7);
  for (const int count : {4, 5, 9, 40, 151}) {
    sets.emplace_back();
    for (int i = 0; i < count; ++i) sets.back().push_back(random_direction(&random, 0.1));
  }
  // Nearly equal directions, and a ring without its pole.
  sets.push_back({direction_of_angles(10, 0), direction_of_angles(10, 0.1), direction_of_angles(10.1, 0),
                  direction_of_angles(60, 120), direction_of_angles(60, 240)});
  sets.emplace_back();
  for (int i = 0; i < 12; ++i) sets.back().push_back(direction_of_angles(75, 30 * i));
  return sets;
}

TEST(DirectionMesh, TheCircleOfEveryTriangleIsEmpty) {
  for (const std::vector<glm::dvec3>& set : direction_sets()) {
    const DirectionMesh mesh(set);
    EXPECT_EQ(mesh.triangles().size(), 2 * set.size() - 2 - mesh.border().size());  // Euler
    for (const std::array<int, 3>& t : mesh.triangles()) {
      const auto& a = set[static_cast<std::size_t>(t[0])];
      const glm::dvec3 normal =
          glm::cross(set[static_cast<std::size_t>(t[1])] - a, set[static_cast<std::size_t>(t[2])] - a);
      for (const glm::dvec3& p : set) EXPECT_LE(glm::dot(normal, p - a), 1e-8) << set.size();
    }
  }
}

TEST(DirectionMesh, WeightsSumToOneReproduceDirectionsAndMatchASearch) {
  std::mt19937 random(1);
  for (const std::vector<glm::dvec3>& set : direction_sets()) {
    const DirectionMesh mesh(set);
    for (std::size_t i = 0; i < set.size(); ++i)
      EXPECT_LT(glm::length(interpolate(mesh, mesh.find(glm::vec3(set[i]))) - set[i]), 2e-4);
    for (int i = 0; i < 2000; ++i) {
      const glm::dvec3 d = random_direction(&random);
      const DirectionWeights w = mesh.find(glm::vec3(d));
      EXPECT_NEAR(w.weight.x + w.weight.y + w.weight.z, 1.0f, 1e-5f);
      const glm::dvec3 found = glm::normalize(interpolate(mesh, w));
      bool inside = false;  // by testing every triangle
      for (const std::array<int, 3>& t : mesh.triangles()) {
        const glm::dvec3 b =
            glm::inverse(glm::dmat3(set[static_cast<std::size_t>(t[0])], set[static_cast<std::size_t>(t[1])],
                                    set[static_cast<std::size_t>(t[2])])) *
            d;
        inside |= std::min({b.x, b.y, b.z}) >= 0.0;
      }
      if (inside) {
        EXPECT_LT(glm::length(found - d), 2e-3);
      } else {  // no point of a border arc is nearer
        for (const std::array<int, 2>& edge : mesh.border())
          for (int k = 0; k <= 20; ++k) {
            const glm::dvec3 p = glm::normalize(
                glm::mix(set[static_cast<std::size_t>(edge[0])], set[static_cast<std::size_t>(edge[1])], k / 20.0));
            EXPECT_GE(glm::dot(found, d), glm::dot(p, d) - 1e-5);
          }
      }
    }
  }
}

/// A small motion moves the interpolated value a little, inside, across edges and beyond the border.
TEST(DirectionMesh, IsContinuousUnderMotion) {
  std::mt19937 random(2);
  for (const std::vector<glm::dvec3>& set : {ubo_directions(), direction_sets()[4]}) {
    const DirectionMesh mesh(set);
    std::vector<double> values(set.size());
    for (double& v : values) v = std::uniform_real_distribution<double>(0.0, 1.0)(random);
    const auto value = [&](const glm::dvec3& d) {
      const DirectionWeights w = mesh.find(glm::vec3(d));
      double sum = 0.0;
      for (std::size_t k = 0; k < 3; ++k)
        sum += static_cast<double>(w.weight[static_cast<int>(k)]) * values[static_cast<std::size_t>(w.index[k])];
      return sum;
    };
    for (int path = 0; path < 40; ++path) {
      const glm::dvec3 from = random_direction(&random), to = random_direction(&random);
      double before = value(from);
      for (int i = 1; i <= 4000; ++i) {
        const double now = value(glm::normalize(glm::mix(from, to, i / 4000.0)));
        ASSERT_LT(std::abs(now - before), 0.03) << path << " " << i;
        before = now;
      }
    }
  }
}

TEST(DirectionMesh, OneDirectionTwoAndAGreatCircle) {
  const DirectionMesh one({{0.0, 0.0, 1.0}});
  EXPECT_EQ(one.find({1.0f, 0.0f, 0.0f}).weight.x, 1.0f);
  const DirectionMesh two({direction_of_angles(0, 0), direction_of_angles(60, 0)});
  DirectionWeights w = two.find(glm::vec3(direction_of_angles(30, 0)));
  EXPECT_NEAR(w.weight[0], 0.5f, 1e-5f);
  w = two.find(glm::vec3(direction_of_angles(80, 0)));
  EXPECT_NEAR(w.weight[w.index[0] == 1 ? 0 : 1], 1.0f, 1e-5f);
  const DirectionMesh circle({direction_of_angles(60, 0), direction_of_angles(60, 180), direction_of_angles(0, 0)});
  w = circle.find(glm::vec3(direction_of_angles(30, 180)));
  EXPECT_LT(glm::length(glm::normalize(interpolate(circle, w)) - direction_of_angles(30, 180)), 1e-5);
}

TEST(DirectionMesh, QuadratureIntegratesTheHemisphere) {
  for (const std::vector<glm::dvec3>& set : direction_sets()) {
    const DirectionMesh::Quadrature q = DirectionMesh(set).quadrature();
    double all = 0.0, projected = 0.0;
    for (std::size_t i = 0; i < set.size(); ++i) {
      all += q.solid_angle[i];
      projected += q.projected[i];
    }
    EXPECT_NEAR(all, 2.0 * std::numbers::pi, 1e-4);
    EXPECT_NEAR(projected, std::numbers::pi, 1e-4);
  }
}

TEST(HalfFloats, AllComeBackAndRoundAsImathDoes) {
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
    if ((bits & 0x7c00) == 0x7c00) continue;  // infinite or NaN
    const auto half = static_cast<std::uint16_t>(bits);
    EXPECT_EQ(float_of_half(half), imath_half_to_float(half));
    EXPECT_EQ(half_of_float(float_of_half(half)), half);
  }
  std::mt19937 random(3);
  for (int i = 0; i < 200000; ++i) {
    const float value = std::ldexp(std::uniform_real_distribution<float>(-1.0f, 1.0f)(random),
                                   std::uniform_int_distribution<int>(-30, 15)(random));
    EXPECT_EQ(half_of_float(value), imath_float_to_half(value)) << value;
  }
  EXPECT_EQ(float_of_half(half_of_float(1e30f)), 65504.0f);
  EXPECT_EQ(float_of_half(half_of_float(-1e30f)), -65504.0f);
}

/// As on the threads of the ray tracer, which flush denormal floats.
TEST(HalfFloats, AreTheSameWhereDenormalFloatsCountAsZero) {
  const unsigned before = _mm_getcsr();
  _mm_setcsr(before | 0x8040u);
  std::vector<float> values(0x10000, 0.0f);
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) values[bits] = float_of_half(static_cast<std::uint16_t>(bits));
  _mm_setcsr(before);
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits)
    if ((bits & 0x7c00) != 0x7c00) {
      EXPECT_EQ(values[bits], imath_half_to_float(static_cast<std::uint16_t>(bits)));
    }
}

/// Smooth in texels and directions, with more components than are kept.
float made_value(const glm::dvec3& light, const glm::dvec3& view, int texel, int channel) {
  const double t = 0.37 * texel + 0.9 * channel;
  return static_cast<float>(0.4 + 0.2 * std::sin(t) * light.x + 0.1 * std::cos(2.3 * t) * light.y * view.z +
                            0.05 * std::sin(5.1 * t) * light.z * light.x + 0.1 * std::cos(t) * view.y);
}

std::vector<float> made_images(const std::vector<glm::dvec3>& lights, const glm::dvec3& view, int texels) {
  std::vector<float> images;
  for (const glm::dvec3& light : lights)
    for (int t = 0; t < texels; ++t)
      for (int c = 0; c < 3; ++c) images.push_back(made_value(light, view, t, c));
  return images;
}

Btf made_btf(int width, int height, int components) {
  Btf btf;
  btf.width = width;
  btf.height = height;
  btf.components = components;
  btf.texel_m = 1e-3;
  const std::vector<glm::dvec3> directions = ubo_directions();
  const BtfLights lights = make_btf_lights(directions);
  for (const glm::dvec3& view : directions) {
    std::vector<float> images = made_images(directions, view, width * height);
    btf.views.push_back(factorise_btf_view(view, lights, components, &images));
  }
  complete_btf(&btf);
  return btf;
}

TEST(FactoriseBtf, IsTheBestOfItsRankByTheSingularValues) {
  constexpr int kTexels = 35, kComponents = 3;
  std::mt19937 random(4);
  std::vector<glm::dvec3> directions = ubo_directions();
  directions.resize(20);
  const BtfLights lights = make_btf_lights(directions);
  std::vector<float> images(directions.size() * kTexels * 3);
  for (float& v : images) v = std::uniform_real_distribution<float>(0.0f, 1.0f)(random);
  Eigen::MatrixXd x(directions.size(), kTexels * 3);
  for (Eigen::Index l = 0; l < x.rows(); ++l)
    for (Eigen::Index t = 0; t < x.cols(); ++t) x(l, t) = images[static_cast<std::size_t>(l * x.cols() + t)];
  const Eigen::VectorXd shares = Eigen::Map<const Eigen::VectorXd>(lights.shares.data(), x.rows());
  const Eigen::RowVectorXd mean = shares.transpose() * x;
  const Eigen::MatrixXd scaled = shares.cwiseSqrt().asDiagonal() * (x.rowwise() - mean);
  const Eigen::VectorXd s = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues() / std::sqrt(kTexels);

  const BtfView view = factorise_btf_view(directions[0], lights, kComponents, &images);
  EXPECT_NEAR(view.figures.energy, s.squaredNorm(), 1e-4 * s.squaredNorm());
  for (int c = 0; c < kComponents; ++c)
    EXPECT_NEAR(view.figures.spectrum[static_cast<std::size_t>(c)], s[c] * s[c], 1e-4 * s[0] * s[0]);
  double error = 0.0;
  for (Eigen::Index l = 0; l < x.rows(); ++l)
    for (Eigen::Index t = 0; t < x.cols(); ++t) {
      const auto texel = static_cast<std::size_t>(t / 3), channel = static_cast<std::size_t>(t % 3);
      const std::uint16_t* f = &view.factors[texel * 3 * (1 + kComponents)];
      double value = float_of_half(f[channel]);
      for (std::size_t c = 0; c < kComponents; ++c)
        value += double(view.light_weights[static_cast<std::size_t>(l) * kComponents + c]) *
                 float_of_half(f[3 + 3 * c + channel]);
      error += shares[l] * (value - x(l, t)) * (value - x(l, t)) / kTexels;
    }
  EXPECT_NEAR(error, s.tail(s.size() - kComponents).squaredNorm(), 1e-3 * s.squaredNorm());
}

TEST(FactoriseBtf, FewerLightsThanComponentsAreFilledWithZeros) {
  const std::vector<glm::dvec3> directions = {{0.0, 0.0, 1.0}, direction_of_angles(60, 10)};
  std::vector<float> images = made_images(directions, directions[0], 6);
  const std::vector<float> before = images;
  const BtfView view = factorise_btf_view(directions[0], make_btf_lights(directions), 4, &images);
  for (std::size_t l = 0; l < 2; ++l)
    for (std::size_t t = 0; t < 6; ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        float value = float_of_half(view.factors[t * 15 + k]);
        for (std::size_t c = 0; c < 4; ++c)
          value += view.light_weights[4 * l + c] * float_of_half(view.factors[t * 15 + 3 + 3 * c + k]);
        EXPECT_NEAR(value, before[l * 18 + t * 3 + k], 1e-3f);
      }
}

TEST(Btf, EvaluatesTheSlowInterpolationInDouble) {
  constexpr int kWidth = 8, kHeight = 4, kComponents = 5;  // made_value has fewer
  const Btf btf = made_btf(kWidth, kHeight, kComponents);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 2.0);
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 wi = random_direction(&random, 1e-3), wo = random_direction(&random, 1e-3);
    const glm::dvec2 uv(uniform(random), uniform(random));
    const DirectionWeights v = btf.view_mesh.find(glm::vec3(wo)), l = btf.view_mesh.find(glm::vec3(wi));
    glm::dvec3 expected(0.0);
    const double x = uv.x * kWidth - 0.5, y = uv.y * kHeight - 0.5;
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx) {
        const double wx = dx ? x - std::floor(x) : 1.0 - x + std::floor(x),
                     wy = dy ? y - std::floor(y) : 1.0 - y + std::floor(y);
        const int column = ((static_cast<int>(std::floor(x)) + dx) % kWidth + kWidth) % kWidth;
        const int row = ((static_cast<int>(std::floor(y)) + dy) % kHeight + kHeight) % kHeight;
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b)
            for (int c = 0; c < 3; ++c)
              expected[c] +=
                  wx * wy * double(v.weight[a]) * double(l.weight[b]) *
                  made_value(btf.view_mesh.directions()[static_cast<std::size_t>(l.index[static_cast<std::size_t>(b)])],
                             btf.view_mesh.directions()[static_cast<std::size_t>(v.index[static_cast<std::size_t>(a)])],
                             row * kWidth + column, c);
      }
    const glm::vec3 found = evaluate_btf(btf, {glm::vec2(uv), 0.0f}, glm::vec3(wi), glm::vec3(wo));
    EXPECT_LT(glm::length(glm::dvec3(found) - expected), 2e-3);
  }
}

TEST(Btf, LevelsAreTheFactorisationOfFilteredImages) {
  for (const auto& [width, height] : {std::pair{8, 4}, std::pair{7, 5}}) {
    const Btf btf = made_btf(width, height, 5);
    const glm::dvec3 light = btf.view_mesh.directions()[30], view = btf.view_mesh.directions()[11];
    glm::dvec3 mean(0.0);
    for (int t = 0; t < width * height; ++t)
      for (int c = 0; c < 3; ++c) mean[c] += static_cast<double>(made_value(light, view, t, c)) / (width * height);
    for (const float footprint : {1.0f, 40.0f}) {
      const glm::vec3 coarse = evaluate_btf(btf, {{0.3f, 0.9f}, footprint}, glm::vec3(light), glm::vec3(view));
      EXPECT_LT(glm::length(glm::dvec3(coarse) - mean), width == 8 || footprint > 1.0f ? 1e-3 : 0.03);
    }
  }
  const Btf btf = made_btf(8, 4, 5);  // level 1: the mean of 2 x 2 texels at its texel's centre
  const glm::dvec3 light = btf.view_mesh.directions()[5], view = btf.view_mesh.directions()[60];
  glm::dvec3 mean(0.0);
  for (const int t : {2, 3, 10, 11})
    for (int c = 0; c < 3; ++c) mean[c] += 0.25 * made_value(light, view, t, c);
  EXPECT_LT(glm::length(
                glm::dvec3(evaluate_btf(btf, {{3.0f / 8.0f, 0.25f}, 0.25f}, glm::vec3(light), glm::vec3(view))) - mean),
            1e-3);
}

TEST(Btf, IsZeroBelowTheHorizonAndNeverNegative) {
  Btf btf = made_btf(2, 2, 1);
  EXPECT_EQ(evaluate_btf(btf, {}, {0.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 1.0f}), glm::vec3(0.0f));
  for (BtfView& view : btf.views)
    for (std::uint16_t& f : view.factors) f = half_of_float(-1.0f);
  EXPECT_EQ(evaluate_btf(btf, {}, {0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 1.0f}), glm::vec3(0.0f));
}

}  // namespace
