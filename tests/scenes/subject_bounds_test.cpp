#include "scenes/subject_bounds.h"

#include <gtest/gtest.h>

#include <random>

#include "scenes/modelling.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// Bodies of about 1 m around the origin.
Scene bodies(int count) {
  Scene scene;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-1.0f, 1.0f);
  for (int i = 0; i < count; ++i) {
    Primitive body = modelling::make_sphere(0.3, 2);
    const glm::vec3 at(place(random), place(random), place(random));
    for (glm::vec3& p : body.positions) p += at;
    test::add(&scene, body);
  }
  return scene;
}

Primitive triangle(const glm::vec3& at, float size) {
  Primitive p;
  p.positions = {at, at + glm::vec3(size, 0.0f, 0.0f), at + glm::vec3(0.0f, size, 0.0f)};
  p.indices = {0, 1, 2};
  return p;
}

void expect_same(const Bounds& a, const Bounds& b, const std::string& what) {
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(a.min[c], b.min[c]) << what;
    EXPECT_FLOAT_EQ(a.max[c], b.max[c]) << what;
  }
}

TEST(SubjectBounds, AreThoseOfAllWithoutFarPieces) {
  for (const int count : {1, 2, 5, 40}) {
    const Scene scene = bodies(count);
    expect_same(subject_bounds(scene), compute_bounds(scene), std::to_string(count));
  }
  EXPECT_TRUE(subject_bounds(Scene()).empty());
  const Scene cockpit = load_scene("builtin:cockpit");
  expect_same(subject_bounds(cockpit), compute_bounds(cockpit), "cockpit");
}

TEST(SubjectBounds, ADomeAndAStrayTriangleDoNotCount) {
  for (const int count : {1, 2, 5, 40}) {
    const Bounds expected = compute_bounds(bodies(count));
    for (const double radius : {100.0, 5000.0, 1e5})
      for (const int fineness : {2, 5}) {
        Scene scene = bodies(count);
        test::add(&scene, modelling::make_sphere(radius, fineness));
        expect_same(subject_bounds(scene), expected, "dome of " + std::to_string(radius));
      }
    for (const float far : {60.0f, 65000.0f}) {
      Scene scene = bodies(count);
      test::add(&scene, triangle(glm::vec3(far, 0.1f * far, 0.0f), 1.0f));
      expect_same(subject_bounds(scene), expected, "triangle at " + std::to_string(far));
    }
  }
}

TEST(SubjectBounds, AStrayTriangleOfABodyDoesNotCount) {
  Scene scene = bodies(3);
  const Bounds expected = compute_bounds(scene);
  Primitive& body = scene.meshes[1].primitives[0];
  const auto first = static_cast<std::uint32_t>(body.positions.size());
  for (const glm::vec3& p : triangle({0.0f, -900.0f, 0.0f}, 1.0f).positions) body.positions.push_back(p);
  body.indices.insert(body.indices.end(), {first, first + 1, first + 2});
  expect_same(subject_bounds(scene), expected, "stray");
}

TEST(SubjectBounds, ARoomAndALandscapeCount) {
  Scene room = bodies(6);
  test::add(&room, modelling::make_sphere(8.0, 3));
  expect_same(subject_bounds(room), compute_bounds(room), "room");
  Scene trees = bodies(6);  // as many are far as near
  for (int i = 0; i < 6; ++i) test::add(&trees, triangle({300.0f + 10.0f * static_cast<float>(i), 0.0f, 0.0f}, 1.0f));
  expect_same(subject_bounds(trees), compute_bounds(trees), "trees");
}

class FarScenes : public test::TemporaryFolder {};

TEST_F(FarScenes, AreSaidToBe) {
  for (const auto& [distance_m, far] : {std::pair(0.0f, false), {500.0f, false}, {65000.0f, true}}) {
    Scene scene;
    scene.materials = {test::matte(glm::vec3(0.5f))};
    test::add(&scene, test::make_grid({-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, 4, 0));
    scene.nodes[0].local[3] = {distance_m, 0.0f, 0.0f, 1.0f};
    save_glb(path("a.glb"), scene);
    std::string all;
    for (const std::string& warning : load_scene(path("a.glb")).warnings) all += warning + "\n";
    EXPECT_EQ(all.find("km from the origin") != std::string::npos, far) << distance_m << ": " << all;
  }
}

}  // namespace
}  // namespace maquette
