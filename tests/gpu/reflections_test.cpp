// Reflections of each technique against the rays of `raytraced`, and cases in which nothing may be reflected.
#include <epoxy/gl.h>

#include "tests/gpu/reflections_fixture.h"

namespace maquette {
namespace {

using namespace test;

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
    EXPECT_TRUE(renderer_.finish_background_work(request));
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

}  // namespace
}  // namespace maquette
