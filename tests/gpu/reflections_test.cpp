// Reflections of each technique against the rays of `raytraced`, and cases in which nothing may be reflected.
#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "render/gl/context.h"
#include "render/metrics.h"
#include "render/renderer.h"
#include "scenes/environment_builtin.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

using test::add;
using test::make_grid;

Material plain(const std::string& name, const glm::vec3& color) {
  Material m;
  m.name = name;
  m.base_color = glm::vec4(color, 1.0f);
  m.metallic = 0.0f;
  m.roughness = 0.9f;
  m.double_sided = true;
  return m;
}

Material mirror_metal() {
  Material m = plain("mirror", glm::vec3(0.9f));
  m.metallic = 1.0f;
  m.roughness = 0.02f;
  return m;
}

void add_box(Scene* scene, const glm::vec3& low, const glm::vec3& high, int material) {
  const glm::vec3 d = high - low, x(d.x, 0, 0), y(0, d.y, 0), z(0, 0, d.z);
  for (const Primitive& side : {make_grid(low, y, x, 2, material), make_grid(low, z, y, 2, material),
                                make_grid(low, x, z, 2, material), make_grid(high, -x, -y, 2, material),
                                make_grid(high, -y, -z, 2, material), make_grid(high, -z, -x, 2, material)})
    add(scene, side, "box");
}

/// The scene in front of the mirror: two boxes on a floor of two colours.
Scene room() {
  Scene scene;
  scene.materials = {plain("grey", glm::vec3(0.5f)), plain("red", {0.8f, 0.1f, 0.05f}),
                     plain("blue", {0.1f, 0.2f, 0.7f}), mirror_metal()};
  add(&scene, make_grid({-3.0f, -0.5f, 3.0f}, {3, 0, 0}, {0, 0, -3.9f}, 4, 0), "floor");
  add(&scene, make_grid({0.0f, -0.5f, 3.0f}, {3, 0, 0}, {0, 0, -3.9f}, 4, 2), "floor");
  add_box(&scene, {0.2f, -0.5f, -0.3f}, {0.6f, 0.1f, 0.1f}, 1);
  add_box(&scene, {-0.7f, -0.5f, 0.4f}, {-0.3f, 0.4f, 0.7f}, 2);
  return scene;
}

/// A mirror 2 m wide and 1.2 m high, curved towards the eye at its sides by `bend` metres.
void add_patch(Scene* scene, float bend) {
  BezierPatch patch;
  patch.name = "mirror";
  patch.material = 3;
  // Control points of the polynomial: a quadratic's are its blossom, raised in degree.
  const auto square = [](int k) { return k == 0 || k == 3 ? 1.0f : -1.0f / 3.0f; };
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const float x = -1.0f + 2.0f * static_cast<float>(i) / 3.0f,
                  y = 0.6f * (-1.0f + 2.0f * static_cast<float>(j) / 3.0f);
      patch.points[static_cast<std::size_t>(4 * j + i)] = {x, y, -1.0f + bend * (square(i) + 0.5f * 0.36f * square(j))};
    }
  Node node;
  node.name = "mirror";
  node.patch = static_cast<int>(scene->patches.size());
  scene->patches.push_back(patch);
  scene->roots.push_back(static_cast<int>(scene->nodes.size()));
  scene->nodes.push_back(node);
}

/// The same mirror as a mesh with normals.
void add_mesh_mirror(Scene* scene, float bend, int side) {
  Primitive p = make_grid({-1.0f, -0.6f, -1.0f}, {2, 0, 0}, {0, 1.2f, 0}, side, 3);
  for (std::size_t i = 0; i < p.positions.size(); ++i) {
    glm::vec3& at = p.positions[i];
    at.z += bend * (at.x * at.x + 0.5f * at.y * at.y);
    p.normals[i] = glm::normalize(glm::vec3(-2.0f * bend * at.x, -bend * at.y, 1.0f));
  }
  add(scene, p, "mirror")->reflector = true;
}

FrameRequest request_of(const std::string& technique) {
  FrameRequest r;
  r.mode = "splitsum";
  r.width = 192;
  r.height = 128;
  r.reflections = technique;
  r.camera.eye = {0.1f, 0.35f, 1.8f};
  r.camera.target = {0.0f, 0.0f, -1.0f};
  r.camera.fov_y_rad = 0.5f;
  r.settings.set_from_text("reflections.resolution", "full");
  return r;
}

Image draw_reflection(Renderer* renderer, const FrameRequest& request) {
  EXPECT_TRUE(renderer->finish_background_work(request));
  renderer->render(request);
  const Image image = renderer->read_debug_view("reflection");
  for (float v : image.data) EXPECT_TRUE(std::isfinite(v) && v >= 0.0f);
  const auto errors = take_gl_errors();
  EXPECT_TRUE(errors.empty()) << errors.front();
  return image;
}

struct Difference {
  double mean = 0.0;   ///< of the absolute difference, against the mean of the reference
  double share = 0.0;  ///< share of the reflector's pixels that differ by more than a tenth of that mean
};

Difference compare(const Image& image, const Image& reference) {
  double sum = 0.0, level = 0.0, count = 0.0, off = 0.0;
  const auto each = [&](auto&& use) {
    for (std::size_t i = 0; i < reference.data.size(); i += 4)
      if (reference.data[i + 3] > 0.0f) use(i);
  };
  each([&](std::size_t i) {
    for (std::size_t c = 0; c < 3; ++c) level += static_cast<double>(reference.data[i + c]) / 3.0;
    count += 1.0;
  });
  level /= count;
  each([&](std::size_t i) {
    EXPECT_GT(image.data[i + 3], 0.0f);
    double d = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      d += std::abs(static_cast<double>(image.data[i + c] - reference.data[i + c])) / 3.0;
    sum += d;
    off += d > 0.1 * level ? 1.0 : 0.0;
  });
  EXPECT_GT(count, 2000.0);
  EXPECT_GT(level, 0.0);
  return {sum / count / level, off / count};
}

class Reflections : public ::testing::Test {
 protected:
  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
  void SetUp() override {
    install_debug_output();
    renderer_.set_environment(std::make_shared<Environment>(make_clear_sky()));
  }
  /// Compares a technique with traced rays; pictures of a failure are written beside the test.
  void expect_near_rays(const FrameRequest& request, double mean, double share) {
    FrameRequest exact = request;
    exact.reflections = "raytraced";
    const Image image = draw_reflection(&renderer_, request), reference = draw_reflection(&renderer_, exact);
    const Difference d = compare(image, reference);
    EXPECT_LT(d.mean, mean);
    EXPECT_LT(d.share, share);
    if (d.mean < mean && d.share < share) return;
    const std::string name =
        ::testing::TempDir() + "reflections_" + request.reflections + "_" + std::to_string(written_++);
    save_png(name + ".png", debug_view_picture(image, "reflection"));
    save_png(name + "_reference.png", debug_view_picture(reference, "reflection"));
    ADD_FAILURE() << "pictures: " << name << "*.png";
  }
  int written_ = 0;
};

TEST_F(Reflections, OctreeShowsWhatRaysShow) {
  for (const float bend : {0.15f, -0.15f}) {
    Scene scene = room();
    add_patch(&scene, bend);
    renderer_.set_scene(std::make_shared<Scene>(scene));
    SCOPED_TRACE(bend);
    expect_near_rays(request_of("octree"), 0.03, 0.06);
  }
}

TEST_F(Reflections, BezierShowsWhatRaysShow) {
  for (const float bend : {0.15f, -0.15f}) {
    Scene scene = room();
    add_patch(&scene, bend);
    renderer_.set_scene(std::make_shared<Scene>(scene));
    SCOPED_TRACE(bend);
    expect_near_rays(request_of("bezier"), 0.002, 0.004);
  }
}

/// Bowls that show parts of the room several times: unmarked pixels agree with rays, pixels that differ are marked as
/// low confidence, and the picture and the stats show it.
TEST_F(Reflections, BezierMarksLowConfidence) {
  const auto view = [&](const FrameRequest& request, const std::string& name) {
    draw_reflection(&renderer_, request);
    return renderer_.read_debug_view(name);
  };
  for (const float bend : {0.35f, 0.45f}) {
    SCOPED_TRACE(bend);
    Scene scene = room();
    add_patch(&scene, bend);
    renderer_.set_scene(std::make_shared<Scene>(scene));
    const Image image = view(request_of("bezier"), "reflection"), marks = renderer_.read_debug_view("reflection_doubt");
    const Image exact = view(request_of("raytraced"), "reflection");
    double certain = 0.0, low_confidence = 0.0, wrong = 0.0;
    for (std::size_t i = 0; i < exact.data.size(); i += 4) {
      if (exact.data[i + 3] <= 0.0f) continue;
      float difference = 0.0f, level = 0.01f;
      for (std::size_t c = 0; c < 3; ++c) {
        difference = std::max(difference, std::abs(image.data[i + c] - exact.data[i + c]));
        level = std::max(level, exact.data[i + c]);
      }
      const bool marked = marks.data[i] > 0.0f;
      (marked ? low_confidence : certain) += 1.0;
      wrong += !marked && difference > 0.1f * level ? 1.0 : 0.0;
    }
    EXPECT_GT(low_confidence, 200.0);
    EXPECT_GT(certain, 200.0);
    EXPECT_LT(wrong, 0.004 * certain);
    FrameRequest hatched = request_of("bezier"), plain = hatched;
    plain.settings.set_from_text("reflections.mark", "none");
    EXPECT_EQ(renderer_.render(hatched).technique.at("uncertain_pixels"), low_confidence);
    const Image with = renderer_.read_radiance();
    renderer_.render(plain);
    const Image without = renderer_.read_radiance();
    double changed = 0.0;
    for (std::size_t i = 0; i < with.data.size(); i += 4) changed += with.data[i] < without.data[i] ? 1.0 : 0.0;
    EXPECT_GT(changed, 0.1 * low_confidence);
    EXPECT_LT(changed, 0.4 * low_confidence);
  }
}

TEST_F(Reflections, TriangleShowsWhatRaysShow) {
  for (const float bend : {0.15f, -0.15f}) {
    SCOPED_TRACE(bend);
    Scene scene = room();
    add_patch(&scene, bend);
    renderer_.set_scene(std::make_shared<Scene>(scene));
    for (const char* side : {"4", "8", "16"}) {
      SCOPED_TRACE(side);
      FrameRequest request = request_of("triangle");
      request.settings.set_from_text("triangle.side", side);
      expect_near_rays(request, 0.002, 0.004);
    }
  }
}

/// A mesh with normals, so coarse that its rays differ much from those of a smooth surface.
TEST_F(Reflections, AMeshReflectsByItsNormals) {
  for (const float bend : {0.15f, -0.3f}) {
    SCOPED_TRACE(bend);
    Scene scene = room();
    add_mesh_mirror(&scene, bend, 6);
    renderer_.set_scene(std::make_shared<Scene>(scene));
    expect_near_rays(request_of("triangle"), 0.002, 0.004);
    expect_near_rays(request_of("octree"), 0.03, 0.06);
    expect_near_rays(request_of("bezier"), 0.002, 0.004);
    const FrameStats stats = renderer_.render(request_of("bezier"));
    EXPECT_LT(stats.technique.at("fit_error_mm"), 0.2);
    ASSERT_EQ(stats.status.fitted.size(), 1u);
    EXPECT_TRUE(stats.status.fitted[0].starts_with("'mirror': 1 patch, ")) << stats.status.fitted[0];
    EXPECT_TRUE(std::any_of(stats.plan.features.begin(), stats.plan.features.end(),
                            [](const Feature& feature) { return feature.name == "patch_fit"; }));
  }
}

/// A mirror of very many triangles in a scene of very many: refused instead of drawn for minutes.
TEST_F(Reflections, TriangleRefusesScenesThatWouldTakeMinutes) {
  Scene scene = room();
  add_mesh_mirror(&scene, 0.3f, 200);
  add(&scene, make_grid({-1.0f, -1.0f, 1.0f}, {2, 0, 0}, {0, 2, 0}, 250, 0));
  renderer_.set_scene(std::make_shared<Scene>(scene));
  try {
    renderer_.render(request_of("triangle"));
    FAIL() << "drawn";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("raytraced"), std::string::npos) << error.what();
  }
}

TEST_F(Reflections, APlaneMirrorIsExact) {
  for (const bool mesh : {false, true}) {
    SCOPED_TRACE(mesh);
    Scene scene = room();
    mesh ? add_mesh_mirror(&scene, 0.0f, 3) : add_patch(&scene, 0.0f);
    renderer_.set_scene(std::make_shared<Scene>(scene));
    for (const char* technique : {"triangle", "bezier"}) expect_near_rays(request_of(technique), 0.002, 0.004);
  }
}

constexpr const char* kTechniques[] = {"raytraced", "bezier", "triangle", "octree"};

/// A patch with one edge collapsed to a point.
TEST_F(Reflections, ACollapsedEdgeReflects) {
  Scene scene = room();
  add_patch(&scene, 0.15f);
  for (std::size_t i = 0; i < 4; ++i) scene.patches[0].points[i] = scene.patches[0].points[0];
  renderer_.set_scene(std::make_shared<Scene>(scene));
  expect_near_rays(request_of("triangle"), 0.002, 0.004);
  expect_near_rays(request_of("octree"), 0.03, 0.06);
  draw_reflection(&renderer_, request_of("bezier"));
}

TEST_F(Reflections, APatchWithoutAreaShowsNothing) {
  Scene scene = room();
  add_patch(&scene, 0.15f);
  scene.patches[0].points.fill(glm::vec3(0.0f, 0.2f, -1.0f));
  renderer_.set_scene(std::make_shared<Scene>(scene));
  for (const std::string technique : kTechniques) {
    SCOPED_TRACE(technique);
    if (technique == "bezier") {
      for (int frame = 0; frame < 2; ++frame) EXPECT_THROW(renderer_.render(request_of(technique)), Error) << frame;
      continue;
    }
    const Image image = draw_reflection(&renderer_, request_of(technique));
    for (std::size_t i = 3; i < image.data.size(); i += 4) ASSERT_EQ(image.data[i], 0.0f);
  }
}

TEST_F(Reflections, AReflectorBehindTheEyeCostsNothing) {
  Scene scene = room();
  add_patch(&scene, 0.15f);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  for (const char* technique : kTechniques) {
    FrameRequest request = request_of(technique);
    request.camera.target = {0.0f, 0.0f, 5.0f};
    EXPECT_TRUE(renderer_.finish_background_work(request));
    const FrameStats stats = renderer_.render(request);
    EXPECT_TRUE(stats.plan.reflections.empty());
    EXPECT_EQ(stats.gpu_bytes.count("reflections"), 0u);
    EXPECT_EQ(stats.gpu_bytes.count("octree"), 0u);
  }
}

TEST_F(Reflections, TheEyeOnTheSurfaceIsFinite) {
  Scene scene = room();
  add_patch(&scene, 0.15f);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  for (const char* technique : kTechniques) {
    FrameRequest request = request_of(technique);
    request.camera.eye = {0.0f, 0.0f, -1.0f};
    request.camera.target = {1.0f, 0.0f, -0.9f};
    draw_reflection(&renderer_, request);
  }
}

/// Nothing is in front of the mirror: it shows the sky, and no technique finds a triangle.
TEST_F(Reflections, AnEmptyReflectionShowsTheSky) {
  Scene scene;
  scene.materials.assign(4, mirror_metal());
  add_patch(&scene, 0.15f);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  for (const char* technique : kTechniques) expect_near_rays(request_of(technique), 1e-4, 1e-4);
}

/// A reflection does not depend on the side to which the normals point, or whether the file has any.
TEST_F(Reflections, FlippedAndMissingNormalsReflect) {
  for (const bool flipped : {false, true}) {
    SCOPED_TRACE(flipped);
    Scene scene = room();
    add_mesh_mirror(&scene, 0.15f, 12);
    auto& normals = scene.meshes.back().primitives[0].normals;
    if (flipped)
      for (glm::vec3& n : normals) n = -n;
    else
      normals.clear();
    renderer_.set_scene(std::make_shared<Scene>(scene));
    expect_near_rays(request_of("triangle"), 0.002, 0.004);
    expect_near_rays(request_of("octree"), 0.03, 0.06);
    expect_near_rays(request_of("bezier"), 0.002, 0.004);
  }
}

/// Two sheets and a rim that shares their normals: each sheet has its own patches.
TEST_F(Reflections, AClosedPaneReflects) {
  Scene scene = room();
  add_mesh_mirror(&scene, -0.15f, 24);
  Primitive& body = scene.meshes.back().primitives[0];
  const auto front = static_cast<std::uint32_t>(body.positions.size());
  const std::size_t triangles = body.indices.size();
  for (std::uint32_t k = 0; k < front; ++k) {
    body.positions.push_back(body.positions[k] - glm::vec3(0.0f, 0.0f, 0.01f));
    body.normals.push_back(-body.normals[k]);
  }
  for (std::size_t k = 0; k < triangles; k += 3)
    for (const std::size_t corner : {0, 2, 1}) body.indices.push_back(front + body.indices[k + corner]);
  for (std::uint32_t k = 0; k < 24; ++k)
    for (const std::uint32_t v : {k, front + k, k + 1, k + 1, front + k, front + k + 1}) body.indices.push_back(v);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  FrameRequest request = request_of("bezier");
  request.settings.set_from_text("reflections.mark", "none");
  expect_near_rays(request, 0.004, 0.006);
  EXPECT_LT(renderer_.render(request).technique.at("fit_error_mm"), 0.2);
}

TEST_F(Reflections, ViewsShowTheCostOfTheSearch) {
  Scene scene = room();
  add_patch(&scene, 0.15f);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  const auto range = [&](const std::string& view) {
    const Image image = renderer_.read_debug_view(view);
    std::pair<float, float> least_most{1e30f, 0.0f};
    for (std::size_t i = 0; i < image.data.size(); i += 4) {
      if (image.data[i + 3] <= 0.0f || image.data[i] <= 0.0f) continue;
      least_most = {std::min(least_most.first, image.data[i]), std::max(least_most.second, image.data[i])};
    }
    return least_most;
  };
  draw_reflection(&renderer_, request_of("octree"));
  EXPECT_GE(range("reflection_steps").second, 9.0f);
  EXPECT_GE(range("reflection_root").first, 1.0f);
  EXPECT_GE(range("reflection_root").second, 9.0f);  // the finest level, and up to three around the core
  EXPECT_LE(range("reflection_root").second, 12.0f);
  draw_reflection(&renderer_, request_of("bezier"));
  EXPECT_GE(range("reflection_steps").second, 1.0f);
  EXPECT_LE(range("reflection_steps").second, 40.0f);
  draw_reflection(&renderer_, request_of("triangle"));
  EXPECT_EQ(range("reflection_root").first, 1.0f);
  EXPECT_LE(range("reflection_root").second, 3.0f);
}

/// A wall 4 m in front of a flat mirror, seen in it: the distance of its image behind the mirror.
TEST_F(Reflections, DistancesAreThoseOfTheMirrorImage) {
  Scene scene;
  scene.materials.assign(3, plain("grey", glm::vec3(0.5f)));
  scene.materials.push_back(mirror_metal());
  add_patch(&scene, 0.0f);
  add(&scene, make_grid({-5.0f, -5.0f, 3.0f}, {10, 0, 0}, {0, 10, 0}, 4, 0), "wall");
  renderer_.set_scene(std::make_shared<Scene>(scene));
  for (const char* technique : {"raytraced", "bezier", "triangle"}) {
    SCOPED_TRACE(technique);
    FrameRequest request = request_of(technique);
    request.camera.eye = {0.0f, 0.0f, 1.8f};
    renderer_.render(request);
    const Image image = renderer_.read_debug_view("reflection_distance");
    const float px = 2.0f * std::tan(0.5f * request.camera.fov_y_rad) / static_cast<float>(image.height);
    int seen = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        if (image.at(x, y, 3) <= 0.0f) continue;
        ++seen;
        const float across = px * (static_cast<float>(x) + 0.5f - 0.5f * static_cast<float>(image.width)),
                    up = px * (static_cast<float>(y) + 0.5f - 0.5f * static_cast<float>(image.height));
        EXPECT_NEAR(image.at(x, y, 0), (1.8f + 5.0f) * std::sqrt(1.0f + across * across + up * up), 1e-3f);
      }
    EXPECT_GT(seen, 5000);
  }
}

/// While only the environment rotates the hits are reused and shaded again; when the eye moves they are traced again.
TEST_F(Reflections, HitsAreKeptWhileOnlyTheLightTurns) {
  Scene scene = room();
  add_patch(&scene, 0.15f);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  const auto finds_hits = [](const FrameStats& stats) {
    return std::any_of(stats.passes.begin(), stats.passes.end(),
                       [](const PassTime& p) { return p.name == "projection" || p.name == "rays"; });
  };
  for (const char* technique : {"raytraced", "bezier", "triangle"}) {
    SCOPED_TRACE(technique);
    FrameRequest request = request_of(technique);
    EXPECT_TRUE(finds_hits(renderer_.render(request)));
    request.env_rotation_rad = 1.0f;
    EXPECT_FALSE(finds_hits(renderer_.render(request)));
    const Image kept = renderer_.read_radiance();
    FrameRequest without_reuse = request;
    without_reuse.settings.set_from_text("shading.reuse", "false");
    EXPECT_TRUE(finds_hits(renderer_.render(without_reuse)));
    EXPECT_EQ(kept.data, renderer_.read_radiance().data);
    request.camera.eye.x += 0.05f;
    EXPECT_TRUE(finds_hits(renderer_.render(request)));
    EXPECT_NE(kept.data, renderer_.read_radiance().data);
  }
}

/// The previous picture only affects the order of the search: after a jump of the eye nothing of it remains.
TEST_F(Reflections, APictureDoesNotDependOnTheOneBefore) {
  Scene scene = room();
  add_patch(&scene, -0.15f);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  for (const char* technique : {"bezier", "triangle"}) {
    SCOPED_TRACE(technique);
    FrameRequest request = request_of(technique);
    const Image first = draw_reflection(&renderer_, request);
    FrameRequest elsewhere = request;
    elsewhere.camera.eye = {-0.9f, 0.9f, 0.2f};
    draw_reflection(&renderer_, elsewhere);
    const Difference d = compare(draw_reflection(&renderer_, request), first);
    EXPECT_LT(d.mean, 1e-4);
    EXPECT_LT(d.share, 2e-4);
  }
}

/// A closed box under a bright sky: with shadows nothing in it is lit, and the mirror stays black.
TEST_F(Reflections, AMirrorInAClosedBoxStaysDark) {
  Scene scene;
  scene.materials = {plain("wall", glm::vec3(0.5f)), plain("red", glm::vec3(1.0f)), plain("blue", glm::vec3(1.0f)),
                     mirror_metal()};
  add_box(&scene, {-2.0f, -2.0f, -2.0f}, {2.0f, 2.0f, 2.5f}, 0);
  add_patch(&scene, 0.15f);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  for (const std::string technique : {"raytraced", "bezier", "triangle", "octree"})
    for (const std::string visibility : {"baked", "traced", "none"}) {
      FrameRequest request = request_of(technique);
      request.mode = "uniform";
      request.samples = 16;
      request.width = 96;
      request.height = 64;
      request.settings.set_from_text("shading.visibility", visibility);
      request.settings.set_from_text("shading.indirect", "none");
      const Image image = draw_reflection(&renderer_, request);
      double sum = 0.0, count = 0.0;
      for (std::size_t i = 0; i < image.data.size(); i += 4) {
        sum += static_cast<double>(image.data[i]);
        count += static_cast<double>(image.data[i + 3]);
      }
      ASSERT_GT(count, 500.0);
      if (visibility == "none")
        EXPECT_GT(sum / count, 0.05) << technique;
      else
        EXPECT_LT(sum / count, 5e-4) << technique << " with visibility " << visibility;
    }
}

/// A pane in front of a bright sky that mirrors a dim room with a lamp of the size of a hand.
Scene pane_before_the_sky(float lamp_cdm2) {
  Scene scene;
  scene.materials = {plain("grey", glm::vec3(0.3f)), plain("red", {0.8f, 0.1f, 0.05f}), plain("lamp", glm::vec3(0.0f)),
                     plain("glass", {0.95f, 0.97f, 0.96f})};
  scene.materials[2].emissive = glm::vec3(lamp_cdm2);
  scene.materials[3].glass = true;
  scene.materials[3].transmission = 1.0f;
  scene.materials[3].ior = 1.52f;
  add_box(&scene, {-4.0f, -3.0f, 2.2f}, {4.0f, 5.0f, 2.4f}, 0);
  add_box(&scene, {0.4f, 0.3f, 1.4f}, {0.8f, 0.9f, 1.7f}, 1);
  add(&scene, make_grid({-0.65f, 0.55f, 1.6f}, {0, 0.1f, 0}, {0.1f, 0, 0}, 2, 2), "lamp");
  add(&scene, make_grid({-1.0f, 0.0f, -1.0f}, {2, 0, 0}, {0, 1.2f, 0}, 24, 3), "pane")->reflector = true;
  return scene;
}

FrameRequest pane_request(const std::string& technique, bool display) {
  FrameRequest r = request_of(technique);
  r.camera.eye = {0.1f, 0.5f, 1.2f};
  r.camera.target = {0.0f, 0.6f, -1.0f};
  r.camera.fov_y_rad = 0.45f;
  r.display = display;
  return r;
}

/// Mean HDR-FLIP of all pixels, those of the sky too.
double flip_with_sky(Image image, Image reference) {
  for (std::size_t i = 3; i < image.data.size(); i += 4) image.data[i] = reference.data[i] = 1.0f;
  return measure_error(image, reference).figures.flip.value();
}

/// In front of a bright sky many mirrored rays are skipped without a visible difference; rays to bright parts are
/// traced.
TEST_F(Reflections, RaysWithoutVisibleEffectAreSkipped) {
  double share[2] = {};
  for (const float lamp : {0.0f, 2e5f}) {
    SCOPED_TRACE(lamp);
    renderer_.set_scene(std::make_shared<Scene>(pane_before_the_sky(lamp)));
    const auto picture_of = [&](bool display) {
      FrameRequest request = pane_request("octree", display);
      EXPECT_TRUE(renderer_.finish_background_work(request));
      const FrameStats stats = renderer_.render(request);
      EXPECT_EQ(stats.technique.count("rays_skipped"), display ? 1u : 0u);
      if (display) share[lamp > 0.0f ? 1 : 0] = stats.technique.at("rays_skipped_share");
      return renderer_.read_radiance();
    };
    const Image all = picture_of(false), some = picture_of(true);
    const Image skipped = renderer_.read_debug_view("rays_skipped");
    double most = 0.0, count = 0.0;
    for (std::size_t i = 0; i < all.data.size(); i += 4) {
      most = std::max(most, static_cast<double>(std::abs(some.data[i + 1] - all.data[i + 1]) / all.data[i + 1]));
      count += static_cast<double>(skipped.data[i]);
    }
    EXPECT_GT(count, 1000.0);
    EXPECT_LT(most, 0.05);
    EXPECT_LT(flip_with_sky(some, all), 0.02);
    const auto errors = take_gl_errors();
    EXPECT_TRUE(errors.empty()) << errors.front();
  }
  EXPECT_GT(share[0], 0.2);
  EXPECT_LT(share[1], share[0] - 0.03) << "what mirrors the lamp is to be followed";
}

/// If the test for skipping would cost more than it saves, and in pictures for measurements, every ray is traced, and
/// the plan says why.
TEST_F(Reflections, ThePlanSaysWhyNoRayIsSkipped) {
  renderer_.set_scene(std::make_shared<Scene>(pane_before_the_sky(0.0f)));
  for (const char* technique : {"raytraced", "bezier", "triangle", "octree"}) {
    const FrameRequest request = pane_request(technique, std::string(technique) != "octree");
    EXPECT_TRUE(renderer_.finish_background_work(request));
    const FrameStats stats = renderer_.render(request);
    EXPECT_EQ(stats.technique.count("rays_skipped"), 0u);
    EXPECT_EQ(std::count_if(stats.plan.left_out.begin(), stats.plan.left_out.end(),
                            [](const LeftOut& left) { return left.what == "skip"; }),
              1)
        << technique;
  }
}

/// A lamp as a thin upright bar, mirrored at about 60 degrees in a flat pane 5 mm thick: the distance of its two images
/// follows from the paths unfolded by Snell's law, height (tan theta) + 2 t tan(theta') each.
TEST_F(Reflections, APaneShowsALampTwice) {
  constexpr double kWay = 2.0, kHeights = 1.2, kThickness = 0.005, kIndex = 1.52;
  Scene scene;
  scene.materials.assign(4, plain("dark", glm::vec3(0.0f)));
  scene.materials[2].emissive = glm::vec3(1e6f);
  scene.materials[3] = plain("clear", glm::vec3(1.0f));
  scene.materials[3].glass = true;
  scene.materials[3].transmission = 1.0f;
  scene.materials[3].ior = static_cast<float>(kIndex);
  add(&scene, make_grid({0.9995f, 0.3f, 0.6f}, {0.001f, 0, 0}, {0, 0.4f, 0}, 1, 2), "lamp");
  add(&scene, make_grid({-0.4f, 0.3f, 0.0f}, {0.8f, 0, 0}, {0, 0.4f, 0}, 8, 3), "pane")->reflector = true;
  renderer_.set_scene(std::make_shared<Scene>(scene));
  FrameRequest request = request_of("raytraced");
  request.camera.eye = {-1.0f, 0.5f, 0.6f};
  request.camera.target = {0.0f, 0.5f, 0.0f};
  request.camera.fov_y_rad = 0.012f;
  request.settings.set_from_text("reflections.ghost", "true");
  renderer_.render(request);
  const Image image = renderer_.read_radiance();
  std::vector<std::pair<double, double>> bars;  // weight, weighted column
  bool inside = false;
  for (int x = 0; x < image.width; ++x) {
    const auto v = static_cast<double>(image.at(x, image.height / 2, 1));
    const bool bright = v > 3e4;
    if (bright && !inside) bars.emplace_back(0.0, 0.0);
    inside = bright;
    if (!bright) continue;
    bars.back().first += v;
    bars.back().second += v * (x + 0.5);
  }
  ASSERT_EQ(bars.size(), 2u);
  double elevation[2];
  for (int k = 0; k < 2; ++k) {
    double low = 0.0, high = 1.5;
    for (int step = 0; step < 60; ++step) {
      const double theta = 0.5 * (low + high), s = std::sin(theta);
      const double way =
          kHeights * std::tan(theta) + (k == 0 ? 0.0 : 2.0 * kThickness * s / std::sqrt(kIndex * kIndex - s * s));
      (way < kWay ? low : high) = theta;
    }
    elevation[k] = low;
  }
  const double axis = std::atan(1.0 / 0.6), focal_px = 0.5 * image.height / std::tan(0.5 * 0.012);
  const double expected_px = focal_px * (std::tan(elevation[0] - axis) - std::tan(elevation[1] - axis));
  const double measured_px = std::abs(bars[1].second / bars[1].first - bars[0].second / bars[0].first);
  EXPECT_GT(expected_px, 10.0);
  EXPECT_NEAR(measured_px, expected_px, 0.35);
}

Material clear_glass() {
  Material m = plain("clear", glm::vec3(1.0f));
  m.glass = true;
  m.transmission = 1.0f;
  m.ior = 1.52f;
  return m;
}

/// The second image of thick, wedged panes agrees with rays: panes curved both ways, flat, and a mesh. It is several
/// pixels from the first, so a technique that confuses both fails.
TEST_F(Reflections, SecondImagesAreWhereRaysShowThem) {
  const auto second_image = [&](const FrameRequest& request) {
    draw_reflection(&renderer_, request);
    return renderer_.read_debug_view("ghost");
  };
  const auto check = [&](const std::string& technique) {
    SCOPED_TRACE(technique);
    FrameRequest request = request_of(technique);
    request.settings.set_from_text("reflections.ghost", "true");
    request.settings.set_from_text("reflections.thickness", "20");
    request.settings.set_from_text("reflections.wedge", "10");
    FrameRequest exact = request;
    exact.reflections = "raytraced";
    const Image reference = second_image(exact), image = second_image(request);
    const Image first = renderer_.read_debug_view("reflection");
    const Difference d = compare(image, reference), between = compare(first, reference);
    EXPECT_LT(d.mean, 0.002);
    EXPECT_LT(d.share, 0.004);
    EXPECT_GT(between.share, 0.03);
  };
  for (const float bend : {0.15f, -0.15f, 0.0f}) {
    SCOPED_TRACE(bend);
    Scene scene = room();
    scene.materials[3] = clear_glass();
    add_patch(&scene, bend);
    scene.patches[0].reflector = true;
    renderer_.set_scene(std::make_shared<Scene>(scene));
    check("bezier");
    check("triangle");
  }
  Scene scene = room();
  scene.materials[3] = clear_glass();
  add_mesh_mirror(&scene, 0.15f, 6);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  check("triangle");
}

}  // namespace
}  // namespace maquette
