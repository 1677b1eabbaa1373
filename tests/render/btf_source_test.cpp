#include "render/btf/btf_source.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <numbers>

#include "render/btf/builtin_geometry.h"
#include "render/reference/surface.h"
#include "scenes/btf/btf_file.h"
#include "scenes/btf/factorise.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "tests/support/path_scenes.h"

namespace {

using namespace maquette;
using namespace maquette::test;
namespace fs = std::filesystem;

class BtfSourceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("maquette_btf_source_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    if (const char* cache = std::getenv("MAQUETTE_CACHE")) before_ = cache;
    setenv("MAQUETTE_CACHE", (folder_ / "cache").c_str(), 1);
  }
  void TearDown() override {
    if (before_.empty())
      unsetenv("MAQUETTE_CACHE");
    else
      setenv("MAQUETTE_CACHE", before_.c_str(), 1);
    fs::remove_all(folder_);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// rho = (a + b wi.x + c wi.y, tile half, ...): differs by light's azimuth, and left from right.
  std::string store_plain(const std::function<glm::vec3(const glm::dvec3& wi, int texel)>& rho) const {
    Btf btf;
    btf.name = "plain";
    btf.width = 4;
    btf.height = 2;
    btf.components = 4;
    btf.texel_m = 0.05;  // a tile of 0.2 m x 0.1 m
    const std::vector<glm::dvec3> directions = ubo_directions();
    const BtfLights lights = make_btf_lights(directions);
    for (const glm::dvec3& view : directions) {
      std::vector<float> images;
      for (const glm::dvec3& light : directions)
        for (int t = 0; t < 8; ++t)
          for (int c = 0; c < 3; ++c) images.push_back(rho(light, t)[c]);
      btf.views.push_back(factorise_btf_view(view, lights, btf.components, &images));
    }
    complete_btf(&btf);
    save_btf(path("plain.exr"), btf);
    return path("plain.exr");
  }

  fs::path folder_;
  std::string before_;
};

TEST_F(BtfSourceTest, IsToldByName) {
  fs::create_directories(path("images"));
  for (const std::string& source :
       {std::string("builtin:btf-leather"), std::string("builtin:btf-knit@32"), path("images"),
        path("images") + "?gamma=2.2", std::string("x.btf"), std::string("x.btf?cosine=false")})
    EXPECT_TRUE(is_btf_source(source)) << source;
  for (const char* source : {"", "builtin:leather-tan", "builtin:glass", "x.binary", "none/folder"})
    EXPECT_FALSE(is_btf_source(source)) << source;
}

TEST_F(BtfSourceTest, CarriesHowItIsRead) {
  Settings settings;
  EXPECT_EQ(with_btf_reading("a.btf", settings), "a.btf");
  settings.set_from_text("btf.gamma", "2.2");
  settings.set_from_text("btf.cosine", "false");
  settings.set_from_text("btf.texel_mm", "0.1");
  settings.set_from_text("btf.components", "4");
  EXPECT_EQ(with_btf_reading("builtin:leather-tan", settings), "builtin:leather-tan");
  const std::string source = with_btf_reading("a.btf", settings);
  EXPECT_EQ(source, "a.btf?cosine=false&gamma=2.2&texel_mm=0.1&components=4");
  EXPECT_EQ(with_btf_reading(source, settings), source);
  const BtfSource parsed = parse_btf_source(source);
  EXPECT_EQ(parsed.place, "a.btf");
  EXPECT_FALSE(parsed.reading.cosine);
  EXPECT_EQ(parsed.reading.gamma, 2.2);
  EXPECT_NEAR(parsed.reading.texel_m, 1e-4, 1e-12);
  EXPECT_EQ(parsed.reading.components, 4);
  EXPECT_EQ(with_btf_reading("builtin:btf-knit", settings), "builtin:btf-knit?texel_mm=0.1&components=4");
  EXPECT_EQ(parse_btf_source("what?.btf").place, "what?.btf");
  EXPECT_THROW(parse_btf_source("a.btf?gamma=much"), UsageError);
  EXPECT_THROW(parse_btf_source("a.btf?components=99"), UsageError);
}

TEST_F(BtfSourceTest, BuiltinOnesAreKeptAndDamagedOnesMadeAgain) {
  EXPECT_THROW(load_btf("builtin:btf-lether"), UsageError);
  EXPECT_THROW(load_btf("builtin:btf-leather@2"), UsageError);
  EXPECT_THROW(load_btf("builtin:btf-leather@many"), UsageError);
  EXPECT_THROW(load_btf(path("absent.btf")), Error);
  std::vector<std::string> said;
  BtfTask task;
  task.progress = [&](const std::string& what, double) { said.push_back(what); };
  const std::shared_ptr<const Btf> made = load_btf("builtin:btf-knit@8?components=2", task);
  EXPECT_EQ(made->components, 2);
  EXPECT_EQ(said.back(), "storing btf-knit");
  said.clear();
  EXPECT_EQ(load_btf("builtin:btf-knit@8?components=2", task)->hash, made->hash);
  EXPECT_TRUE(said.empty());
  fs::path file;
  for (const fs::path& entry : fs::directory_iterator(path("cache"))) file = entry;
  fs::resize_file(file, fs::file_size(file) / 2);
  EXPECT_EQ(load_btf("builtin:btf-knit@8?components=2", task)->hash, made->hash);
  EXPECT_FALSE(said.empty());
  // A cache that cannot be written costs time only.
  setenv("MAQUETTE_CACHE", "/dev/null/none", 1);
  said.clear();
  EXPECT_EQ(load_btf("builtin:btf-knit@8?components=2", task)->hash, made->hash);
  EXPECT_NE(said.back().find("is not kept in the cache"), std::string::npos);
}

TEST_F(BtfSourceTest, TheMeanTableIsTheMeanOverTexelsAndRotations) {
  const Btf btf = *load_btf("builtin:btf-leather@16");
  const BrdfTable table = load_material_table("builtin:btf-leather@16");
  const BtfLookup all{glm::vec2(0.5f), 1.0f};
  for (const double theta : {5.0, 30.0, 60.0}) {
    const glm::dvec3 wi = direction_of_angles(theta, 0.0), wo = direction_of_angles(40.0, 130.0);
    glm::dvec3 mean(0.0);
    for (int r = 0; r < 90; ++r) {
      const glm::vec3 a(direction_of_angles(theta, 4.0 * r)), b(direction_of_angles(40.0, 130.0 + 4.0 * r));
      mean += glm::dvec3(evaluate_btf(btf, all, a, b) + evaluate_btf(btf, all, b, a)) / 180.0;
    }
    EXPECT_NEAR(evaluate_brdf(table, wi, wo).x, mean.x, 0.04 * mean.x) << theta;
    EXPECT_NEAR(evaluate_brdf(table, wi, wo).x, evaluate_brdf(table, wo, wi).x, 1e-4);
  }
  EXPECT_EQ(load_material_table("builtin:btf-leather@16").hash, table.hash);  // from the cache
}

Scene textured_quad(const glm::vec3& a, const glm::vec3& b, const std::string& source) {
  Primitive p = quad({0, 0, 0}, a, b);
  p.uvs[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};  // v runs down along -b
  Material material;
  material.measured = source;
  return scene_of(std::move(p), material);
}

TEST_F(BtfSourceTest, LiesByTangentAndMetres) {
  const std::string source = store_plain([](const glm::dvec3&, int) { return glm::vec3(0.1f); });
  const glm::vec3 right = glm::normalize(glm::vec3(1, 2, 0)), up = glm::normalize(glm::vec3(-2, 1, 0));
  for (const bool mirrored : {false, true}) {
    Scene scene = textured_quad(2.0f * right, 2.0f * up, source);
    if (mirrored)
      for (glm::vec2& uv : scene.meshes[0].primitives[0].uvs[0]) uv.x = 1.0f - uv.x;
    const auto traced =
        build_path_scene({.scene = scene, .environment = sky_of(8, 4, [](auto&) { return glm::dvec3(1.0); })});
    const glm::vec3 target = 0.5f * right + 0.4f * up;  // u = 0.25, v = 0.8
    Ray ray{target + glm::vec3(0, 0, 3), {0, 0, -1}};
    RayHit hit;
    ASSERT_TRUE(intersect(*traced, ray, RayKind::camera, 0, &hit));
    const SurfacePoint p = resolve_surface(*traced, ray, hit, {});
    EXPECT_LT(glm::length(p.t - (mirrored ? -right : right)), 1e-4f);
    EXPECT_LT(glm::length(p.b - up), 1e-4f);
    // The square of coordinates is 2 m, the tile 0.2 m x 0.1 m.
    EXPECT_LT(glm::length(p.btf.uv - glm::vec2(mirrored ? 7.5f : 2.5f, 16.0f)), 1e-3f);
    EXPECT_EQ(p.btf.footprint, 0.0f);
    RayDifferential d;
    d.origin_x = ray.origin + 0.01f * right;
    d.origin_y = ray.origin + 0.03f * up;
    d.direction_x = d.direction_y = ray.direction;
    EXPECT_NEAR(resolve_surface(*traced, ray, hit, {&d}).btf.footprint, 0.3f, 1e-3f);
  }
  Scene bare = textured_quad(right, up, source);
  bare.meshes[0].primitives[0].uvs[0].clear();
  const auto traced =
      build_path_scene({.scene = bare, .environment = sky_of(8, 4, [](auto&) { return glm::dvec3(1.0); })});
  Ray ray{0.4f * right + 0.3f * up + glm::vec3(0, 0, 3), {0, 0, -1}};
  RayHit hit;
  ASSERT_TRUE(intersect(*traced, ray, RayKind::camera, 0, &hit));
  EXPECT_EQ(resolve_surface(*traced, ray, hit, {}).btf.footprint, 1.0f);
}

/// Against quadrature of evaluate_btf: a light from one side only shows the frame of the directions.
TEST_F(BtfSourceTest, ThePathTracerIntegratesIt) {
  const std::string source = store_plain([](const glm::dvec3& wi, int texel) {
    return glm::vec3(0.15 + 0.1 * wi.x, 0.15 - 0.08 * wi.y, texel % 4 < 2 ? 0.3 : 0.05);
  });
  const Btf btf = load_factorised_btf(source);
  const glm::vec3 right = glm::normalize(glm::vec3(1, 2, 0)), up = glm::normalize(glm::vec3(-2, 1, 0));
  const auto radiance = [](const glm::dvec3& d) { return glm::dvec3(1.0 + 0.9 * d.x, 1.0 - 0.5 * d.y, 1.0); };
  const Scene scene = textured_quad(2.0f * right, 2.0f * up, source);
  const auto traced = build_path_scene({.scene = scene, .environment = sky_of(128, 64, radiance)});
  const glm::vec3 target = 0.52f * right + 0.43f * up;
  const glm::dvec3 wo = direction_of_angles(35.0, 20.0);
  const glm::vec3 to_eye = right * float(wo.x) + up * float(wo.y) + glm::vec3(0, 0, 1) * float(wo.z);
  glm::dvec3 expected(0.0);
  constexpr int kTheta = 200, kPhi = 400;
  const BtfLookup at{{0.26f * 2.0f / 0.2f, (1.0f - 0.215f) * 2.0f / 0.1f}, 0.0f};
  for (int i = 0; i < kTheta; ++i)
    for (int k = 0; k < kPhi; ++k) {
      const double z2 = (i + 0.5) / kTheta, z = std::sqrt(z2), r = std::sqrt(1.0 - z2);  // d(z^2): cosine-weighted
      const double phi = 2.0 * std::numbers::pi * (k + 0.5) / kPhi;
      const glm::dvec3 wi(r * std::cos(phi), r * std::sin(phi), z);
      const glm::dvec3 world = glm::dvec3(right) * wi.x + glm::dvec3(up) * wi.y + glm::dvec3(0, 0, 1) * wi.z;
      expected += radiance(world) * glm::dvec3(evaluate_btf(btf, at, glm::vec3(wi), glm::vec3(wo))) *
                  (std::numbers::pi / (kTheta * kPhi));
    }
  for (const Transport transport : {Transport::full, Transport::direct}) {
    PathOptions options;
    options.transport = transport;
    constexpr std::uint32_t kPaths = 1 << 13;
    glm::dvec3 found(0.0);
    for (std::uint32_t i = 0; i < kPaths; ++i)
      found += glm::dvec3(estimate_radiance(*traced, options, target + to_eye, -to_eye, 1, i)) / double(kPaths);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 0.01 * expected[c]) << c;
  }
}

}  // namespace
