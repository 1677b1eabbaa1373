#include "render/lights/light_list.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace maquette {
namespace {

/// The same source in double.
namespace exact_lights {
using dvec2 = glm::dvec2;
using dvec3 = glm::dvec3;
#define float double
#define vec2 dvec2
#define vec3 dvec3
using glm::cross, glm::dot, glm::length;
using std::abs, std::sqrt;
[[maybe_unused]] inline glm::dvec3 abs(const glm::dvec3& v) { return glm::abs(v); }
inline double max(double a, double b) { return std::max(a, b); }
inline double min(double a, double b) { return std::min(a, b); }
inline double clamp(double v, double low, double high) { return std::clamp(v, low, high); }
using uint = unsigned int;
#include "shared/lights.glsl"
#undef float
#undef vec2
#undef vec3
}  // namespace exact_lights

LightRecord triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, bool both = false) {
  LightRecord light{};
  light.kind = shared::kLightTriangle;
  light.position = a;
  light.direction = b - a;
  light.edge2 = c - a;
  light.range_m = both ? 1.0f : 0.0f;
  light.color = glm::vec3(10.0f, 5.0f, 1.0f);
  return light;
}

/// Lambert's formula: irradiance at a point from a polygon of unit radiance wholly above its horizon.
/// Source: Baum et al. 1989, "Improving Radiosity Solutions Through the Use of Analytically Determined Form-Factors".
double polygon_irradiance(const glm::dvec3& point, const glm::dvec3& normal, const std::array<glm::dvec3, 3>& corners) {
  double sum = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3 a = glm::normalize(corners[k] - point);
    const glm::dvec3 b = glm::normalize(corners[(k + 1) % 3] - point);
    const glm::dvec3 axis = glm::cross(a, b);
    sum += std::atan2(glm::length(axis), glm::dot(a, b)) * glm::dot(glm::normalize(axis), normal);
  }
  return 0.5 * std::abs(sum);
}

TEST(LightFormulas, PointFollowsTheInverseSquareAtAnyScale) {
  for (float scale : {1e-6f, 1.0f, 1e6f}) {
    LightRecord light{};
    light.kind = shared::kLightPoint;
    light.color = glm::vec3(100.0f, 50.0f, 25.0f) * scale * scale;
    light.position = glm::vec3(0.0f, 3.0f, 4.0f) * scale;
    const auto s = shared::light_sample(light, glm::vec3(0.0f), {0.3f, 0.7f});
    EXPECT_NEAR(s.distance_m / scale, 5.0f, 1e-5f);
    EXPECT_NEAR(s.radiance.x, 4.0f, 1e-5f);
    EXPECT_NEAR(s.radiance.z, 1.0f, 1e-5f);
    EXPECT_NEAR(glm::length(s.wi - glm::vec3(0.0f, 0.6f, 0.8f)), 0.0f, 1e-6f);
    EXPECT_EQ(s.pdf, 0.0f);
  }
}

TEST(LightFormulas, PointAtThePositionOfTheLightIsDark) {
  LightRecord light{};
  light.kind = shared::kLightPoint;
  light.color = glm::vec3(1.0f);
  light.position = glm::vec3(1.0f);
  EXPECT_EQ(shared::light_sample(light, glm::vec3(1.0f), {0.5f, 0.5f}).radiance, glm::vec3(0.0f));
}

TEST(LightFormulas, RangeEndsSmoothlyAsTheExtensionSays) {
  LightRecord light{};
  light.kind = shared::kLightPoint;
  light.color = glm::vec3(1.0f);
  light.range_m = 2.0f;
  for (float d : {0.5f, 1.0f, 1.9f, 2.0f, 3.0f}) {
    light.position = glm::vec3(0.0f, d, 0.0f);
    const double expected = std::max(0.0, 1.0 - std::pow(d / 2.0, 4.0)) / (static_cast<double>(d) * d);
    EXPECT_NEAR(shared::light_sample(light, glm::vec3(0.0f), {0.5f, 0.5f}).radiance.x, expected, 1e-6) << d;
  }
}

TEST(LightFormulas, SpotFallsFromInnerToOuterCone) {
  LightRecord light{};
  light.kind = shared::kLightSpot;
  light.color = glm::vec3(8.0f);
  light.direction = glm::vec3(0.0f, -1.0f, 0.0f);
  const double inner = 0.3;
  const double outer = 0.6;
  light.edge2 = glm::vec3(std::cos(inner), std::cos(outer), 0.0f);
  double before = 9.0;
  for (double angle = 0.0; angle < 1.5; angle += 0.05) {
    light.position = glm::vec3(2.0 * std::sin(angle), 2.0 * std::cos(angle), 0.0);
    const double got = shared::light_sample(light, glm::vec3(0.0f), {0.5f, 0.5f}).radiance.x;
    const double t = (std::cos(angle) - std::cos(outer)) / (std::cos(inner) - std::cos(outer));
    const double clamped = std::clamp(t, 0.0, 1.0);
    EXPECT_NEAR(got, 2.0 * clamped * clamped, 1e-5) << angle;
    EXPECT_LE(got, before + 1e-6);
    before = got;
  }
}

TEST(LightFormulas, DirectionalShinesAgainstItsDirection) {
  LightRecord light{};
  light.kind = shared::kLightDirectional;
  light.color = glm::vec3(3.0f, 2.0f, 1.0f);
  light.direction = glm::vec3(0.0f, -0.6f, 0.8f);
  const auto s = shared::light_sample(light, glm::vec3(5.0f), {0.5f, 0.5f});
  EXPECT_EQ(s.wi, glm::vec3(0.0f, 0.6f, -0.8f));
  EXPECT_EQ(s.radiance, light.color);
  EXPECT_EQ(shared::light_bandwidth(light, s.wi, s.distance_m, 20.0f), 0.0f);
}

TEST(LightFormulas, TriangleGivesLambertsIrradianceAndItsSolidAngle) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (double scale : {1e-6, 1.0, 1e6}) {
    for (int trial = 0; trial < 12; ++trial) {
      std::array<glm::dvec3, 3> corners{};
      for (glm::dvec3& c : corners)
        c = scale * glm::dvec3(uniform(random), 1.3 + 0.5 * uniform(random), uniform(random));
      if (glm::cross(corners[1] - corners[0], corners[2] - corners[0]).y > 0.0) std::swap(corners[1], corners[2]);
      const glm::vec3 a(corners[0]);
      const LightRecord light = triangle(a, glm::vec3(corners[1]), glm::vec3(corners[2]));
      double irradiance = 0.0;
      double solid_angle = 0.0;
      const int side = 160;
      for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
          const glm::vec2 u((static_cast<float>(i) + 0.5f) / side, (static_cast<float>(j) + 0.5f) / side);
          const auto s = shared::light_sample(light, glm::vec3(0.0f), u);
          ASSERT_TRUE(std::isfinite(s.pdf) && std::isfinite(s.radiance.x));
          if (s.pdf == 0.0f) continue;
          irradiance += s.radiance.x / 10.0 * s.wi.y / (side * side);
          solid_angle += 1.0 / s.pdf / (side * side);
        }
      }
      // Source: van Oosterom and Strackee 1983, Eq. 8.
      const glm::dvec3 p = glm::normalize(corners[0]);
      const glm::dvec3 q = glm::normalize(corners[1]);
      const glm::dvec3 r = glm::normalize(corners[2]);
      const double expected = 2.0 * std::atan2(std::abs(glm::dot(p, glm::cross(q, r))),
                                               1.0 + glm::dot(p, q) + glm::dot(q, r) + glm::dot(r, p));
      const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
      const bool faces = glm::dot(normal, corners[0]) < 0.0;
      const double exact = polygon_irradiance(glm::dvec3(0.0), glm::dvec3(0.0, 1.0, 0.0), corners);
      EXPECT_NEAR(irradiance, faces ? exact : 0.0, 2e-3 * exact) << scale << " " << trial;
      EXPECT_NEAR(solid_angle, faces ? expected : 0.0, 2e-3 * expected) << scale << " " << trial;
    }
  }
}

TEST(LightFormulas, TriangleEmitsToOneSideUnlessDoubleSided) {
  const LightRecord one = triangle({0, 1, 0}, {1, 1, 0}, {0, 1, 1});  // normal -y: down
  const LightRecord both = triangle({0, 1, 0}, {1, 1, 0}, {0, 1, 1}, true);
  const glm::vec2 u(0.4f, 0.6f);
  EXPECT_GT(shared::light_sample(one, {0, 0, 0}, u).radiance.x, 0.0f);
  EXPECT_EQ(shared::light_sample(one, {0, 2, 0}, u).radiance.x, 0.0f);
  EXPECT_GT(shared::light_sample(both, {0, 2, 0}, u).radiance.x, 0.0f);
  EXPECT_EQ(shared::light_sample(both, {5, 1, 0}, u).radiance.x, 0.0f);  // in its plane
  EXPECT_EQ(shared::light_sample(triangle({0, 1, 0}, {0, 1, 0}, {0, 1, 0}), {0, 0, 0}, u).radiance.x, 0.0f);
}

TEST(LightFormulas, FloatAgreesWithDouble) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  for (int trial = 0; trial < 3000; ++trial) {
    const auto vector = [&] { return glm::vec3(uniform(random), uniform(random), uniform(random)); };
    LightRecord light = triangle(vector(), vector(), vector(), true);
    light.kind = static_cast<unsigned>(trial % 4);
    if (light.kind != shared::kLightTriangle) light.direction = glm::normalize(light.direction);
    if (light.kind == shared::kLightSpot) light.edge2 = glm::vec3(0.9f, 0.5f, 0.0f);
    exact_lights::LightRecord same{};
    same.position = light.position;
    same.kind = light.kind;
    same.direction = light.direction;
    same.range_m = static_cast<double>(light.range_m);
    same.color = light.color;
    same.edge2 = light.edge2;
    const glm::vec3 point = 3.0f * vector();
    const glm::vec2 u(0.5f + 0.49f * uniform(random), 0.5f + 0.49f * uniform(random));
    const auto got = shared::light_sample(light, point, u);
    const auto expected = exact_lights::light_sample(same, glm::dvec3(point), glm::dvec2(u));
    EXPECT_NEAR(got.radiance.x, expected.radiance.x, 1e-4 * (1.0 + expected.radiance.x)) << trial;
    if (expected.radiance.x < 1e-6) continue;
    const double nu = exact_lights::light_bandwidth(same, expected.wi, expected.distance_m, 3.0);
    EXPECT_NEAR(shared::light_bandwidth(light, got.wi, got.distance_m, 3.0f), nu, 1e-3 * nu);
  }
}

/// The constant of a Lambertian under a point light: spectrum of (1 + r^2)^-1.5 by its Hankel transform.
TEST(LightBandwidth, LambertianUnderAPointLight) {
  const auto spectrum = [](double k) {
    double sum = 0.0;
    const double step = 0.01;
    for (double r = 0.5 * step; r < 300.0; r += step) {
      sum += std::pow(1.0 + r * r, -1.5) * std::cyl_bessel_j(0.0, k * r) * r * step;
    }
    return sum;
  };
  for (double k : {0.5, 1.0, 2.0}) EXPECT_NEAR(spectrum(k), std::exp(-k), 2e-3);
  double below = 0.0;
  double all = 0.0;
  for (double nu = 0.0005; nu < 5.0; nu += 0.001) {
    const double energy = std::exp(-4.0 * std::numbers::pi * nu) * nu;
    all += energy;
    if (nu < 0.3775) below += energy;
  }
  EXPECT_NEAR(below / all, 0.95, 1e-3);
  LightRecord light{};
  light.kind = shared::kLightPoint;
  EXPECT_NEAR(shared::light_bandwidth(light, {0, 1, 0}, 0.5f, 0.0f), 0.755f, 1e-5f);
  EXPECT_NEAR(shared::light_bandwidth(light, {0, 1, 0}, 0.5f, 8.0f), 16.0f, 1e-4f);  // the BRDF's, over the distance
}

TEST(LightBandwidth, LargeLightAndSpotPenumbra) {
  // A triangle of 2 m seen from 1 cm by a mirror: its own extent, not nu_rho / d.
  const LightRecord large = triangle({0, 0, 0}, {2, 0, 0}, {0, 0, 2});
  EXPECT_NEAR(shared::light_bandwidth(large, {0, 1, 0}, 0.01f, 100.0f), 1.03f, 1e-3f);
  const LightRecord small = triangle({0, 0, 0}, {1e-4f, 0, 0}, {0, 0, 1e-4f});
  EXPECT_NEAR(shared::light_bandwidth(small, {0, 1, 0}, 2.0f, 10.0f), 5.0f, 1e-3f);
  LightRecord spot{};
  spot.kind = shared::kLightSpot;
  spot.direction = glm::vec3(0, -1, 0);
  spot.edge2 = glm::vec3(std::cos(0.5f), std::cos(0.55f), 0.0f);
  const glm::vec3 edge(std::sin(0.52f), std::cos(0.52f), 0.0f);
  const float in_penumbra = shared::light_bandwidth(spot, edge, 2.0f, 0.0f);
  EXPECT_NEAR(in_penumbra, 0.18875f + 0.5f / (0.05f * 2.0f), 0.5f);
  EXPECT_NEAR(shared::light_bandwidth(spot, {0, 1, 0}, 2.0f, 0.0f), 0.18875f, 1e-4f);
}

/// One quad (2 triangles, 1 x 1 m, facing -y), one display, one degenerate triangle, lights on nodes.
struct LitScene {
  Scene scene;
  FlatGeometry geometry;
  LitScene() {
    scene.materials.resize(3);
    scene.materials[0].emissive = glm::vec3(100.0f);
    scene.materials[2].emissive = glm::vec3(1.0f, 0.0f, 0.0f);
    scene.meshes.resize(1);
    Primitive primitive;
    primitive.material = 0;
    primitive.variant_materials[0] = 1;
    scene.meshes[0].primitives.push_back(primitive);
    scene.nodes.resize(1);
    scene.nodes[0].mesh = 0;
    geometry.positions = {{0, 2, 0}, {1, 2, 0}, {1, 2, 1}, {0, 2, 1}};
    geometry.uv0 = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    geometry.indices = {0, 1, 2, 0, 2, 3, 0, 1, 1};
    DrawItem item;
    item.node = item.mesh = item.primitive = 0;
    item.index_count = 9;
    geometry.items.push_back(item);
  }
  void add_light(const PunctualLight& light, const glm::mat4& local) {
    Node node;
    node.light = static_cast<int>(scene.lights.size());
    node.local = local;
    scene.roots.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(node);
    scene.lights.push_back(light);
  }
};

TEST(LightList, EmissiveTrianglesBecomeLights) {
  LitScene lit;
  const LightList list = build_light_list(lit.scene, lit.geometry, -1);
  ASSERT_EQ(list.lights.size(), 2u);  // the degenerate third is left out
  EXPECT_EQ(list.dropped_power, 0.0);
  for (const LightRecord& light : list.lights) {
    EXPECT_EQ(light.kind, shared::kLightTriangle);
    EXPECT_NEAR(light.selection_pdf, 0.5f, 1e-6f);
    EXPECT_EQ(light.color, glm::vec3(100.0f));
    EXPECT_EQ(light.range_m, 0.0f);
  }
  EXPECT_EQ(list.lights[1].cdf, 1.0f);
  EXPECT_TRUE(build_light_list(lit.scene, lit.geometry, 0).lights.empty());  // the variant's material is dark
  lit.scene.materials[0].double_sided = true;
  EXPECT_EQ(build_light_list(lit.scene, lit.geometry, -1).lights[0].range_m, 1.0f);
}

TEST(LightList, MeanOfTheTextureOverTheTriangle) {
  LitScene lit;
  TextureImage image;
  image.width = 32;
  image.height = 32;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      const bool white = x >= 16;
      for (int c = 0; c < 4; ++c) image.rgba.push_back(white ? 255 : 0);
    }
  }
  lit.scene.images.push_back(image);
  lit.scene.materials[0].emissive_texture.image = 0;
  const LightList list = build_light_list(lit.scene, lit.geometry, -1);
  ASSERT_EQ(list.lights.size(), 2u);
  // (0,0) (1,0) (1,1) holds three quarters of the white half's share, the other triangle a quarter.
  EXPECT_NEAR(list.lights[0].color.x, 75.0f, 1.0f);
  EXPECT_NEAR(list.lights[1].color.x, 25.0f, 1.0f);
  EXPECT_NEAR(list.lights[0].selection_pdf, 0.75f, 0.01f);
}

TEST(LightList, PunctualLightsTakeTheirNode) {
  LitScene lit;
  lit.scene.materials[0].emissive = glm::vec3(0.0f);
  PunctualLight spot;
  spot.kind = PunctualLight::Kind::spot;
  spot.intensity = 7.0f;
  spot.inner_cone_rad = 0.2f;
  spot.outer_cone_rad = 0.4f;
  glm::mat4 local(3.0f);  // rotated so that -z goes to -y, scaled by 3, moved
  local[0] = glm::vec4(3, 0, 0, 0);
  local[1] = glm::vec4(0, 0, -3, 0);
  local[2] = glm::vec4(0, 3, 0, 0);
  local[3] = glm::vec4(1, 2, 3, 1);
  lit.add_light(spot, local);
  PunctualLight dark;
  dark.intensity = 0.0f;
  lit.add_light(dark, glm::mat4(1.0f));
  PunctualLight broken;
  broken.color = glm::vec3(std::numeric_limits<float>::quiet_NaN());
  lit.add_light(broken, glm::mat4(1.0f));
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  lit.add_light(sun, glm::mat4(1.0f));
  const LightList list = build_light_list(lit.scene, lit.geometry, -1);
  ASSERT_EQ(list.lights.size(), 2u);
  EXPECT_EQ(list.lights[0].kind, shared::kLightSpot);
  EXPECT_EQ(list.lights[0].position, glm::vec3(1.0f, 2.0f, 3.0f));
  EXPECT_NEAR(glm::length(list.lights[0].direction - glm::vec3(0, -1, 0)), 0.0f, 1e-6f);
  EXPECT_EQ(list.lights[0].color, glm::vec3(7.0f));
  EXPECT_NEAR(list.lights[0].edge2.x, std::cos(0.2f), 1e-6f);
  EXPECT_EQ(list.lights[1].kind, shared::kLightDirectional);
  EXPECT_EQ(list.lights[1].direction, glm::vec3(0.0f, 0.0f, -1.0f));
  EXPECT_NEAR(list.lights[0].selection_pdf + list.lights[1].selection_pdf, 1.0f, 1e-6f);
  lit.scene.nodes[1].visible = false;
  EXPECT_EQ(build_light_list(lit.scene, lit.geometry, -1).lights.size(), 1u);
}

/// The power that selection uses is the flux that the formulas emit, for each kind of light.
TEST(LightList, SelectionFollowsTheFlux) {
  LitScene lit;
  PunctualLight spot;
  spot.kind = PunctualLight::Kind::spot;
  spot.intensity = 50.0f;
  spot.inner_cone_rad = 0.3f;
  spot.outer_cone_rad = 0.9f;
  lit.add_light(spot, glm::mat4(1.0f));
  PunctualLight point;
  point.intensity = 20.0f;
  lit.add_light(point, glm::mat4(1.0f));
  const LightList list = build_light_list(lit.scene, lit.geometry, -1);
  ASSERT_EQ(list.lights.size(), 4u);
  std::array<double, 4> flux{};
  const int count = 200000;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (std::size_t i = 0; i < 2; ++i) {  // through a sphere of 2 m around the light
    for (int k = 0; k < count; ++k) {
      const double y = 2.0 * uniform(random) - 1.0;
      const double phi = 2.0 * std::numbers::pi * uniform(random);
      const double r = std::sqrt(1.0 - y * y);
      const glm::vec3 d(r * std::cos(phi), y, r * std::sin(phi));
      const auto s = shared::light_sample(list.lights[i], list.lights[i].position + 2.0f * d, {0.5f, 0.5f});
      flux[i] += s.radiance.x * 4.0 * std::numbers::pi * 4.0 / count;
    }
  }
  flux[2] = flux[3] = std::numbers::pi * 100.0 * 0.5;
  const double all = flux[0] + flux[1] + flux[2] + flux[3];
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(list.lights[i].selection_pdf, flux[i] / all, 0.01) << i;
}

TEST(LightList, KeepsTheStrongestTrianglesAndReportsTheDroppedPower) {
  LitScene lit;
  lit.geometry = FlatGeometry{};
  for (int i = 0; i < 100; ++i) {
    const float size = std::sqrt(static_cast<float>(i + 1));
    const auto first = static_cast<std::uint32_t>(lit.geometry.positions.size());
    for (const glm::vec3& p : {glm::vec3(0, 0, 0), glm::vec3(size, 0, 0), glm::vec3(0, 0, size)}) {
      lit.geometry.positions.push_back(p);
    }
    for (std::uint32_t k : {0u, 1u, 2u}) lit.geometry.indices.push_back(first + k);
  }
  DrawItem item;
  item.node = item.mesh = item.primitive = 0;
  item.index_count = 300;
  lit.geometry.items.push_back(item);
  const LightList list = build_light_list(lit.scene, lit.geometry, -1, 10);
  ASSERT_EQ(list.lights.size(), 10u);
  EXPECT_NEAR(list.lights[0].direction.x, 10.0f, 1e-4f);
  EXPECT_NEAR(list.dropped_power, 1.0 - 955.0 / 5050.0, 1e-7);
  float before = 0.0f;
  double sum = 0.0;
  for (const LightRecord& light : list.lights) {
    EXPECT_GT(light.cdf, before);
    EXPECT_NEAR(light.cdf - before, light.selection_pdf, 1e-6f);
    before = light.cdf;
    sum += light.selection_pdf;
  }
  EXPECT_EQ(before, 1.0f);
  EXPECT_NEAR(sum, 1.0, 1e-5);
}

TEST(LightList, ScaleDoesNotChangeTheSelection) {
  for (float scale : {1e-6f, 1e6f}) {
    LitScene lit;
    for (glm::vec3& p : lit.geometry.positions) p *= scale;
    const LightList list = build_light_list(lit.scene, lit.geometry, -1);
    ASSERT_EQ(list.lights.size(), 2u);
    EXPECT_NEAR(list.lights[0].selection_pdf, 0.5f, 1e-5f);
  }
}

}  // namespace
}  // namespace maquette
