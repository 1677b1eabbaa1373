#include "render/parts/parts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "render/gl/context.h"
#include "render/metrics/metrics.h"
#include "render/renderer.h"
#include "scenes/error.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// A floor and two spheres, each below a node of its own; `textured`: the right sphere.
std::shared_ptr<Scene> three_parts(bool textured = false) {
  auto scene = std::make_shared<Scene>();
  for (const glm::vec3& albedo : {glm::vec3(0.5f), glm::vec3(0.7f, 0.2f, 0.1f), glm::vec3(0.1f, 0.3f, 0.7f)}) {
    Material material = test::matte(albedo);
    material.specular = 1.0f;
    material.roughness = 0.4f;
    scene->materials.push_back(material);
  }
  if (textured) {
    scene->images.push_back(test::checkerboard());
    scene->materials[2].base_color_texture.image = 0;
  }
  test::add(scene.get(), test::make_grid({-3, -1, 3}, {6, 0, 0}, {0, 0, -6}, 4, 0), "floor");
  const Scene sphere = load_scene("builtin:sphere");
  for (int k = 0; k < 2; ++k) {
    Primitive ball = sphere.meshes[0].primitives[0];
    ball.material = 1 + k;
    if (textured) {
      ball.uvs[0].clear();
      if (k == 1)
        for (const glm::vec3& at : ball.positions) ball.uvs[0].push_back({at.x, at.y});
    }
    for (glm::vec3& p : ball.positions) p = 0.8f * p + glm::vec3(k == 0 ? -1.0f : 1.0f, 0.0f, 0.0f);
    test::add(scene.get(), std::move(ball), k == 0 ? "left" : "right");
  }
  return scene;
}

FrameRequest request_for(const std::string& mode, int msaa) {
  FrameRequest r;
  r.mode = mode;
  r.width = 96;
  r.height = 64;
  r.msaa = msaa;
  r.samples = 64;
  r.camera.eye = {0.3f, 0.8f, 4.5f};
  r.settings.set("shading.visibility", std::string("none"));
  return r;
}

/// [pixel]: 0 and up: material; -1 within `border` pixels of a border between modes (or of the sky).
std::vector<int> inner_materials(const Image& points, int side, int border = 3) {
  const int w = points.width / side, h = points.height / side, reach = border * side;
  std::vector<int> inner(static_cast<std::size_t>(w * h), -1);
  for (int y = border; y < h - border; ++y)
    for (int x = border; x < w - border; ++x) {
      const int cx = x * side, cy = y * side;
      const float material = points.at(cx, cy, 0);
      bool same = true;
      for (int dy = -reach; dy < reach + side && same; ++dy)
        for (int dx = -reach; dx < reach + side && same; ++dx)
          same = points.at(cx + dx, cy + dy, 3) > 0.0f && points.at(cx + dx, cy + dy, 0) == material;
      if (same) inner[static_cast<std::size_t>(y * w + x)] = static_cast<int>(material);
    }
  return inner;
}

class PartsInAFrame : public ::testing::TestWithParam<int> {
 protected:
  static void prepare(Renderer* renderer) {
    renderer->set_scene(three_parts());
    renderer->set_environment(std::make_shared<Environment>(load_environment("builtin:clear-sky")));
  }
  GlContext context_ = GlContext::create_headless();
};

/// Away from borders each part equals the full frame of its mode, while camera and light move.
TEST_P(PartsInAFrame, EqualTheFullFramesOfTheirModes) {
  const int msaa = GetParam(), side = msaa == 4 ? 2 : 1;
  Renderer mixed, full[3];
  prepare(&mixed);
  for (Renderer& renderer : full) prepare(&renderer);
  const char* modes[] = {"splitsum", "uniform", "bandwidth"};  // of materials 0 to 2
  for (int step = 0; step < 3; ++step) {
    const auto at_step = [&](const std::string& mode) {
      FrameRequest r = request_for(mode, msaa);
      r.camera.eye.x += step > 0 ? 0.2f : 0.0f;
      r.env_rotation_rad = step > 1 ? 0.5f : 0.0f;
      return r;
    };
    FrameRequest request = at_step(modes[0]);
    request.part_modes = {{"left", modes[1]}, {"right", modes[2]}};
    const FrameStats stats = mixed.render(request);
    ASSERT_EQ(stats.plan.layers.size(), 3u);
    const Image picture = mixed.read_radiance();
    const std::vector<int> inner = inner_materials(mixed.read_debug_view("material"), side);
    for (int m = 0; m < 3; ++m) {
      full[m].render(at_step(modes[m]));
      const Image expected = full[m].read_radiance();
      double difference = 0.0, mean = 0.0;
      int count = 0;
      for (std::size_t i = 0; i < inner.size(); ++i) {
        if (inner[i] != m) continue;
        ++count;
        for (std::size_t c = 0; c < 3; ++c) {
          if (m == 0) {
            ASSERT_EQ(picture.data[4 * i + c], expected.data[4 * i + c]) << "step " << step << " pixel " << i;
          }
          difference +=
              std::abs(static_cast<double>(picture.data[4 * i + c]) - static_cast<double>(expected.data[4 * i + c]));
          mean += static_cast<double>(expected.data[4 * i + c]);
        }
      }
      EXPECT_GT(count, 150) << modes[m];
      EXPECT_LT(difference / mean, 0.04) << modes[m] << " at step " << step;
    }
  }
  EXPECT_TRUE(take_gl_errors().empty());
}

/// The prediction of a part, texture bandwidth included, is that of the full frame, away from borders by more than the
/// window of the screen curvature; other parts need no texture bandwidth.
TEST_P(PartsInAFrame, PredictTexturesLikeTheFullFrame) {
  Renderer mixed, full;
  for (Renderer* renderer : {&mixed, &full}) {
    prepare(renderer);
    renderer->set_scene(three_parts(true));
  }
  FrameRequest request = request_for("bandwidth", GetParam());
  full.render(request);
  request.mode = "uniform";
  request.part_modes = {{"right", "bandwidth"}};
  mixed.render(request);
  const Image predicted = mixed.read_debug_view("bandwidth"), expected = full.read_debug_view("bandwidth");
  const int side = predicted.width / request.width;
  const std::vector<int> inner = inner_materials(mixed.read_debug_view("material"), side, 6);
  int count = 0;
  for (std::size_t i = 0; i < inner.size(); ++i) {
    if (inner[i] != 2) continue;
    ++count;
    const int x = static_cast<int>(i) % request.width * side, y = static_cast<int>(i) / request.width * side;
    ASSERT_EQ(predicted.at(x, y, 0), expected.at(x, y, 0)) << x << ", " << y;
  }
  EXPECT_GT(count, 80);
  EXPECT_TRUE(take_gl_errors().empty());
}

/// Pictures that accumulate converge to those of the full frames.
TEST_P(PartsInAFrame, AccumulateLikeTheFullFrames) {
  const int msaa = GetParam(), side = msaa == 4 ? 2 : 1;
  Renderer mixed, full;
  prepare(&mixed);
  prepare(&full);
  FrameRequest request = request_for("uniform", msaa);
  for (int frame = 0; frame < 8; ++frame) full.render(request, true);
  request.part_modes = {{"right", "bandwidth"}, {"floor", "sg"}};
  int frames = 0;
  for (int frame = 0; frame < 8; ++frame) {
    const FrameStats stats = mixed.render(request, true);
    frames = stats.accumulated_frames;
  }
  EXPECT_EQ(frames, 8);
  const Image picture = mixed.read_radiance(), expected = full.read_radiance();
  const std::vector<int> inner = inner_materials(mixed.read_debug_view("material"), side);
  double difference[3] = {}, mean[3] = {};
  for (std::size_t i = 0; i < inner.size(); ++i) {
    if (inner[i] < 0) continue;
    difference[inner[i]] +=
        std::abs(static_cast<double>(picture.data[4 * i]) - static_cast<double>(expected.data[4 * i]));
    mean[inner[i]] += static_cast<double>(expected.data[4 * i]);
  }
  Renderer looked_up;
  prepare(&looked_up);
  looked_up.render(request_for("sg", msaa));
  const Image floor = looked_up.read_radiance();
  for (std::size_t i = 0; i < inner.size(); ++i) {
    if (inner[i] == 0) {
      ASSERT_NEAR(picture.data[4 * i], floor.data[4 * i], 2e-6f * floor.data[4 * i]) << "sg, the mean of equal frames";
    }
  }
  EXPECT_LT(difference[1] / mean[1], 0.01) << "uniform";
  EXPECT_LT(difference[2] / mean[2], 0.02) << "bandwidth";
  EXPECT_TRUE(take_gl_errors().empty());
}

INSTANTIATE_TEST_SUITE_P(Msaa, PartsInAFrame, ::testing::Values(1, 4));

/// What a mirror shows is shaded by the mode of the part that is seen: a mode that looks up has no noise.
TEST(Parts, MirrorsShowPartsInTheirModes) {
  const GlContext context = GlContext::create_headless();
  auto scene = three_parts();
  Material chrome;
  chrome.metallic = 1.0f;
  chrome.roughness = 0.0f;
  scene->materials.push_back(chrome);
  test::add(scene.get(), test::make_grid({-3, -1, -2}, {6, 0, 0}, {0, 3, 0}, 1, 3), "mirror")->reflector = true;
  const auto picture_of = [&](const std::vector<PartMode>& parts, const std::string& mode) {
    Renderer renderer;
    renderer.set_scene(scene);
    renderer.set_environment(std::make_shared<Environment>(load_environment("builtin:clear-sky")));
    FrameRequest request = request_for(mode, 1);
    request.camera.eye = {0.0f, 1.5f, 4.5f};
    request.reflections = "raytraced";
    request.settings.set("reflections.resolution", std::string("full"));
    request.part_modes = parts;
    renderer.render(request);
    return renderer.read_debug_view("reflection");
  };
  const Image looked_up = picture_of({}, "splitsum");
  const Image mixed = picture_of({{"left", "uniform"}}, "splitsum");
  const Image sampled = picture_of({}, "uniform");
  std::size_t like_first = 0, like_sampled = 0, differ = 0;
  for (std::size_t i = 0; i < mixed.data.size(); i += 4) {
    if (mixed.data[i + 3] == 0.0f || looked_up.data[i] == sampled.data[i]) continue;
    like_first += mixed.data[i] == looked_up.data[i];
    like_sampled += mixed.data[i] == sampled.data[i];
    differ += mixed.data[i] != looked_up.data[i] && mixed.data[i] != sampled.data[i];
  }
  EXPECT_GT(like_first, 100u);
  EXPECT_GT(like_sampled, 20u);
  EXPECT_EQ(differ, 0u);
}

Scene nested_nodes() {
  Scene scene;
  const auto add = [&](const std::string& name, int parent) {
    Node node;
    node.name = name;
    node.parent = parent;
    const int index = static_cast<int>(scene.nodes.size());
    if (parent < 0)
      scene.roots.push_back(index);
    else
      scene.nodes[static_cast<std::size_t>(parent)].children.push_back(index);
    scene.nodes.push_back(node);
    return index;
  };
  const int car = add("car", -1), seat = add("seat", car);
  add("cover", seat);
  const int door = add("door", car);
  add("cover", door);
  return scene;
}

/// What one part's mode cannot have takes nothing from the others.
TEST(Parts, AHeldBakeOfOneTakesNoShadowsFromTheOthers) {
  auto scene = std::make_shared<Scene>();
  scene->materials = {test::matte(glm::vec3(0.5f))};
  test::add(scene.get(), test::make_grid({-3, -1, 3}, {6, 0, 0}, {0, 0, -6}, 4, 0), "floor");
  test::add(scene.get(), test::make_grid({-1, 0, 1}, {1, 0, 0}, {0, 0, -1}, 2, 0), "left");
  for (const std::string own : {"slf", "prt"}) {
    const GlContext context = GlContext::create_headless();
    Renderer renderer;
    renderer.set_scene(scene);
    renderer.set_environment(test::constant_sky(0.5f));
    FrameRequest request = request_for("uniform", 1);
    request.settings = Settings();
    request.part_modes = {{"left", own}};
    request.settings.set(own + ".run", std::string("hold"));
    EXPECT_FALSE(renderer.finish_background_work(request)) << "the bake of " << own << " is not there";
    const FrameStatus status = renderer.render(request).status;
    EXPECT_FALSE(status.own_bakes.at(own).ready);
    EXPECT_TRUE(status.visibility.wanted && status.visibility.ready) << own;
    EXPECT_TRUE(status.indirect.wanted && status.indirect.ready) << own;
  }
}

TEST(Parts, TheNearestAncestorCounts) {
  const Scene scene = nested_nodes();
  const std::vector<std::string> modes{"a", "b", "c"};
  EXPECT_EQ(layers_of_nodes(scene, {{"seat", "b"}}, modes), (std::vector<int>{0, 1, 1, 0, 0}));
  EXPECT_EQ(layers_of_nodes(scene, {{"car", "b"}, {"car/seat", "c"}}, modes), (std::vector<int>{1, 2, 2, 1, 1}));
  EXPECT_EQ(layers_of_nodes(scene, {{"cover", "c"}}, modes), (std::vector<int>{0, 0, 2, 0, 2})) << "all of that name";
  EXPECT_EQ(layers_of_nodes(scene, {{"car/door/cover", "c"}}, modes), (std::vector<int>{0, 0, 0, 0, 2}));
  EXPECT_EQ(layers_of_nodes(scene, {{"car", "b"}, {"seat", "a"}}, modes), (std::vector<int>{1, 0, 0, 1, 1}));
  EXPECT_EQ(node_path(scene, 4), "car/door/cover");
  try {
    layers_of_nodes(scene, {{"seet", "b"}}, modes);
    FAIL() << "an unknown node";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean seat?"), std::string::npos) << error.what();
  }
}

TEST(Parts, APathNamesNodesWithoutANameToo) {
  Scene scene = nested_nodes();
  scene.nodes[0].name.clear();
  scene.nodes[2].name.clear();
  EXPECT_EQ(node_path(scene, 2), "/seat/");
  EXPECT_EQ(find_nodes(scene, "/seat/"), std::vector<int>{2});
  EXPECT_EQ(find_nodes(scene, "/door"), std::vector<int>{3});
  EXPECT_EQ(layers_of_nodes(scene, {{"", "b", 2}}, {"a", "b"}), (std::vector<int>{0, 0, 1, 0, 0})) << "by its index";
}

TEST(Parts, TheLastModeOfANodeCounts) {
  const ViewInfo view{.part_modes = {{"seat", "sg"}, {"cover", "splitsum"}, {"seat", "splitsum"}, {"door", "uniform"}}};
  const FramePlan made = plan({}, "uniform", {}, view);
  ASSERT_EQ(made.layers.size(), 2u) << "nothing is left for sg";
  EXPECT_EQ(made.layers[0].nodes, std::vector<std::string>{"door"}) << "back to the default";
  EXPECT_EQ(made.layers[1].nodes, (std::vector<std::string>{"cover", "seat"}));
}

TEST(Parts, ModesThatDrawWholePicturesAreRefused) {
  EXPECT_THROW(plan({}, "uniform", {}, {.part_modes = {{"seat", "reference"}}}), UsageError);
  EXPECT_THROW(plan({}, "reference", {}, {.part_modes = {{"seat", "uniform"}}}), UsageError);
  EXPECT_THROW(plan({}, "uniform", {}, {.part_modes = {{"seat", "nonsense"}}}), UsageError);
}

}  // namespace
}  // namespace maquette
