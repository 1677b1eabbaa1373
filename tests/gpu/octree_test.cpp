#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "render/gl/bindings.h"
#include "render/gl/context.h"
#include "render/octree/octree_buffers.h"
#include "render/octree/octree_build.h"
#include "render/octree/octree_kind.h"
#include "render/octree/octree_shared.h"
#include "render/renderer.h"
#include "tests/support/octree_rays.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

using test::constant_sky;
using test::HitRecord;
using test::RayRecord;

Octree build(const std::string& name, int depth) {
  const Scene scene = build_builtin_scene(name);
  const OctreeJob job = make_octree_job(scene, scene.materials, -1, depth);
  return build_octree({job.geometry, job.materials, job.transmits, *job.textures}, job.options);
}

TEST(OctreeOnGpu, WalksAsTheCpuDoes) {
  const GlContext context = GlContext::create_headless();
  const Octree octree = build("seat", 7);
  std::mt19937 random(3);
  std::normal_distribution<float> u;
  std::vector<RayRecord> rays;
  for (int i = 0; i < 4000; ++i) {
    RayRecord r{};
    const glm::vec3 center = octree.corner + 0.5f * octree.side_m;
    r.origin = center + 0.4f * octree.side_m * glm::vec3(u(random), u(random), u(random));
    r.direction = glm::normalize(glm::vec3(u(random), u(random), u(random)));
    if (i % 5 == 0) r.direction = glm::vec3(i % 3 == 0, i % 3 == 1, i % 3 == 2);
    r.t_max = 100.0f;
    r.t_box = i % 2 ? 0.05f : 0.0f;
    r.spread = i % 4 == 3 ? 0.05f : 0.0f;
    rays.push_back(r);
  }
  const OctreeBuffers buffers(octree);
  const Program program = Program::compute("octree/trace_rays.comp");
  const Buffer in = Buffer::from("rays", rays), out("hits", rays.size() * sizeof(HitRecord));
  buffers.bind();
  buffers.set_uniforms(program);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferOctreeRays, in.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferOctreeHits, out.get());
  glUseProgram(program.get());
  glDispatchCompute(static_cast<GLuint>((rays.size() + 63) / 64), 1, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  std::vector<HitRecord> hits(rays.size());
  out.read(0, hits.size() * sizeof(HitRecord), hits.data());
  shared::octree_view = {octree.words.data(), octree.planes.data()};
  const shared::OctreeFrame frame = shared::octree_frame(octree);
  int differ = 0, met = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const RayRecord& r = rays[i];
    const auto hit = shared::octree_trace(frame, {r.origin, r.direction, r.t_min, r.t_max, r.t_box, r.width, r.spread});
    met += hit.node >= 0;
    if (hit.node != hits[i].node) ++differ;  // different rounding of a ray along an edge
    if (hit.node == hits[i].node && hit.node >= 0) {
      EXPECT_NEAR(hit.t, hits[i].t, 1e-4f);
    }
  }
  EXPECT_LE(differ, 8);
  EXPECT_GT(met, 500);
  EXPECT_TRUE(take_gl_errors().empty());
}

/// A box around [-1, 1]^3, matte at 0.5, seen from inside; the last wall is the roof.
std::shared_ptr<Scene> box(int walls) {
  return std::make_shared<Scene>(test::box_scene(walls, 8, test::matte(glm::vec3(0.5f))));
}

FrameRequest octree_request(const std::string& mode) {
  FrameRequest r;
  r.mode = mode;
  r.width = r.height = 48;
  r.samples = 64;
  r.settings.set_from_text("shading.visibility", "traced");
  r.settings.set_from_text("shading.indirect", "none");  // closed forms of direct light
  r.settings.set_from_text("octree.depth", "6");
  return r;
}

double draw_traced(Renderer* renderer, const FrameRequest& request) {
  EXPECT_TRUE(renderer->finish_background_work(request));
  const FrameStats stats = renderer->render(request);
  EXPECT_EQ(stats.plan.shading().visibility, "traced");
  EXPECT_GT(stats.gpu_bytes.at("octree"), 0u);
  const Image image = renderer->read_radiance();
  double sum = 0.0;
  for (std::size_t i = 0; i < image.data.size(); i += 4) {
    EXPECT_TRUE(std::isfinite(image.data[i]) && image.data[i] >= 0.0f);
    sum += static_cast<double>(image.data[i]);
  }
  const auto errors = take_gl_errors();
  EXPECT_TRUE(errors.empty()) << errors.front();
  return sum / (static_cast<double>(image.data.size()) / 4.0);
}

class TracedVisibility : public ::testing::TestWithParam<std::string> {
 protected:
  GlContext context_ = GlContext::create_headless();
  void SetUp() override { install_debug_output(); }
};
INSTANTIATE_TEST_SUITE_P(Modes, TracedVisibility, ::testing::Values("uniform", "bandwidth"),
                         [](const auto& mode) { return mode.param; });

/// A mirror in a box whose roof has a gap: most of what it shows is indirect light, baked per vertex. Cells show it
/// like the triangles of `raytraced`.
TEST(OctreeReflections, CellsKnowTheLightBakedByVertex) {
  const GlContext context = GlContext::create_headless();
  Scene scene = *box(5);
  test::add(&scene, test::make_grid({-1, 1, -1}, {1.6f, 0, 0}, {0, 0, 2}, 8, 0));
  Material mirror = test::matte(glm::vec3(0.9f));
  mirror.metallic = 1.0f;
  mirror.roughness = 0.02f;
  scene.materials.push_back(mirror);
  test::add(&scene, test::make_grid({-0.6f, -0.6f, -0.7f}, {1.2f, 0, 0}, {0, 1.2f, 0}, 1, 1))->reflector = true;
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(constant_sky(1.0f));
  const auto draw_mirror = [&](const std::string& technique, const std::string& indirect) {
    FrameRequest request = octree_request("uniform");
    request.reflections = technique;
    request.camera.eye = {0.1f, 0.1f, 0.9f};
    request.camera.target = {0.0f, 0.0f, -1.0f};
    request.settings.set_from_text("shading.visibility", "baked");
    request.settings.set_from_text("shading.indirect", indirect);
    request.settings.set_from_text("reflections.resolution", "full");
    EXPECT_TRUE(renderer.finish_background_work(request));
    renderer.render(request);
    return renderer.read_debug_view("reflection");
  };
  const Image direct = draw_mirror("raytraced", "none"), rays = draw_mirror("raytraced", "baked"),
              rays_m = renderer.read_debug_view("reflection_distance"), cells = draw_mirror("octree", "baked"),
              cells_m = renderer.read_debug_view("reflection_distance");
  // A cell that contains two walls is a solid with a normal between theirs.
  const auto is_corner = [&](std::size_t i) { return std::abs(cells_m.data[i] - rays_m.data[i]) > 2e-3f; };
  int corners = 0;
  double indirect_sum = 0.0, sum = 0.0, apart = 0.0;
  for (std::size_t i = 0; i < rays.data.size(); i += 4) {
    corners += is_corner(i);
    if (is_corner(i)) continue;
    indirect_sum += static_cast<double>(rays.data[i] - direct.data[i]);
    sum += static_cast<double>(rays.data[i]);
    apart += std::abs(static_cast<double>(cells.data[i] - rays.data[i]));
  }
  EXPECT_GT(indirect_sum, 0.3 * sum);
  EXPECT_LT(apart, 0.01 * sum);
  EXPECT_LT(corners, 250);
}

/// In a window the octree is kept while the camera looks away for a moment, for a single picture it is not; its memory
/// is released at once when another technique is selected.
TEST(OctreeReflections, StayWhileTheCameraLooksAway) {
  const GlContext context = GlContext::create_headless();
  for (const bool interactive : {true, false}) {
    SCOPED_TRACE(interactive);
    Renderer renderer;
    Scene scene = *box(6);
    BezierPatch pane;
    for (std::size_t i = 0; i < 16; ++i)
      pane.points[i] =
          glm::vec3(0.2f * static_cast<float>(i % 4) - 0.3f, 0.2f * static_cast<float>(i / 4) - 0.3f, -0.5f);
    pane.material = static_cast<int>(scene.materials.size());
    pane.reflector = true;
    scene.materials.push_back(test::clear_pane());
    scene.patches.push_back(pane);
    scene.nodes.emplace_back().patch = 0;
    scene.roots.push_back(static_cast<int>(scene.nodes.size()) - 1);
    renderer.set_scene(std::make_shared<Scene>(scene));
    renderer.set_environment(constant_sky(1.0f));
    renderer.set_interactive(interactive);
    FrameRequest towards = octree_request("splitsum");
    towards.reflections = "octree";
    towards.camera.eye = {0.1f, 0.1f, 0.5f};
    towards.camera.target = {0.0f, 0.0f, -1.0f};
    FrameRequest away = towards;
    away.camera.target = {0.1f, 0.1f, 2.0f};
    const auto octree_of = [&](const FrameRequest& r) { return renderer.render(r).gpu_bytes.count("octree"); };
    EXPECT_TRUE(renderer.finish_background_work(towards));
    EXPECT_EQ(renderer.render(towards).plan.reflections, "octree");
    EXPECT_EQ(octree_of(away), interactive ? 1u : 0u);
    if (!interactive) continue;
    EXPECT_EQ(renderer.render(towards).plan.reflections, "octree");  // at once
    for (int frame = 0; frame < 200; ++frame) EXPECT_EQ(octree_of(away), 1u) << frame;
    EXPECT_EQ(octree_of(away), 0u);
    EXPECT_TRUE(renderer.finish_background_work(towards));
    EXPECT_EQ(octree_of(towards), 1u);
    FrameRequest off = away;
    off.reflections = "off";
    EXPECT_EQ(octree_of(off), 0u);
  }
}

TEST_P(TracedVisibility, AClosedBoxIsBlackInside) {
  Renderer renderer;
  renderer.set_scene(box(6));
  renderer.set_environment(constant_sky(1.0f));
  FrameRequest request = octree_request(GetParam());
  request.camera.eye = {0.3f, 0.2f, 0.8f};
  request.camera.target = {0.0f, 0.0f, -1.0f};
  EXPECT_LT(draw_traced(&renderer, request), 1e-3);
}

TEST_P(TracedVisibility, OpenPlaneDoesNotShadowItself) {
  Renderer renderer;
  renderer.set_scene(box(1));
  renderer.set_environment(constant_sky(1.0f));
  FrameRequest request = octree_request(GetParam());
  request.camera.eye = {0.0f, 0.0f, 1.0f};
  request.camera.target = {0.0f, -1.0f, 0.0f};
  request.camera.fov_y_rad = 0.4f;
  EXPECT_NEAR(draw_traced(&renderer, request), 0.5, 0.01);
}

/// Under an open-topped box of height 2: the view factor of its 2 x 2 opening. Baked visibility may err by 20 %, rays
/// by 3. Source: Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3 (a quarter, from its
/// corner).
TEST_P(TracedVisibility, OpenTopLightsTheFloorByItsViewFactor) {
  Renderer renderer;
  renderer.set_scene(box(5));
  renderer.set_environment(constant_sky(1.0f));
  FrameRequest request = octree_request(GetParam());
  request.samples = 256;
  request.camera.eye = {0.0f, 0.9f, 0.0f};
  request.camera.target = {0.0f, -1.0f, 0.0f};
  request.camera.up = {0.0f, 0.0f, -1.0f};
  request.camera.fov_y_rad = 0.1f;
  const double x = 0.5, root = std::sqrt(1.25);
  const double factor = 4.0 * (x / root) * std::atan(x / root) / 3.14159265358979;
  EXPECT_NEAR(draw_traced(&renderer, request), 0.5 * factor, 0.03 * 0.5 * factor);
}

/// A wall moves; the picture follows without loading the scene again.
TEST_P(TracedVisibility, FollowsChangedGeometry) {
  Renderer renderer;
  renderer.set_scene(box(6));
  renderer.set_environment(constant_sky(1.0f));
  FrameRequest request = octree_request(GetParam());
  request.camera.eye = {0.0f, 0.5f, 0.0f};
  request.camera.target = {0.0f, -1.0f, 0.0f};
  request.camera.up = {0.0f, 0.0f, -1.0f};
  EXPECT_LT(draw_traced(&renderer, request), 1e-3);
  renderer.set_node_visible(5, false);
  EXPECT_GT(draw_traced(&renderer, request), 0.1);
  renderer.set_node_visible(5, true);
  EXPECT_LT(draw_traced(&renderer, request), 1e-3);
}

}  // namespace
}  // namespace maquette
