#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "render/btf/builtin_geometry.h"
#include "render/btf/generate.h"
#include "scenes/error.h"
#include "scenes/luminance.h"

namespace {

using namespace maquette;

glm::dvec3 random_direction(std::mt19937* random, double least_z) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double z = least_z + (1.0 - least_z) * uniform(*random), phi = 2.0 * std::numbers::pi * uniform(*random);
  return {std::sqrt(1.0 - z * z) * std::cos(phi), std::sqrt(1.0 - z * z) * std::sin(phi), z};
}

std::vector<glm::dvec3> few_directions() {
  std::vector<glm::dvec3> directions = {{0.0, 0.0, 1.0}};
  for (const double theta : {25.0, 50.0, 75.0})
    for (int i = 0; i < 6; ++i) directions.push_back(direction_of_angles(theta, 60 * i + theta));
  return directions;
}

SmallGeometry rough_geometry(int side, float depth, std::uint32_t seed) {
  SmallGeometry g = flat_geometry(side, glm::vec3(0.7f, 0.5f, 0.2f), 0.04f, 0.4f);
  std::mt19937 random(seed);
  for (float& h : g.heights) h = -depth * std::uniform_real_distribution<float>(0.0f, 1.0f)(random);
  return g;
}

/// Walls of 45 degrees along y; the ridges lie in the base plane.
SmallGeometry v_groove(int side, float albedo) {
  SmallGeometry g = flat_geometry(side, glm::vec3(albedo));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      g.heights[g.index(x, y)] = std::abs(static_cast<float>(x) / static_cast<float>(side) - 0.5f) - 0.5f;
  return g;
}

/// Mean over the texels of a view, [light].
std::vector<glm::dvec3> mean_rho(const SmallGeometry& g, const TileRays& rays, const SmallScaleLight& light,
                                 const glm::dvec3& view) {
  const std::vector<float> images = trace_btf_view(g, rays, light, view, g.side);
  const std::size_t texels = images.size() / 3 / light.light_count();
  std::vector<glm::dvec3> means(light.light_count(), glm::dvec3(0.0));
  for (std::size_t l = 0; l < means.size(); ++l)
    for (std::size_t t = 0; t < texels; ++t)
      for (int c = 0; c < 3; ++c)
        means[l][c] += double(images[(l * texels + t) * 3 + static_cast<std::size_t>(c)]) / static_cast<double>(texels);
  return means;
}

bool hits_triangle(const glm::dvec3& o, const glm::dvec3& d, const glm::dvec3& a, const glm::dvec3& b,
                   const glm::dvec3& c, double* t) {
  const glm::dvec3 e1 = b - a, e2 = c - a, p = glm::cross(d, e2), s = o - a, q = glm::cross(s, e1);
  const double det = glm::dot(p, e1);
  if (std::abs(det) < 1e-15) return false;
  const double u = glm::dot(p, s) / det, v = glm::dot(q, d) / det;
  *t = glm::dot(q, e2) / det;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && *t > 0.0;
}

TEST(TileRays, FindWhatASearchOfAllTrianglesFinds) {
  constexpr int kSide = 8, kTiles = 2;
  const SmallGeometry g = rough_geometry(kSide, 0.2f, 3);
  const TileRays rays(g);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int found = 0, differ = 0;
  for (int i = 0; i < 600; ++i) {
    const glm::dvec3 o(uniform(random), uniform(random), 0.01);
    glm::dvec3 d = -random_direction(&random, 0.15);
    if (i % 5 == 0) d.x = 0.0;  // along an axis
    d = glm::normalize(d);
    double nearest = 1e30;
    std::uint32_t expected = TileRays::kNone;
    for (int y = -kTiles * kSide; y < (kTiles + 1) * kSide; ++y)
      for (int x = -kTiles * kSide; x < (kTiles + 1) * kSide; ++x) {
        const auto at = [&](int dx, int dy) {
          return glm::dvec3((x + dx) / double(kSide), (y + dy) / double(kSide), g.height(x + dx, y + dy));
        };
        double t;
        for (const auto& [b, c] : {std::pair{at(1, 0), at(0, 1)}, std::pair{at(0, 1), at(1, 0)}})
          if (hits_triangle(o, d, b == at(1, 0) ? at(0, 0) : at(1, 1), b, c, &t) && t < nearest) {
            nearest = t;
            expected = static_cast<std::uint32_t>(g.index(x, y));
          }
      }
    ASSERT_NE(expected, TileRays::kNone);
    ++found;
    differ += rays.first_cell(glm::vec3(o), glm::vec3(d)) == expected ? 0 : 1;
  }
  EXPECT_EQ(found, 600);
  EXPECT_LE(differ, 2);  // rays through edges
}

TEST(BtfGenerator, AFlatFieldReturnsItsReflectance) {
  const SmallGeometry g = flat_geometry(16, glm::vec3(0.4f, 0.3f, 0.1f), 0.05f, 0.4f);
  BtfGeneratorOptions options;
  options.texels = 8;
  options.components = 6;
  options.views = options.lights = few_directions();
  const Btf btf = generate_btf("flat", g, options);
  for (const glm::dvec3& wi : options.lights)
    for (const glm::dvec3& wo : options.views) {
      const float lobe = ggx_lobe(0.05f, 0.4f, {0, 0, 1}, glm::vec3(wi), glm::vec3(wo));
      const glm::vec3 rho = evaluate_btf(btf, {{0.3f, 0.7f}, 0.0f}, glm::vec3(wi), glm::vec3(wo));
      for (int c = 0; c < 3; ++c) {
        const double expected = double(g.diffuse[0][c]) / std::numbers::pi + double(lobe);
        EXPECT_NEAR(rho[c], expected, 0.01 * expected);
      }
    }
  EXPECT_EQ(btf.provenance.at("shadowed_share"), "0");
  EXPECT_NEAR(btf.views[3].figures.contrast, 0.0, 1e-4);
}

TEST(GgxLobe, IsReciprocalAndWhatTheFieldReflects) {
  std::mt19937 random(2);
  const glm::vec3 n = glm::normalize(glm::vec3(0.1f, -0.2f, 1.0f));
  for (int i = 0; i < 100; ++i) {
    const glm::vec3 wi(random_direction(&random, 0.3)), wo(random_direction(&random, 0.3));
    EXPECT_NEAR(ggx_lobe(0.04f, 0.3f, n, wi, wo), ggx_lobe(0.04f, 0.3f, n, wo, wi), 1e-6f);
  }
}

/// Lambert walls: each facet is lit, and seen, from the line up that the other ridge leaves free.
TEST(BtfGenerator, AVGrooveShadowsAndMasksAsItsClosedForm) {
  constexpr double kAlbedo = 0.6;
  const SmallGeometry g = v_groove(200, static_cast<float>(kAlbedo));
  const TileRays rays(g);
  std::mt19937 random(4);
  std::vector<glm::dvec3> lights = {{0.0, 0.0, 1.0}, direction_of_angles(60, 0), direction_of_angles(70, 90)};
  for (int i = 0; i < 7; ++i) lights.push_back(random_direction(&random, 0.25));
  SmallLightOptions direct;
  direct.gather_rays = 0;
  const SmallScaleLight light(g, rays, lights, direct);
  const auto hidden = [](double slope) { return slope > 1.0 ? (slope - 1.0) / (slope + 1.0) : 0.0; };
  for (const glm::dvec3& v : lights) {
    const std::vector<glm::dvec3> means = mean_rho(g, rays, light, v);
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const glm::dvec3& l = lights[i];
      double expected = 0.0;
      for (const double side : {1.0, -1.0}) {  // the wall that faces +x, the one that faces -x
        const double facing_l = std::max(0.0, (side * l.x + l.z) * std::sqrt(0.5));
        const double facing_v = std::max(0.0, (side * v.x + v.z) * std::sqrt(0.5));
        const double part = 1.0 - std::max(hidden(side * l.x / l.z), hidden(side * v.x / v.z));
        expected += kAlbedo / std::numbers::pi * facing_l * part * std::sqrt(0.5) * facing_v / (v.z * l.z);
      }
      EXPECT_NEAR(means[i].x, expected, 0.015 * expected + 0.002) << i;
    }
  }
}

/// Radiosity over albedo and irradiance at distances (i + 0.5) / count from the edge of two perpendicular infinite
/// walls of length 1 that are lit evenly. Kernel: d/du of the view factor of a point to a strip, (1 - s / sqrt(s^2 +
/// u^2)) / 2.
std::vector<double> groove_radiosity(double albedo, int count) {
  std::vector<double> b(static_cast<std::size_t>(count), 1.0);
  for (int iteration = 0; iteration < 60; ++iteration) {
    const std::vector<double> before = b;
    for (int i = 0; i < count; ++i) {
      const double s = (i + 0.5) / count;
      double sum = 0.5 * (1.0 - s / std::hypot(s, 1.0)) * before[static_cast<std::size_t>(i)];
      for (int k = 0; k < count; ++k) {
        const double u = (k + 0.5) / count, r = std::hypot(s, u);
        sum += 0.5 * s * u / (r * r * r) / count *
               (before[static_cast<std::size_t>(k)] - before[static_cast<std::size_t>(i)]);
      }
      b[static_cast<std::size_t>(i)] = 1.0 + albedo * sum;
    }
  }
  return b;
}

TEST(BtfGenerator, InterreflectionInAVGrooveFollowsTheViewFactors) {
  constexpr int kSide = 64;
  constexpr double kAlbedo = 0.8;
  const SmallGeometry g = v_groove(kSide, static_cast<float>(kAlbedo));
  const TileRays rays(g);
  for (const int bounces : {1, 40}) {
    SmallLightOptions options;
    options.most_bounces = bounces;
    options.gather_rays = 256;
    const SmallScaleLight light(g, rays, {{0.0, 0.0, 1.0}}, options);
    const std::vector<double> all = groove_radiosity(kAlbedo, kSide / 2);
    double difference = 0.0, total = 0.0;
    for (int x = 0; x < kSide / 2; ++x) {
      double mean = 0.0;  // of both walls, along the groove
      for (int y = 0; y < kSide; ++y)
        for (const int column : {x, kSide - 1 - x})
          mean += double(light.diffuse(static_cast<std::uint32_t>(g.index(column, y)), 0).x) / (2 * kSide);
      const int from_edge = kSide / 2 - 1 - x;
      const double s = (from_edge + 0.5) / (kSide / 2), view_factor = 0.5 * (1.0 - s / std::hypot(s, 1.0));
      const double relative = bounces == 1 ? 1.0 + kAlbedo * view_factor : all[static_cast<std::size_t>(from_edge)];
      const double expected = kAlbedo / std::numbers::pi * std::sqrt(0.5) * relative;
      EXPECT_NEAR(mean, expected, 0.015 * expected) << bounces << " bounces, " << s;
      difference += mean - expected;
      total += expected;
    }
    EXPECT_LT(std::abs(difference / total), 0.003) << bounces;
  }
}

/// Before rectification: what a cell does with light from one direction to another. After it, means over the tile.
TEST(BtfGenerator, IsReciprocal) {
  const SmallGeometry g = builtin_geometries()[0].make(64);
  const TileRays rays(g);
  const std::vector<glm::dvec3> directions = {direction_of_angles(15, 20), direction_of_angles(60, 200),
                                              direction_of_angles(70, 100), direction_of_angles(45, 330)};
  SmallLightOptions direct;
  direct.gather_rays = 0;
  const SmallScaleLight light(g, rays, directions, direct);
  int compared = 0;
  for (std::uint32_t cell = 0; cell < rays.cell_count(); cell += 7)
    for (std::size_t a = 0; a < directions.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        if (!light.lit(cell, a) || !light.lit(cell, b)) continue;
        std::vector<glm::vec3> to_a(directions.size(), glm::vec3(0.0f)), to_b(directions.size(), glm::vec3(0.0f));
        light.add_radiance(cell, glm::vec3(directions[a]), 1.0f, to_a.data());
        light.add_radiance(cell, glm::vec3(directions[b]), 1.0f, to_b.data());
        const float cos_a = glm::dot(rays.normal(cell), glm::vec3(directions[a]));
        const float cos_b = glm::dot(rays.normal(cell), glm::vec3(directions[b]));
        EXPECT_NEAR(to_a[b].x / cos_b, to_b[a].x / cos_a, 1e-4f * to_b[a].x / cos_a + 1e-6f);
        ++compared;
      }
  EXPECT_GT(compared, 500);
  // Hills with shadows that several cells resolve.
  SmallGeometry hills = flat_geometry(96, glm::vec3(0.7f, 0.5f, 0.2f), 0.04f, 0.4f);
  for (int y = 0; y < hills.side; ++y)
    for (int x = 0; x < hills.side; ++x) {
      const float u = 2.0f * std::numbers::pi_v<float> * static_cast<float>(x) / static_cast<float>(hills.side);
      const float v = 2.0f * std::numbers::pi_v<float> * static_cast<float>(y) / static_cast<float>(hills.side);
      hills.heights[hills.index(x, y)] = 0.1f * std::sin(u) * std::cos(v) + 0.04f * std::sin(2.0f * u + v);
    }
  const TileRays tile(hills);
  const SmallScaleLight all(hills, tile, directions, {});
  std::vector<std::vector<glm::dvec3>> means;
  for (const glm::dvec3& v : directions) means.push_back(mean_rho(hills, tile, all, v));
  for (std::size_t a = 0; a < directions.size(); ++a)
    for (std::size_t c = 0; c < a; ++c)
      EXPECT_NEAR(means[a][c].y, means[c][a].y, 0.01 * means[a][c].y) << a << " " << c;
}

TEST(BtfGenerator, TilesWithoutASeam) {
  constexpr int kSide = 64, kTexels = 32, kShift = 22;  // cells; a shift by whole texels
  for (const BuiltinGeometry& b : builtin_geometries()) {
    const SmallGeometry g = b.make(kSide);
    float inside = 0.0f, across = 0.0f;  // steps between neighbours
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const float step =
            std::max(std::abs(g.height(x + 1, y) - g.height(x, y)), std::abs(g.height(x, y + 1) - g.height(x, y)));
        float& largest = x + 1 == kSide || y + 1 == kSide ? across : inside;
        largest = std::max(largest, step);
      }
    EXPECT_LE(across, 1.05f * inside) << b.name;

    SmallGeometry moved = g;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        moved.heights[g.index(x, y)] = g.heights[g.index(x + kShift, y + kShift)];
        moved.diffuse[g.index(x, y)] = g.diffuse[g.index(x + kShift, y + kShift)];
        moved.specular[g.index(x, y)] = g.specular[g.index(x + kShift, y + kShift)];
      }
    const std::vector<glm::dvec3> lights = {direction_of_angles(60, 30), direction_of_angles(30, 200)};
    SmallLightOptions direct;
    direct.gather_rays = 0;
    const TileRays rays(g), moved_rays(moved);
    const SmallScaleLight light(g, rays, lights, direct), moved_light(moved, moved_rays, lights, direct);
    const glm::dvec3 view = direction_of_angles(75, 250);
    const std::vector<float> image = trace_btf_view(g, rays, light, view, kTexels);
    const std::vector<float> other = trace_btf_view(moved, moved_rays, moved_light, view, kTexels);
    constexpr int kTexelShift = kShift * kTexels / kSide;
    double difference = 0.0, total = 0.0;
    for (int y = 0; y < kTexels; ++y)
      for (int x = 0; x < kTexels; ++x) {
        const int from = (y - kTexelShift + kTexels) % kTexels * kTexels + (x + kTexelShift) % kTexels;  // rows go down
        const float a = image[static_cast<std::size_t>(3 * from)],
                    c = other[static_cast<std::size_t>(3 * (y * kTexels + x))];
        difference += std::abs(a - c);
        total += a;
      }
    EXPECT_LT(difference, 0.005 * total) << b.name;
  }
}

/// Albedo at most 1 for every view: light comes from the hemisphere evenly.
TEST(BtfGenerator, BuiltinOnesReflectLessThanTheyReceive) {
  for (const BuiltinGeometry& b : builtin_geometries()) {
    BtfGeneratorOptions options;
    options.texels = 32;
    options.tile_m = b.tile_m;
    options.views = options.lights = ubo_directions();
    const Btf btf = generate_btf(b.name, b.make(64), options);
    const DirectionMesh::Quadrature q = btf.view_mesh.quadrature();
    double highest = 0.0, lowest = 1.0;
    for (const glm::dvec3& wo : options.views) {
      glm::dvec3 albedo(0.0);
      for (std::size_t l = 0; l < options.lights.size(); ++l)
        albedo += q.projected[l] *
                  glm::dvec3(evaluate_btf(btf, {{0.5f, 0.5f}, 1.0f}, glm::vec3(options.lights[l]), glm::vec3(wo)));
      highest = std::max({highest, albedo.x, albedo.y, albedo.z});
      lowest = std::min({lowest, albedo.x, albedo.y, albedo.z});
    }
    EXPECT_LE(highest, 1.0) << b.name;
    EXPECT_GT(lowest, 0.01) << b.name;
    EXPECT_GT(btf.views[0].figures.contrast, 0.1) << b.name;
    EXPECT_GT(std::stod(btf.provenance.at("shadowed_share")), 0.02) << b.name;
    EXPECT_GT(btf_energy_kept(btf, 8), btf_energy_kept(btf, 2)) << b.name;
    EXPECT_GT(btf_energy_kept(btf, 8), 0.5) << b.name;
  }
}

TEST(BtfGenerator, IsTheSameTwiceAndIsCancelled) {
  BtfGeneratorOptions options;
  options.texels = 8;
  options.views = options.lights = few_directions();
  const SmallGeometry g = builtin_geometries()[1].make(16);
  EXPECT_EQ(generate_btf("a", g, options).hash, generate_btf("a", g, options).hash);
  BtfTask task;
  double last = 0.0;
  task.progress = [&](const std::string&, double share) { last = share; };
  task.cancelled = [&] { return last > 0.5; };
  EXPECT_THROW(generate_btf("a", g, options, task), Error);
  EXPECT_LT(last, 0.6);
}

}  // namespace
