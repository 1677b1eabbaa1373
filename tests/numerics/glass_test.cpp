// Solid and rough glass in the path tracer against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "render/reference/traversal.h"
#include "scenes/angles.h"
#include "tests/support/path_scenes.h"

namespace maquette::test {
namespace {

constexpr double kIndex = 1.52;

std::shared_ptr<const Environment> half_sky(double above, double below) {
  return sky_of(64, 32, [=](const glm::dvec3& d) { return glm::dvec3(d.y > 0.0 ? above : below); });
}

Material glass(float thickness, float roughness) {
  Material m;
  m.glass = true;
  m.transmission = 1.0f;
  m.metallic = 0.0f;
  m.roughness = roughness;
  m.ior = static_cast<float>(kIndex);
  m.thickness = thickness;
  m.double_sided = true;
  return m;
}

struct SlabView {
  glm::vec3 origin{}, direction{};
  explicit SlabView(double degrees) {
    const double t = degrees * kDegree;
    origin = glm::vec3(2.0 * std::sin(t), 2.0 * std::cos(t), 0.0);
    direction = -glm::normalize(origin);
  }
};

/// A slab between y = 0 and y = -thickness, so wide that no ray hits an edge; both normals point outwards.
Scene slab(float thickness, const Material& material) {
  constexpr float kHalf = 500.0f;
  Primitive slab = quad({-kHalf, 0, kHalf}, {2 * kHalf, 0, 0}, {0, 0, -2 * kHalf});
  const Primitive below = quad({-kHalf, -thickness, -kHalf}, {2 * kHalf, 0, 0}, {0, 0, 2 * kHalf});
  slab.positions.insert(slab.positions.end(), below.positions.begin(), below.positions.end());
  slab.normals.insert(slab.normals.end(), below.normals.begin(), below.normals.end());
  for (const std::uint32_t i : below.indices) slab.indices.push_back(4 + i);
  return scene_of(slab, material);
}

struct Shares {
  double reflected, transmitted;
};

/// All bounces between the faces of a slab, for each polarisation; `inside`: transmittance of one crossing.
Shares slab_shares(double theta, double inside) {
  const double n = kIndex, c = std::cos(theta), t = std::sqrt(1.0 - std::sin(theta) * std::sin(theta) / (n * n));
  Shares shares{0.0, 0.0};
  for (const double r : {std::pow((c - n * t) / (c + n * t), 2), std::pow((t - n * c) / (t + n * c), 2)}) {
    const double rest = 1.0 - r * r * inside * inside;
    shares.reflected += 0.5 * (r + (1.0 - r) * (1.0 - r) * r * inside * inside / rest);
    shares.transmitted += 0.5 * (1.0 - r) * (1.0 - r) * inside / rest;
  }
  return shares;
}

TEST(Glass, SolidSlabFollowsFresnelWithAllItsBounces) {
  constexpr float kThickness = 0.1f;
  for (const double attenuation : {1.0, 0.6}) {
    Material material = glass(kThickness, 0.0f);
    material.attenuation_color = glm::vec3(static_cast<float>(attenuation));
    material.attenuation_distance = kThickness;
    const auto above = trace(slab(kThickness, material), half_sky(1.0, 0.0));
    const auto below = trace(slab(kThickness, material), half_sky(0.0, 1.0));
    for (const double degrees : {0.0, 30.0, 45.0, 60.0, 70.0, 80.0, 85.0}) {
      const double sine = std::sin(degrees * kDegree) / kIndex;
      const Shares expected = slab_shares(degrees * kDegree, std::pow(attenuation, 1.0 / std::sqrt(1.0 - sine * sine)));
      const SlabView view(degrees);
      const MeanRadiance reflected = mean_radiance(*above, {}, view.origin, view.direction, 65536);
      const MeanRadiance transmitted = mean_radiance(*below, {}, view.origin, view.direction, 65536);
      EXPECT_NEAR(reflected.mean.y, expected.reflected, 2e-4 + 4.0 * reflected.deviation)
          << degrees << ", " << attenuation;
      EXPECT_NEAR(transmitted.mean.y, expected.transmitted, 2e-4 + 4.0 * transmitted.deviation)
          << degrees << ", " << attenuation;
      EXPECT_LT(reflected.deviation + transmitted.deviation, 3e-3);
      std::printf("slab, t %.1f, %2.0f degrees: R %.4f (%.4f), T %.4f (%.4f)\n", attenuation, degrees, reflected.mean.y,
                  expected.reflected, transmitted.mean.y, expected.transmitted);
    }
  }
}

/// A stack of thin panes, more than a ray stores at a time, each with the same transmittance.
TEST(Glass, EveryPaneOfAStackAttenuatesShadowRays) {
  const auto through = [](int count, const Material& last) {
    Scene scene = scene_of(quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}), glass(0.0f, 0.0f));
    scene.materials.push_back(last);
    for (int i = 1; i < count; ++i) {
      Primitive pane = quad({-1, 0.01f * static_cast<float>(i), 1}, {2, 0, 0}, {0, 0, -2});
      pane.material = i + 1 == count ? 1 : 0;
      scene.meshes[0].primitives.push_back(pane);
    }
    const SlabView view(50.0);
    const glm::vec3 off_the_diagonals(0.0f, 0.0f, 0.3f);
    return transmittance(*trace(scene, half_sky(1.0, 1.0)), {view.origin + off_the_diagonals, view.direction}).y;
  };
  const double one = slab_shares(50.0 * kDegree, 1.0).transmitted;
  Material black = glass(0.0f, 0.0f);
  black.base_color = {0.0f, 0.0f, 0.0f, 1.0f};
  for (const int count : {2, 8, 9, 16, 17, 24}) {
    const double expected = std::pow(one, count);
    EXPECT_NEAR(through(count, glass(0.0f, 0.0f)), expected, 1e-4 * expected) << count;
    EXPECT_EQ(through(count, black), 0.0f) << count;
    EXPECT_EQ(through(count, Material()), 0.0f) << count;
  }
}

/// Closed glass without absorption is invisible in a furnace, total internal reflection included.
TEST(Glass, SolidBodiesVanishInAFurnace) {
  const auto sky = half_sky(1.0, 1.0);
  for (const float ior : {1.1f, 1.52f, 2.4f}) {
    Material material = glass(1.0f, 0.0f);
    material.ior = ior;
    PictureRequest request;
    request.camera.eye = {0.3f, 0.4f, 3.0f};
    request.width = request.height = 24;
    ReferencePicture picture(trace(scene_of(fine_sphere(64), material), sky), request);
    ASSERT_TRUE(picture.add(64));
    const Image mean = picture.mean();
    for (int i = 0; i < 24 * 24; ++i)
      EXPECT_NEAR(mean.data[static_cast<std::size_t>(4 * i + 1)], 1.0f, 2e-4f) << "index " << ior << ", pixel " << i;
  }
}

/// Radiance of a glass ball along its axis: straight through both faces, and forwards after an even number k of inner
/// reflections.
TEST(Glass, BallTransmitsAndReflectsAlongItsAxis) {
  const auto sky = sky_of(64, 32, [](const glm::dvec3& d) { return glm::dvec3(d.z > 0.0 ? 1.0 : 0.0); });
  const auto scene = trace(scene_of(fine_sphere(256), glass(1.0f, 0.0f)), sky);
  const double r = std::pow((kIndex - 1.0) / (kIndex + 1.0), 2);
  const double forwards = (1.0 - r) * (1.0 - r) / (1.0 - r * r);
  // There is no light towards -z: only what is reflected back counts.
  EXPECT_NEAR(mean_radiance(*scene, {}, {1e-3f, 1e-3f, 3.0f}, {0, 0, -1}, 16384).mean.y, 1.0 - forwards, 1e-3);
  EXPECT_NEAR(mean_radiance(*scene, {}, {1e-3f, 1e-3f, -3.0f}, {0, 0, 1}, 16384).mean.y, forwards, 1e-3);
}

/// A lossless rough pane in a furnace shows the albedo of a GGX lobe with fully reflecting facets, computed by brute
/// force over the hemisphere: only masking and shadowing lose energy.
double facet_albedo(double cosine, double alpha) {
  const glm::dvec3 wo(std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
  constexpr int kTheta = 1500, kPhi = 720;
  double sum = 0.0;
  for (int i = 0; i < kTheta; ++i)
    for (int j = 0; j < kPhi; ++j) {
      const double theta = (i + 0.5) / kTheta * 90.0 * kDegree, phi = (j + 0.5) / kPhi * 360.0 * kDegree;
      const glm::dvec3 wi(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      const glm::dvec3 h = glm::normalize(wi + wo);
      const double a2 = alpha * alpha, t = h.z * h.z * (a2 - 1.0) + 1.0, d = a2 / (std::numbers::pi * t * t);
      const auto lambda = [&](double c) { return 0.5 * (std::sqrt(1.0 + a2 * (1.0 / (c * c) - 1.0)) - 1.0); };
      const double g2 = 1.0 / (1.0 + lambda(wi.z) + lambda(wo.z));
      sum += d * g2 / (4.0 * wo.z) * std::sin(theta);
    }
  return sum * (90.0 * kDegree / kTheta) * (360.0 * kDegree / kPhi);
}

TEST(Glass, RoughPaneShowsItsFacetsAlbedoInAFurnace) {
  constexpr float kHalf = 500.0f;
  const Primitive floor = quad({-kHalf, 0, kHalf}, {2 * kHalf, 0, 0}, {0, 0, -2 * kHalf});
  for (const float roughness : {0.3f, 0.5f, 0.8f}) {
    const auto scene = trace(scene_of(floor, glass(0.0f, roughness)), half_sky(1.0, 1.0));
    for (const double degrees : {0.0, 45.0, 75.0}) {
      const SlabView view(degrees);
      const MeanRadiance seen = mean_radiance(*scene, {}, view.origin, view.direction, 16384);
      const double expected = facet_albedo(std::cos(degrees * kDegree), roughness * roughness);
      EXPECT_NEAR(seen.mean.y, expected, 1e-3 * expected + 4.0 * seen.deviation) << roughness << ", " << degrees;
      std::printf("rough pane %.1f, %2.0f degrees: %.4f (%.4f)\n", static_cast<double>(roughness), degrees, seen.mean.y,
                  expected);
    }
  }
}

/// Rough solid glass loses energy only by masking and shadowing, and never gains any.
TEST(Glass, RoughSolidKeepsItsEnergy) {
  for (const auto& [roughness, least] : {std::pair{0.1f, 0.995}, {0.3f, 0.97}, {0.6f, 0.75}}) {
    const auto scene = trace(slab(0.1f, glass(0.1f, roughness)), half_sky(1.0, 1.0));
    const SlabView view(30.0);
    const MeanRadiance seen = mean_radiance(*scene, {}, view.origin, view.direction, 16384);
    EXPECT_LT(seen.mean.y, 1.0 + 1e-3 + 4.0 * seen.deviation) << roughness;
    EXPECT_GT(seen.mean.y, least) << roughness;
    std::printf("rough solid %.1f: %.4f\n", static_cast<double>(roughness), seen.mean.y);
  }
}

}  // namespace
}  // namespace maquette::test
