// Animations of nodes, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <random>

#include "gltf_fixture.h"

namespace maquette {
namespace {

using test::Json;

class GltfAnimations : public test::GltfFixture {
 protected:
  GltfAnimations() {
    add_quad();
    root_["nodes"] = Json::parse(R"([{"name": "arm", "children": [1], "translation": [1, 2, 3]},
                                     {"name": "hand", "mesh": 0, "scale": [2, 2, 2]}])");
  }
  int floats(const std::vector<float>& values, const char* type) {
    const int components = std::string(type) == "SCALAR" ? 1 : type[3] - '0';
    return add_accessor<float>(values, 5126, type, components);
  }
  Json& animation(const std::string& name = "open") {
    root_["animations"].push_back({{"name", name}, {"channels", Json::array()}, {"samplers", Json::array()}});
    return root_["animations"].back();
  }
  void add_channel(Json* animation, int node, const char* path, const std::vector<float>& times,
                   const std::vector<float>& values, const char* interpolation = nullptr) {
    Json sampler = {{"input", floats(times, "SCALAR")},
                    {"output", floats(values, std::string(path) == "rotation" ? "VEC4" : "VEC3")}};
    if (interpolation) sampler["interpolation"] = interpolation;
    (*animation)["channels"].push_back(
        {{"sampler", (*animation)["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
    (*animation)["samplers"].push_back(sampler);
  }
  /// Where a point of a node is in the world.
  static glm::vec3 place(Scene scene, double time_s, int node, const glm::vec3& point) {
    pose(&scene, scene.animations.at(0), time_s);
    return glm::vec3(compute_world_transforms(scene)[static_cast<std::size_t>(node)] * glm::vec4(point, 1.0f));
  }
  static void expect_near(const glm::vec3& a, const glm::vec3& b, const std::string& what = {}) {
    EXPECT_NEAR(glm::distance(a, b), 0.0f, 1e-5f) << what << a.x << " " << a.y << " " << a.z;
  }
};

TEST_F(GltfAnimations, LinearTranslationsMoveWithWhatIsBelow) {
  add_channel(&animation(), 0, "translation", {1.0f, 3.0f}, {0, 0, 0, 4, 0, 8});
  const Scene scene = load();
  ASSERT_EQ(scene.animations.size(), 1u);
  EXPECT_EQ(scene.animations[0].name, "open");
  EXPECT_DOUBLE_EQ(scene.animations[0].duration_s, 3.0);
  EXPECT_TRUE(scene.warnings.empty());
  for (const double t : {0.0, 1.0, 1.5, 2.25, 3.0, 9.0}) {
    const auto share = static_cast<float>(std::clamp((t - 1.0) / 2.0, 0.0, 1.0));
    expect_near(place(scene, t, 1, {1, 1, 0}), glm::vec3(4 * share, 0, 8 * share) + glm::vec3(2, 2, 0));
  }
}

TEST_F(GltfAnimations, StepsKeepTheirValueUntilTheNextKey) {
  add_channel(&animation(), 1, "scale", {0.0f, 1.0f, 2.0f}, {1, 1, 1, 3, 1, 1, 1, 5, 1}, "STEP");
  const Scene scene = load();
  const glm::vec3 base(1, 2, 3);
  expect_near(place(scene, 0.999, 1, {1, 1, 0}), base + glm::vec3(1, 1, 0));
  expect_near(place(scene, 1.0, 1, {1, 1, 0}), base + glm::vec3(3, 1, 0));
  expect_near(place(scene, 1.999, 1, {1, 1, 0}), base + glm::vec3(3, 1, 0));
  expect_near(place(scene, 2.0, 1, {1, 1, 0}), base + glm::vec3(1, 5, 0));
}

TEST_F(GltfAnimations, RotationsTakeTheShortWayAtAnEvenRate) {
  const float half = std::sqrt(0.5f);
  // The second quaternion is that of 90 degrees about y with the other sign.
  add_channel(&animation(), 0, "rotation", {0.0f, 1.0f}, {0, 0, 0, 1, 0, -half, 0, -half});
  const Scene scene = load();
  for (const double t : {0.0, 0.2, 0.5, 0.9, 1.0}) {
    const auto angle = static_cast<float>(t * glm::half_pi<double>());
    expect_near(place(scene, t, 0, {1, 0, 0}), glm::vec3(1 + std::cos(angle), 2, 3 - std::sin(angle)));
  }
}

/// Hermite: with the derivatives of a cubic polynomial it is that polynomial.
TEST_F(GltfAnimations, CubicSplinesAreTheirPolynomial) {
  const auto x = [](double t) { return 1.0 + 2.0 * t - 3.0 * t * t + 0.5 * t * t * t; };
  const auto slope = [](double t) { return 2.0 - 6.0 * t + 1.5 * t * t; };
  const std::vector<float> times = {0.5f, 1.0f, 3.0f};
  std::vector<float> values;
  for (const float t : times) {
    const auto d = static_cast<float>(slope(t)), v = static_cast<float>(x(t));
    values.insert(values.end(), {d, 0, 0, v, 0, 0, d, 0, 0});
  }
  add_channel(&animation(), 0, "translation", times, values, "CUBICSPLINE");
  const Scene scene = load();
  for (double t = 0.5; t <= 3.0; t += 0.125) EXPECT_NEAR(place(scene, t, 0, glm::vec3(0.0f)).x, x(t), 2e-5) << t;
  EXPECT_NEAR(place(scene, 0.0, 0, glm::vec3(0.0f)).x, x(0.5), 2e-5);
}

TEST_F(GltfAnimations, CubicRotationsStayUnit) {
  const float h = std::sqrt(0.5f);
  add_channel(&animation(), 0, "rotation", {0.0f, 2.0f},
              {0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 3, 0, 0, h, 0, 0, h, 0, 0, 0, 0}, "CUBICSPLINE");
  const Scene scene = load();
  for (double t = 0.0; t <= 2.0; t += 0.1)
    EXPECT_NEAR(glm::distance(place(scene, t, 0, {1, 0, 0}), glm::vec3(1, 2, 3)), 1.0f, 1e-5f) << t;
}

TEST_F(GltfAnimations, WhatDoesNotMoveRests) {
  add_channel(&animation(), 1, "translation", {0.0f, 1.0f}, {0, 0, 0, 0, 0, 1});
  expect_near(place(load(), 1.0, 1, {1, 0, 0}), glm::vec3(1 + 2, 2, 3 + 1), "parent and scale are those of the file");
}

TEST_F(GltfAnimations, IntegersThatStandForFractionsAreRead) {
  Json& open = animation();
  open["channels"] = Json::parse(R"([{"sampler": 0, "target": {"node": 0, "path": "rotation"}}])");
  open["samplers"].push_back({{"input", floats({0.0f}, "SCALAR")},
                              {"output", add_accessor<std::int16_t>({0, 32767, 0, 0}, 5122, "VEC4", 4, true)}});
  expect_near(place(load(), 0.0, 0, {1, 0, 0}), glm::vec3(0, 2, 3));
}

TEST_F(GltfAnimations, SavedOnesComeBack) {
  Json& open = animation();
  add_channel(&open, 0, "rotation", {0.0f, 1.0f}, {0, 0, 0, 1, 0, 1, 0, 0}, "STEP");
  add_channel(&open, 1, "translation", {0.5f, 2.0f}, {1, 0, 0, 0, 1, 0});
  add_channel(&animation("close"), 0, "translation", {0.0f}, {0, 0, 0, 1, 2, 3, 0, 0, 0}, "CUBICSPLINE");
  const Scene scene = load();
  save_glb(path("again.glb"), scene);
  const Scene again = load_gltf(path("again.glb"));
  ASSERT_EQ(again.animations.size(), 2u);
  EXPECT_EQ(again.animations[1].name, "close");
  for (const double t : {0.0, 0.7, 1.5})
    expect_near(place(again, t, 1, {1, 1, 0}), place(scene, t, 1, {1, 1, 0}), std::to_string(t));
}

TEST_F(GltfAnimations, NamesAreFoundForThemAndKeptApart) {
  for (const char* name : {"open", "", "open"}) {
    Json& one = animation(name);
    if (!*name) one.erase("name");
    add_channel(&one, 0, "translation", {0.0f}, {0, 0, 0});
  }
  const Scene scene = load();
  ASSERT_EQ(scene.animations.size(), 3u);
  EXPECT_EQ(scene.animations[1].name, "animation 2");
  EXPECT_EQ(scene.animations[2].name, "open 2");
  EXPECT_EQ(animation_index(scene, "open 2"), 2);
  EXPECT_EQ(animation_index(scene, "shut"), -1);
}

TEST_F(GltfAnimations, SkinsAndMorphTargetsAreNamed) {
  root_["nodes"][1]["skin"] = 0;
  root_["skins"] = Json::parse(R"([{"name": "sleeve", "joints": [0]}])");
  primitive()["attributes"]["JOINTS_0"] =
      add_accessor<std::uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5121, "VEC4", 4);
  primitive()["attributes"]["WEIGHTS_0"] = floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  Json& open = animation();
  add_channel(&open, 0, "translation", {0.0f}, {0, 0, 0});
  open["channels"].push_back(Json::parse(R"({"sampler": 0, "target": {"node": 1, "path": "weights"}})"));
  const Scene scene = load();
  expect_warning(scene, "joints of skin \"sleeve\" move");
  expect_warning(scene, "morph targets of node \"hand\" (1) are not animated");
  EXPECT_EQ(scene.animations.size(), 1u);
}

/// The scene is whole without them.
TEST_F(GltfAnimations, DamagedOnesAreLeftOut) {
  const Json whole = root_;
  const auto refuse = [&](const std::string& text, const std::string& fault) {
    root_["animations"] = Json::array({Json::parse(text)});
    const Scene scene = load();
    expect_warning(scene, fault);
    EXPECT_TRUE(scene.animations.empty()) << text;
    EXPECT_EQ(count_triangles(scene), 2u);
    root_ = whole;
  };
  refuse("{}", "it has no channels");
  refuse("7", "it has no channels");
  const std::string target = R"("target": {"node": 0, "path": "translation"})";
  refuse(R"({"channels": [{"sampler": 0, )" + target + "}]}", "it has no samplers");
  refuse(R"({"channels": [{"sampler": 4, )" + target + R"(}], "samplers": []})", "sampler is missing or no index");
  refuse(R"({"channels": [{"sampler": 0, )" + target + R"(}], "samplers": [{"input": 99, "output": 0}]})",
         "input is missing or no index");
  refuse(R"({"channels": [{"sampler": 0, "target": {"node": 9, "path": "scale"}}], "samplers": []})",
         "node is missing or no index");
  refuse(R"({"channels": [{"sampler": 0, "target": {"node": 0, "path": "colour"}}], "samplers": []})", "is not known");
  const auto bad = [&](const std::vector<float>& times, const std::vector<float>& values, const char* interpolation,
                       const std::string& fault) {
    add_channel(&animation(), 0, "translation", times, values, interpolation);
    const Scene scene = load();
    expect_warning(scene, fault);
    EXPECT_TRUE(scene.animations.empty());
    root_ = whole;
  };
  bad({0.0f, 1.0f}, {0, 0, 0}, nullptr, "has 1 values for 2 keys");
  bad({0.0f, 1.0f}, {0, 0, 0, 1, 1, 1}, "CUBICSPLINE", "has 2 values for 2 keys");
  bad({1.0f, 1.0f}, {0, 0, 0, 1, 1, 1}, nullptr, "do not increase");
  bad({-1.0f, 1.0f}, {0, 0, 0, 1, 1, 1}, nullptr, "do not increase");
  bad({0.0f, NAN}, {0, 0, 0, 1, 1, 1}, nullptr, "do not increase");
  bad({0.0f, 1.0f}, {0, 0, 0, 1, INFINITY, 1}, nullptr, "not finite");
  bad({0.0f, 1.0f}, {0, 0, 0, 1, 1, 1}, "QUADRATIC", "not one of STEP, LINEAR, CUBICSPLINE");
  root_["nodes"][0].erase("translation");
  root_["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  add_channel(&animation(), 0, "translation", {0.0f}, {0, 0, 0});
  expect_warning(load(), "has a matrix, which cannot be animated");
}

/// Random tracks against the definition, evaluated in the plainest way.
TEST(AnimationTracks, BetweenKeysTheyAreWhatTheirDefinitionSays) {
  std::mt19937 random(7);
  const auto real = [&](float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); };
  for (int round = 0; round < 300; ++round) {
    AnimationTrack track;
    const int keys = 1 + static_cast<int>(random() % 5);
    for (int i = 0; i < keys; ++i) {
      track.times_s.push_back((i ? track.times_s.back() : 0.0f) + real(0.01f, 2.0f));
      track.values.emplace_back(real(-1, 1), real(-1, 1), real(-1, 1), 0.0f);
    }
    for (int k = 0; k < 20; ++k) {
      const float t = real(-1.0f, 12.0f);
      glm::vec4 expected = t < track.times_s.front() ? track.values.front() : track.values.back();
      for (int i = 0; i + 1 < keys; ++i) {
        const auto a = static_cast<std::size_t>(i);
        if (t < track.times_s[a] || t >= track.times_s[a + 1]) continue;
        const float share = (t - track.times_s[a]) / (track.times_s[a + 1] - track.times_s[a]);
        expected = track.values[a] * (1.0f - share) + track.values[a + 1] * share;
      }
      EXPECT_LT(glm::distance(value_at(track, false, static_cast<double>(t)), expected), 1e-5f);
    }
  }
}

}  // namespace
}  // namespace maquette
