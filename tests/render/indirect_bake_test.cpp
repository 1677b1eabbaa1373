#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "render/bake/bake_runner.h"
#include "render/indirect/indirect_kind.h"
#include "render/indirect/indirect_light.h"
#include "render/math/shared_formulas.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace maquette;
using test::matte;

const std::atomic<bool> kGoOn{false};

std::shared_ptr<Environment> make_sky(int width, int height, const std::function<glm::vec3(double, double)>& f) {
  auto sky = std::make_shared<Environment>();
  sky->width = width;
  sky->height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      sky->rgb.push_back(f(std::numbers::pi - 2.0 * std::numbers::pi * (x + 0.5) / width,
                           std::numbers::pi / 2 - std::numbers::pi * (y + 0.5) / height));
  return sky;
}

void add_mesh(Scene* scene, Primitive primitive, const Material& material) {
  primitive.material = static_cast<int>(scene->materials.size());
  scene->materials.push_back(material);
  Mesh mesh;
  mesh.primitives.push_back(std::move(primitive));
  Node node;
  node.mesh = static_cast<int>(scene->meshes.size());
  scene->meshes.push_back(std::move(mesh));
  scene->roots.push_back(static_cast<int>(scene->nodes.size()));
  scene->nodes.push_back(node);
}

/// Grid of (n + 1)^2 vertices; the front face follows from position and normal.
Primitive lattice(int n, const std::function<glm::vec3(float, float)>& position,
                  const std::function<glm::vec3(const glm::vec3&)>& normal) {
  Primitive p;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      p.positions.push_back(
          position(static_cast<float>(i) / static_cast<float>(n), static_cast<float>(j) / static_cast<float>(n)));
      p.normals.push_back(normal(p.positions.back()));
    }
  const auto row = static_cast<std::uint32_t>(n + 1);
  for (std::uint32_t j = 0; j + 1 < row; ++j)
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      const std::uint32_t a = j * row + i, b = a + 1, c = a + row, d = c + 1;
      p.indices.insert(p.indices.end(), {a, c, b, b, c, d});
    }
  return p;
}

/// Inside of the lower half of the unit sphere.
Scene bowl(float albedo) {
  Scene scene;
  const auto at = [](float u, float v) {
    const float phi = 6.28318531f * u, theta = 1.57079633f * v;
    return glm::vec3(std::sin(theta) * std::cos(phi), -std::cos(theta), std::sin(theta) * std::sin(phi));
  };
  add_mesh(&scene, lattice(40, at, [](const glm::vec3& p) { return -p; }), matte(glm::vec3(albedo)));
  return scene;
}

struct Baked {
  std::shared_ptr<IndirectInput> input;
  std::shared_ptr<const VisibilityBake> visibility;
  std::shared_ptr<const IndirectLinks> links;
};

Baked bake(const Scene& scene, std::size_t budget = 1 << 18) {
  Baked b;
  b.input = std::make_shared<IndirectInput>();
  b.input->scene = scene;
  b.input->geometry = std::make_shared<FlatGeometry>(flatten(scene));
  b.input->transmits.assign(b.input->geometry->items.size(), false);
  b.input->measured_albedo.resize(scene.materials.size());
  b.input->measured_hash.assign(scene.materials.size(), 0);
  b.visibility = std::make_shared<VisibilityBake>(*bake_visibility(*b.input->geometry, b.input->transmits, {}, kGoOn));
  b.links = trace_indirect_links(*b.input, budget, kGoOn);
  return b;
}

std::vector<IndirectRadiance> solve(const Baked& b, const IndirectSky& sky) {
  return solve_indirect(*b.links, *b.visibility, sky, IndirectBounces::all, nullptr, kGoOn)->radiance;
}

/// In a spherical cavity every point illuminates all others equally. Under a constant sky of radiance L the open half
/// gives pi L / 2, and the other half of what a point sees is the bowl itself: E = (pi L / 2) / (1 - rho / 2). Source:
/// the integrating sphere; Jacquez and Kuppenheim 1955, "Theory of the Integrating Sphere".
TEST(IndirectBake, BowlUnderAConstantSkyIsAnIntegratingSphere) {
  const auto sky = make_sky(64, 32, [](double, double) { return glm::vec3(2.0f); });
  for (const float rho : {0.3f, 0.8f}) {
    const Baked b = bake(bowl(rho));
    const auto radiance = solve(b, {sky, 0.4f, 1.5f});
    const double direct = std::numbers::pi * 2.0 * 1.5 / 2.0, expected = direct * 0.5 * rho / (1.0 - 0.5 * rho);
    double mean = 0.0, square = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < b.links->points.points.size(); ++i) {
      if (b.links->points.points[i].position.y > 0.1f) continue;  // vertices on the rim see only half of the bowl
      const double e = std::numbers::pi * static_cast<double>(radiance[i].mean.x);
      mean += e;
      square += (e / expected - 1.0) * (e / expected - 1.0);
      ++count;
    }
    ASSERT_GT(count, 800u);
    // The facets of the bowl and the 256 directions of the sky cause errors of up to 2 %.
    EXPECT_NEAR(mean / static_cast<double>(count) / expected, 1.0, 0.03) << rho;
    EXPECT_LT(std::sqrt(square / static_cast<double>(count)), 0.04) << rho;
  }
}

/// The same bowl with its front outside: its inside is lit as well, though its material is single-sided, because that
/// is what the reference shows.
TEST(IndirectBake, BacksThatAreSeenReflectAsFrontsDo) {
  Scene scene = bowl(0.6f);
  Primitive& shell = scene.meshes[0].primitives[0];
  for (glm::vec3& n : shell.normals) n = -n;
  for (std::size_t i = 0; i + 2 < shell.indices.size(); i += 3) std::swap(shell.indices[i + 1], shell.indices[i + 2]);
  const Baked b = bake(scene);
  ASSERT_EQ(b.links->sides, 2);
  const auto radiance = solve(b, {make_sky(64, 32, [](double, double) { return glm::vec3(2.0f); }), 0.0f, 1.0f});
  const double expected = std::numbers::pi * 0.5 * 0.6 / (1.0 - 0.5 * 0.6) * 2.0 / 2.0;
  const std::size_t points = b.links->points.points.size();
  double mean = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < points; ++i) {
    if (b.links->points.points[i].position.y > 0.1f) continue;
    mean += std::numbers::pi * static_cast<double>(radiance[points + i].mean.x);
    ++count;
  }
  ASSERT_GT(count, 800u);
  EXPECT_NEAR(mean / static_cast<double>(count) / expected, 1.0, 0.03);
}

TEST(IndirectBake, BacksInsideClosedBodiesAreLeftOut) {
  Scene scene = bowl(0.6f);
  Material body = matte(glm::vec3(0.5f));
  const auto at = [](float u, float v) {
    const float phi = 6.28318531f * u, theta = 3.14159265f * v;
    return glm::vec3(0.0f, -0.5f, 0.0f) +
           0.2f * glm::vec3(std::sin(theta) * std::cos(phi), -std::cos(theta), std::sin(theta) * std::sin(phi));
  };
  add_mesh(&scene, lattice(16, at, [](const glm::vec3& p) { return glm::normalize(p - glm::vec3(0, -0.5f, 0)); }),
           body);
  EXPECT_EQ(bake(scene).links->sides, 1);
}

TEST(IndirectBake, NothingIsAddedWhereNothingIsSeen) {
  Scene scene;
  add_mesh(&scene,
           lattice(
               8, [](float u, float v) { return glm::vec3(u, 0.0f, v); },
               [](const glm::vec3&) { return glm::vec3(0, 1, 0); }),
           matte(glm::vec3(0.9f)));
  const auto radiance =
      solve(bake(scene), {make_sky(32, 16, [](double, double) { return glm::vec3(5.0f); }), 0.0f, 1.0f});
  for (const IndirectRadiance& r : radiance) EXPECT_EQ(r.mean, glm::vec3(0.0f));
}

/// Floor in front of a red wall that a sun illuminates: red light, from the direction of the wall.
Scene corner() {
  Scene scene;
  add_mesh(&scene,
           lattice(
               24, [](float u, float v) { return glm::vec3(u, 0.0f, v); },
               [](const glm::vec3&) { return glm::vec3(0, 1, 0); }),
           matte(glm::vec3(0.2f)));
  // x = 0, its front towards +x.
  add_mesh(&scene,
           lattice(
               24, [](float u, float v) { return glm::vec3(0.0f, u, v); },
               [](const glm::vec3&) { return glm::vec3(1, 0, 0); }),
           matte(glm::vec3(0.9f, 0.1f, 0.0f)));
  return scene;
}

std::shared_ptr<Environment> sun_at(double longitude, double latitude) {
  return make_sky(256, 128, [=](double lon, double lat) {
    double away = std::abs(lon - longitude);
    away = std::min(away, 2.0 * std::numbers::pi - away);
    return glm::vec3(away < 0.03 && std::abs(lat - latitude) < 0.03 ? 1e4f : 0.0f);
  });
}

TEST(IndirectBake, LightComesFromTheSunlitWall) {
  const Baked b = bake(corner());
  // atan2(x, z) = pi/2 is +x; the sun 30 degrees above it lights the wall and the floor.
  const auto radiance = solve(b, {sun_at(std::numbers::pi / 2, 0.5), 0.0f, 1.0f});
  double reds = 0.0, others = 0.0, along = 0.0;
  for (std::size_t i = 0; i < b.links->points.points.size(); ++i) {
    const VisibilityPoint& p = b.links->points.points[i];
    if (p.normal.y < 0.5f) continue;
    reds += static_cast<double>(radiance[i].mean.x);
    others += static_cast<double>(radiance[i].mean.z);
    along += static_cast<double>(radiance[i].gradient[0].x);
    EXPECT_NEAR(radiance[i].gradient[0].y, 0.0f, 1e-4f * radiance[i].mean.x + 1e-6f);
  }
  EXPECT_GT(reds, 0.0);
  EXPECT_LT(others, 1e-3 * reds);
  EXPECT_LT(along, -0.5 * reds);  // towards -x, where the wall is
}

TEST(IndirectBake, RotatingTheSkyNeedsNoRays) {
  const Baked b = bake(corner());
  const double turn = 2.0 * std::numbers::pi / 256 * 29;  // whole texels
  const auto turned = solve(b, {sun_at(std::numbers::pi / 2 - turn, 0.5), static_cast<float>(turn), 1.0f});
  const auto there = solve(b, {sun_at(std::numbers::pi / 2, 0.5), 0.0f, 1.0f});
  double difference = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < there.size(); ++i) {
    difference += static_cast<double>(std::abs(turned[i].mean.x - there[i].mean.x));
    sum += static_cast<double>(there[i].mean.x);
  }
  EXPECT_GT(sum, 0.0);
  EXPECT_LT(difference, 0.03 * sum);
}

/// One bounce at a time, each under a different sky: after the last sky has stayed for some bounces the light equals
/// the full solution for it, without what shadow rays add at rest.
TEST(IndirectBake, StepsFollowARotatingSky) {
  const Baked b = bake(bowl(0.8f));
  IndirectLinks links = *b.links;
  links.scene = nullptr;
  const auto sky = sun_at(std::numbers::pi / 2, 0.9);
  const auto solved = [&](float rotation_rad) {
    return *solve_indirect(links, *b.visibility, {sky, rotation_rad, 1.0f}, IndirectBounces::all, nullptr, kGoOn);
  };
  const auto difference = [](const IndirectSolution& one, const IndirectSolution& other) {
    double apart = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < one.radiance.size(); ++i) {
      apart += static_cast<double>(std::abs(one.radiance[i].mean.x - other.radiance[i].mean.x));
      sum += static_cast<double>(other.radiance[i].mean.x);
    }
    return apart / sum;
  };
  const IndirectSolution start = solved(0.0f), end = solved(0.6f);
  IndirectSolution s = start;
  const auto step = [&](float rotation_rad) {
    s = *solve_indirect(links, *b.visibility, {sky, rotation_rad, 1.0f}, IndirectBounces::step, &s, kGoOn);
  };
  for (int k = 1; k <= 3; ++k) step(0.2f * static_cast<float>(k));
  EXPECT_LT(difference(s, end), 0.2 * difference(start, end));
  for (int k = 0; k < 12; ++k) step(0.6f);
  EXPECT_LT(difference(s, end), 2e-3);
}

/// The shadow's edge of a sheet at 1 m over a floor, under a sun that is smaller than a cell of the maps.
TEST(IndirectBake, RaysToTheSkyFindWhatMapsMiss) {
  Scene scene;
  const auto flat = [](float height, glm::vec2 from, glm::vec2 to) {
    return [=](float u, float v) { return glm::vec3(glm::mix(from.x, to.x, u), height, glm::mix(from.y, to.y, v)); };
  };
  const auto up = [](const glm::vec3&) { return glm::vec3(0.0f, 1.0f, 0.0f); };
  add_mesh(&scene, lattice(30, flat(0.0f, {-0.5f, -0.5f}, {0.5f, 0.5f}), up), matte(glm::vec3(0.5f)));
  add_mesh(&scene, lattice(1, flat(1.0f, {-90.0f, -90.0f}, {0.5f, 90.0f}), up), matte(glm::vec3(0.5f)));
  const Baked b = bake(scene);
  constexpr double kLongitude = 1.9, kLatitude = 1.05;
  const auto sky = sun_at(kLongitude, kLatitude);
  const auto irradiance = [&](SkyLight by) {
    return sky_irradiance(*b.links, *b.visibility, {sky, 0.0f, 1.0f}, by, kGoOn);
  };
  const std::vector<glm::vec3> by_maps = irradiance(SkyLight::maps), by_rays = irradiance(SkyLight::rays);
  // Between the sheet's edge and the floor's points lies the sun where they are lit.
  const double run = std::sin(kLongitude) / std::tan(kLatitude);
  double lit = 0.0, maps_off = 0.0, rays_off = 0.0;
  int points = 0;
  for (std::size_t i = 0; i < b.links->points.points.size(); ++i) {
    const IndirectStart start = indirect_start(*b.links, i, 0);
    const double beyond = static_cast<double>(start.origin.x) + run - 0.5;
    // Next to the edge the sun is seen in part, and rays are smoothed over neighbours.
    if (start.origin.y > 0.5f || std::abs(beyond) < 0.12) continue;
    if (beyond > 0.0 && lit == 0.0) lit = static_cast<double>(by_rays[i].x);
    const double expected = beyond > 0.0 ? lit : 0.0;
    maps_off += std::abs(static_cast<double>(by_maps[i].x) - expected);
    rays_off += std::abs(static_cast<double>(by_rays[i].x) - expected);
    ++points;
  }
  EXPECT_GT(lit, 0.0);
  EXPECT_LT(rays_off, 0.02 * lit * points);
  EXPECT_GT(maps_off, 3.0 * rays_off);
}

/// The sky is summed in blocks of texels; summing single texels gives the same cells.
TEST(IndirectBake, BlocksOfTexelsAreTheSky) {
  const auto sky = make_sky(1024, 512, [](double lon, double lat) {
    return glm::vec3(lat > 0.0 && std::abs(lon - 0.7) < 0.004 && std::abs(lat - 0.5) < 0.004 ? 5e4f : 1.0f,
                     static_cast<float>(1.0 + 0.5 * std::sin(3.0 * lon) * std::cos(lat)), 0.3f);
  });
  const IndirectSky turned{sky, 0.37f, 2.0f};
  std::vector<glm::dvec3> irradiance(256, glm::dvec3(0.0));
  glm::dvec3 total(0.0);
  for (int y = 0; y < sky->height; ++y) {
    const double solid_angle =
        2.0 * std::numbers::pi / sky->width *
        (std::cos(std::numbers::pi * y / sky->height) - std::cos(std::numbers::pi * (y + 1) / sky->height));
    for (int x = 0; x < sky->width; ++x) {
      const glm::dvec3 light =
          2.0 * solid_angle * glm::dvec3(sky->rgb[static_cast<std::size_t>(y) * 1024u + static_cast<std::size_t>(x)]);
      const glm::vec2 uv((static_cast<float>(x) + 0.5f) / 1024.0f, (static_cast<float>(y) + 0.5f) / 512.0f);
      const glm::vec3 d =
          shared::latlong_rotate(shared::direction_from_latlong_uv(uv), std::cos(0.37f), std::sin(0.37f));
      const shared::VisibilityCorner corner = shared::visibility_corner(d);
      for (int k = 0; k < 4; ++k) {
        const glm::ivec2 cell = shared::visibility_wrap(corner.lower + glm::ivec2(k & 1, k >> 1));
        const float w = (k & 1 ? corner.fraction.x : 1.0f - corner.fraction.x) *
                        (k & 2 ? corner.fraction.y : 1.0f - corner.fraction.y);
        irradiance[static_cast<std::size_t>(cell.y * 16 + cell.x)] += static_cast<double>(w) * light;
      }
      total += light;
    }
  }
  const SkyCells cells = splat_sky(turned);
  for (std::size_t i = 0; i < 256; ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(static_cast<double>(cells.irradiance[i][c]), irradiance[i][c],
                  0.01 * irradiance[i][c] + 1e-5 * total[c])
          << i;
}

TEST(IndirectBake, SameAtAnyThreadCountAndFiniteUnderASun) {
  const Baked b = bake(corner(), 1 << 16), again = bake(corner(), 1 << 16);
  auto sky = make_sky(64, 32, [](double lon, double lat) {
    return glm::vec3(lon > 1.5 && lon < 1.6 && lat > 0.4 && lat < 0.5 ? 1e6f : 1.0f);
  });
  const IndirectBake one = pack_indirect(*b.links, solve(b, {sky, 0.0f, 1e6f}));
  const IndirectBake two = pack_indirect(*again.links, solve(again, {sky, 0.0f, 1e6f}));
  EXPECT_EQ(one.vertices, two.vertices);
  double largest = 0.0;
  for (const glm::uvec4& words : one.vertices) {
    const shared::IndirectLight light = shared::unpack_indirect(words, one.bias);
    for (int c = 0; c < 3; ++c) {
      ASSERT_TRUE(std::isfinite(light.mean[c]) && std::isfinite(light.red[c]) && std::isfinite(light.blue[c]));
      ASSERT_GE(light.mean[c], 0.0f);
    }
    largest = std::max(largest, static_cast<double>(light.mean.x));
  }
  EXPECT_GT(largest, 1e6);
}

/// Error of the linear radiance against the rays that it was fitted to: irradiance for normals that a normal map tilts
/// by 30 degrees.
TEST(IndirectBake, TiltedNormalsAreAccurate) {
  const Baked b = bake(corner(), 1 << 19);
  const auto radiance = solve(b, {sun_at(std::numbers::pi / 2, 0.5), 0.0f, 1.0f});
  double constant = 0.0, linear = 0.0, sum = 0.0;
  const std::size_t rays = static_cast<std::size_t>(b.links->rays);
  for (std::size_t i = 0; i < b.links->points.points.size(); ++i) {
    const VisibilityPoint& p = b.links->points.points[i];
    if (p.normal.y < 0.5f || p.position.x > 0.3f) continue;
    const IndirectFrame frame = indirect_frame(p, i, 0);
    for (int k = 0; k < 8; ++k) {
      const double phi = k * std::numbers::pi / 4.0;
      const glm::vec3 n(0.5f * static_cast<float>(std::cos(phi)), 0.8660254f, 0.5f * static_cast<float>(std::sin(phi)));
      // Irradiance / pi by the rays, which are cosine-distributed about p.normal. Only the wall reflects light, and
      // uniformly enough to use its mean.
      double truth = 0.0;
      for (std::size_t r = 0; r < rays; ++r) {
        const glm::vec3 w = frame.to_world(indirect_ray_direction(static_cast<int>(r), static_cast<int>(rays)));
        const IndirectLink& link = b.links->links[i * rays + r];
        if (link.target == kNoPoint) continue;
        truth += static_cast<double>(std::max(glm::dot(w, n), 0.0f) / glm::dot(w, p.normal));
      }
      truth /= static_cast<double>(rays);
      double seen = 0.0;
      glm::dvec3 gradient(0.0);
      for (std::size_t r = 0; r < rays; ++r) {
        if (b.links->links[i * rays + r].target == kNoPoint) continue;
        const glm::vec3 w = frame.to_world(indirect_ray_direction(static_cast<int>(r), static_cast<int>(rays)));
        seen += 1.0 / static_cast<double>(rays);
        gradient += 4.0 / static_cast<double>(rays) *
                    (glm::dvec3(w) - glm::dvec3(p.normal) * static_cast<double>(glm::dot(w, p.normal)));
      }
      const double with = std::max(seen + 2.0 / 3.0 * glm::dot(gradient, glm::dvec3(n)), 0.0);
      constant += (seen - truth) * (seen - truth);
      linear += (with - truth) * (with - truth);
      sum += truth * truth;
    }
  }
  std::printf("irradiance of normals tilted by 30 degrees: constant %.3f, linear %.3f\n", std::sqrt(constant / sum),
              std::sqrt(linear / sum));
  EXPECT_LT(std::sqrt(linear / sum), 0.2);
  EXPECT_LT(linear, 0.25 * constant);
}

TEST(IndirectShared, PackingKeepsMeanAndGradient) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 mean(std::exp2(20.0f * unit(random) - 10.0f) * glm::vec3(0.3f + 0.7f * unit(random), 1.0f, 0.5f));
    const auto vector = [&] { return glm::vec3(unit(random), unit(random), unit(random)) * 2.0f - 1.0f; };
    const glm::vec3 red = vector() * mean.x, green = vector() * mean.y, blue = vector() * mean.z;
    const auto light = shared::unpack_indirect(shared::pack_indirect(mean, red, green, blue, 28), 28);
    EXPECT_NEAR(light.mean.y / mean.y, 1.0f, 2e-3f);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(light.green[c] / mean.y, green[c] / mean.y, 6e-3f);
      EXPECT_NEAR(light.red[c] / mean.x, red[c] / mean.x, 1.2e-2f);
    }
  }
  const auto cut =
      shared::unpack_indirect(shared::pack_indirect(glm::vec3(1.0f), {9, 0, 0}, {0, 0, 0}, {0, -9, 0}, 24), 24);
  EXPECT_NEAR(cut.red.x, 2.0f, 0.01f);
  EXPECT_NEAR(cut.blue.y, -2.0f, 0.01f);
  EXPECT_EQ(shared::unpack_indirect(glm::uvec4(0u), 5).mean, glm::vec3(0.0f));
}

TEST(IndirectKind, ARotatedSkyIsUsedAndOldSurfacesAreNot) {
  const Baked b = bake(corner(), 1 << 16), other = bake(bowl(0.5f), 1 << 16);
  BakeWorker<IndirectJob, IndirectResult> worker(std::make_shared<IndirectKind>(), IndirectKind::spares);
  const auto sky = sun_at(std::numbers::pi / 2, 0.5);
  worker.submit({b.input, b.visibility, {sky, 0.0f, 1.0f}});
  worker.wait();
  auto first = worker.take();
  ASSERT_TRUE(first);
  EXPECT_FALSE(worker.take());
  for (int k = 1; k <= 3; ++k) worker.submit({b.input, b.visibility, {sky, 0.1f * static_cast<float>(k), 1.0f}});
  worker.wait();
  auto last = worker.take();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->value->sky.rotation_rad, 0.1f * 3.0f);
  EXPECT_NE(last->value->bake.vertices, first->value->bake.vertices);
  worker.submit({b.input, b.visibility, {sky, 0.5f, 1.0f}});
  worker.submit({other.input, other.visibility, {sky, 0.5f, 1.0f}});
  worker.wait();
  last = worker.take();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->value->input, other.input);
  worker.submit({b.input, b.visibility, {sky, 0.6f, 1.0f}});
  worker.cancel();
  worker.wait();
  EXPECT_FALSE(worker.take());
}

/// By few rays and what the maps show: near the whole one, and the whole one is as without it.
TEST(IndirectKind, AFirstResultComesBeforeTheWholeOne) {
  const Baked b = bake(bowl(0.6f), 1 << 16);
  const auto sky = make_sky(64, 32, [](double, double) { return glm::vec3(2.0f); });
  const IndirectJob job{b.input, b.visibility, {sky, 0.0f, 1.0f}};
  const auto mean = [](const IndirectResult& result) {
    double sum = 0.0;
    for (const glm::uvec4& packed : result.bake.vertices)
      sum += static_cast<double>(shared::unpack_indirect(packed, result.bake.bias).mean.x);
    return sum / static_cast<double>(result.bake.vertices.size());
  };
  std::vector<IndirectResult> parts;
  IndirectKind kind;
  const auto whole = make_bake(kind, job, {kGoOn, {}, [&](const IndirectResult& part) { parts.push_back(part); }});
  ASSERT_EQ(parts.size(), 1u);
  ASSERT_TRUE(whole.complete);
  EXPECT_NE(parts[0].bake.vertices, whole.value->bake.vertices);
  EXPECT_NEAR(mean(parts[0]), mean(*whole.value), 0.05 * mean(*whole.value));
  const Baked at_once = bake(bowl(0.6f), std::size_t{1} << 24);
  EXPECT_EQ(pack_indirect(*at_once.links, solve(at_once, job.sky)).vertices, whole.value->bake.vertices);
}

}  // namespace
