// The outside of the car: the skin is smooth where it should be, and gaps have the right width.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "scenes/angles.h"
#include "scenes/cockpit_surface.h"
#include "scenes/scene.h"
#include "scenes/subdivision.h"

namespace maquette {
namespace {

using builtin::car_body;
using builtin::hood_outline;
using builtin::skin_normal;
using modelling::Vec3;

/// Intersection of the skin with the line from `outside` along `inwards`.
Vec3 skin_from(const Vec3& outside, const Vec3& inwards, double length) {
  double a = 0.0, b = length;
  while (b - a > 1e-9) {
    const double middle = 0.5 * (a + b);
    (car_body(outside + middle * inwards) > 0.0 ? a : b) = middle;
  }
  return outside + a * inwards;
}

const Primitive& part(const Scene& scene, const std::string& name) {
  for (const Node& node : scene.nodes)
    if (node.name == name) return scene.meshes.at(static_cast<std::size_t>(node.mesh)).primitives.at(0);
  throw std::runtime_error(name);
}

/// Height of the highest point of `surface` above (x, z); -infinity where it has none.
double height_over(const Primitive& surface, double x, double z) {
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 2 < surface.indices.size(); i += 3) {
    Vec3 p[3]{};
    for (std::size_t k = 0; k < 3; ++k) p[k] = Vec3(surface.positions[surface.indices[i + k]]);
    const auto area = [](double ax, double az, double bx, double bz) { return ax * bz - az * bx; };
    const double whole = area(p[1].x - p[0].x, p[1].z - p[0].z, p[2].x - p[0].x, p[2].z - p[0].z);
    if (std::abs(whole) < 1e-14) continue;
    const double u = area(x - p[0].x, z - p[0].z, p[2].x - p[0].x, p[2].z - p[0].z) / whole;
    const double v = area(p[1].x - p[0].x, p[1].z - p[0].z, x - p[0].x, z - p[0].z) / whole;
    if (u < 0.0 || v < 0.0 || u + v > 1.0) continue;
    highest = std::max(highest, p[0].y + u * (p[1].y - p[0].y) + v * (p[2].y - p[0].y));
  }
  return highest;
}

TEST(CockpitBody, TheTailIsSmoothFromSillToDeck) {
  // Change of the skin's normal within 2 mm: a few degrees where it is rounded, more only in a crease.
  for (double x = 0.0; x < 0.65; x += 0.05) {
    Vec3 last(0.0);
    for (double y = 0.45; y < 0.94; y += 0.002) {
      const Vec3 n = skin_normal(skin_from({x, y, -2.5}, {0.0, 0.0, 1.0}, 0.8));
      const double turn = y > 0.45 ? glm::dot(n, last) : 1.0;
      EXPECT_GT(turn, std::cos(radians(2.5))) << x << ' ' << y;
      last = n;
    }
  }
}

TEST(CockpitBody, BonnetAndWingsAreApart) {
  const Scene scene = build_builtin_scene("cockpit");
  const auto outline = [](const glm::vec3& p) { return hood_outline({std::abs(p.x), p.y, p.z}); };
  // Only the visible parts: their rims continue below the skin.
  const auto shows = [](const glm::vec3& p) { return p.z > 1.0f && p.y > 0.55f && car_body(Vec3(p)) > -0.0034; };
  double bonnet = -1.0, around = 1.0;
  for (const glm::vec3& p : part(scene, "hood").positions)
    if (shows(p)) bonnet = std::max(bonnet, outline(p));
  for (const char* name : {"body", "front_bumper"})
    for (const glm::vec3& p : part(scene, name).positions)
      if (shows(p)) around = std::min(around, outline(p));
  EXPECT_GT(around - bonnet, 0.0025);
  EXPECT_LT(around - bonnet, 0.0060);
}

TEST(CockpitBody, NothingGapesBetweenBonnetAndWindshield) {
  const Scene scene = build_builtin_scene("cockpit");
  ASSERT_EQ(scene.patches.at(0).name, "windshield");
  const Primitive pane = tessellate_patch(scene.patches[0], 24);
  for (const double x : {0.0, 0.2, -0.35, 0.5}) {
    for (double z = 0.60; z < 0.90; z += 0.01) {
      const double skin = skin_from({x, 2.0, z}, {0.0, -1.0, 0.0}, 1.6).y;
      double highest = height_over(pane, x, z);
      for (const char* name : {"hood", "body", "windshield_border", "scuttle"})
        highest = std::max(highest, height_over(part(scene, name), x, z));
      EXPECT_GT(highest, skin - 0.025) << x << ' ' << z;
    }
  }
}

}  // namespace
}  // namespace maquette
