#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "render/prt/relight.h"
#include "render/prt/transfer_bake.h"
#include "scenes/btf/broad_light.h"
#include "tests/support/never.h"
#include "tests/support/small_btf.h"

namespace maquette {
namespace {

std::vector<glm::vec3> factors_of(const Btf& btf, const BtfView& view, int texel) {
  const float side = static_cast<float>(btf.width);
  std::vector<glm::vec3> factors(static_cast<std::size_t>(1 + btf.components));
  const glm::vec2 uv((static_cast<float>(texel % btf.width) + 0.5f) / side,
                     (static_cast<float>(texel / btf.width) + 0.5f) / side);
  read_btf_factors(btf, view, {uv, 0.0f}, factors.data());
  return factors;
}

/// rho of the first `components` at the light `l` of a view.
glm::dvec3 rho_of(const Btf& btf, const BtfView& view, int texel, std::size_t l, int components) {
  const std::vector<glm::vec3> factors = factors_of(btf, view, texel);
  glm::dvec3 rho(factors[0]);
  for (int c = 0; c < components; ++c)
    rho += static_cast<double>(
               view.light_weights[l * static_cast<std::size_t>(btf.components) + static_cast<std::size_t>(c)]) *
           glm::dvec3(factors[static_cast<std::size_t>(c + 1)]);
  return rho;
}

/// RMS of what `fitted` misses of light from caps of 45 degrees, by plain sums over views, texels, caps and lights.
double error_by_sums(const Btf& btf,
                     const std::function<glm::dvec3(std::size_t view, int texel, std::size_t light)>& fitted) {
  double lost = 0.0, all = 0.0;
  for (std::size_t v = 0; v < btf.views.size(); ++v) {
    const DirectionMesh& lights = *btf.views[v].lights;
    const std::vector<double> shares = lights.quadrature().projected;
    for (int texel = 0; texel < btf.width * btf.height; ++texel)
      for (const glm::dvec3& cap : ubo_directions()) {
        glm::dvec3 full(0.0), missed(0.0);
        for (std::size_t l = 0; l < lights.size(); ++l) {
          if (std::acos(std::min(glm::dot(cap, lights.directions()[l]), 1.0)) > glm::radians(45.0)) continue;
          const glm::dvec3 rho = rho_of(btf, btf.views[v], texel, l, btf.components);
          full += shares[l] * rho;
          missed += shares[l] * (rho - fitted(v, texel, l));
        }
        all += glm::dot(full, full);
        lost += glm::dot(missed, missed);
      }
  }
  return std::sqrt(lost / all);
}

TEST(MaterialFit, ErrorsOfComponentsAreThoseOfPlainSums) {
  const auto btf = test::small_btf(3, 4);
  const std::vector<double> errors = btf_errors_by_components(*btf);
  ASSERT_EQ(errors.size(), 5u);
  EXPECT_EQ(errors[4], 0.0);
  for (int kept = 0; kept < 4; ++kept) {
    const double expected = error_by_sums(
        *btf, [&](std::size_t v, int texel, std::size_t l) { return rho_of(*btf, btf->views[v], texel, l, kept); });
    EXPECT_NEAR(errors[static_cast<std::size_t>(kept)], expected, 1e-5 + 1e-3 * expected) << kept;
  }
  EXPECT_GT(errors[0], 0.02);
  EXPECT_GT(errors[0], errors[1]);
}

TEST(MaterialFit, TakesTheFewestComponentsThatMeetTheError) {
  const auto btf = test::small_btf(3, 4);
  const std::vector<double> errors = btf_errors_by_components(*btf);
  for (const double asked : {1.0, 0.3, 0.1, 0.03, 0.01, 1e-9}) {
    const auto fit = fit_material(*btf, {.btf_components = 8, .btf_error = asked}, kNever);
    ASSERT_TRUE(fit);
    const auto chosen = static_cast<std::size_t>(fit->components);
    EXPECT_LE(errors[chosen], asked);
    EXPECT_EQ(fit->error, errors[chosen]);
    EXPECT_TRUE(chosen == 0 || errors[chosen - 1] > asked);
  }
  // A limit is kept, and what it costs is said.
  const auto limited = fit_material(*btf, {.btf_components = 1, .btf_error = 1e-9}, kNever);
  EXPECT_EQ(limited->components, 1);
  EXPECT_EQ(limited->error, errors[1]);
  EXPECT_EQ(fit_material(*btf, {.btf_components = 3}, kNever)->components, 3);
}

TEST(MaterialFit, AMatteMaterialNeedsNoComponent) {
  auto btf = std::make_shared<Btf>(*test::small_btf(2, 2));
  for (BtfView& view : btf->views) std::fill(view.light_weights.begin(), view.light_weights.end(), 0.0f);
  const auto fit = fit_material(*btf, {.btf_components = 8, .btf_error = 0.02}, kNever);
  EXPECT_EQ(fit->components, 0);
  EXPECT_EQ(fit->error, 0.0);
}

TEST(MaterialFit, TheJointFormIsHeldAgainstTheSameLights) {
  const auto btf = test::small_btf(4, 3);
  TransferOptions options{.btf_components = 1, .joint = true, .texel_clusters = 2};
  const auto coarse = fit_material(*btf, options, kNever);
  ASSERT_TRUE(coarse && coarse->joint);
  const double expected = error_by_sums(*btf, [&](std::size_t v, int texel, std::size_t l) {
    return glm::dvec3(
        evaluate_joint_btf(*coarse->joint, *btf, texel, v, glm::vec3(btf->views[v].lights->directions()[l])));
  });
  EXPECT_NEAR(coarse->error, expected, 1e-3 * expected + 1e-4);
  EXPECT_GT(coarse->error, 0.01);
  // More are taken until the error is met.
  options.btf_components = 8;
  options.btf_error = 0.5 * coarse->error;
  const auto fine = fit_material(*btf, options, kNever);
  EXPECT_LE(fine->error, options.btf_error);
  EXPECT_GT(fine->components, 1);
  EXPECT_EQ(fine->components + 1, fine->joint->terms);
}

TEST(MaterialFit, LightThatIsLeftOutIsPartOfTheError) {
  CubeLight light(4, 3);
  for (Eigen::Index i = 0; i < 4; ++i) light.row(i).setConstant(static_cast<float>(i));
  const std::vector<float> importance{1.0f, 2.0f, 1.0f, 2.0f};
  const KeptLight kept{{1, 3}, {glm::vec3(1.0f), glm::vec3(2.5f)}};
  // Left: 0.5 of the last, and the third.
  EXPECT_NEAR(light_left_out(light, kept, importance), std::sqrt((1.0 + 4.0) / (4.0 + 4.0 + 36.0)), 1e-6);
  EXPECT_EQ(light_left_out(CubeLight::Zero(4, 3), {}, importance), 0.0);
}

}  // namespace
}  // namespace maquette
