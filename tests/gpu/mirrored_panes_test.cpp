// What a mirror shows through panes, `--reflections auto`, and when maps and indirect light are wanted in the open.
#include "render/frame/planning.h"
#include "render/math/shared_formulas.h"
#include "tests/gpu/reflections_fixture.h"

namespace maquette::test {
namespace {

class MirroredPanes : public ::testing::Test {
 protected:
  static const LeftOut* left_out(const FramePlan& plan, const std::string& what) {
    for (const LeftOut& entry : plan.left_out)
      if (entry.what == what) return &entry;
    return nullptr;
  }
  FramePlan plan_of(const Scene& scene, const FrameRequest& request) {
    renderer_.set_scene(std::make_shared<Scene>(scene));
    renderer_.set_environment(constant_sky(1.0f));
    EXPECT_TRUE(renderer_.finish_background_work(request));
    return renderer_.render(request).plan;
  }

  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
};

/// A mirror that faces a wall, which glows, and between them a tinted pane that hides the wall's left half: what the
/// mirror shows of that half is dimmed by the pane's transmittance, in every technique.
TEST_F(MirroredPanes, DimWhatIsMirroredBehindThem) {
  Scene scene;
  Material glow = plain("glow", glm::vec3(0.0f));
  glow.emissive = {3.0f, 2.0f, 1.0f};
  Material pane = clear_pane();
  pane.name = "pane";
  pane.ior = 1.5f;
  pane.base_color = {0.8f, 0.5f, 0.25f, 1.0f};
  scene.materials = {glow, pane, plain("unused", glm::vec3(0.0f)), mirror_metal()};
  add(&scene, make_grid({-3.0f, -3.0f, 3.0f}, {0, 6, 0}, {6, 0, 0}, 8, 0), "wall");
  add(&scene, make_grid({-3.0f, -3.0f, 2.5f}, {3, 0, 0}, {0, 6, 0}, 8, 1), "pane");
  add_patch(&scene, 0.0f);
  scene.patches[0].reflector = true;
  renderer_.set_scene(std::make_shared<Scene>(scene));
  renderer_.set_environment(constant_sky(0.0f));
  for (const char* technique : {"raytraced", "octree", "triangle", "bezier"})
    for (const char* visibility : {"auto", "none"}) {
      FrameRequest r = request_of(technique);
      r.reflectors = {"mirror"};
      r.mode = "uniform";
      r.camera.eye = {0.0f, 0.0f, 1.8f};
      r.settings.set_from_text("shading.visibility", visibility);
      r.settings.set_from_text("shading.indirect", "none");
      const Image seen = draw_reflection(&renderer_, r);
      // The mirror lies at z = -1: what it shows at a pixel is the wall's point in that direction, 4 m behind it.
      int through = 0, beside = 0;
      for (int y = 40; y < 88; y += 6)
        for (int x = 40; x < 152; x += 4) {
          const double half = std::tan(0.25), dx = (2.0 * (x + 0.5) / 192.0 - 1.0) * half * 1.5,
                       dy = (1.0 - 2.0 * (y + 0.5) / 128.0) * half;
          const double at_pane_x = dx * (2.8 + 3.5), cosine = 1.0 / std::sqrt(1.0 + dx * dx + dy * dy);
          if (std::abs(at_pane_x) < 0.15) continue;
          const bool dimmed = at_pane_x < 0.0;
          (dimmed ? through : beside) += 1;
          for (int c : {0, 1, 2}) {
            const float share =
                dimmed ? shared::fresnel_pane(static_cast<float>(cosine), 1.5f, pane.base_color[c]).y : 1.0f;
            ASSERT_NEAR(seen.at(x, y, c), glow.emissive[c] * share, 0.02f * glow.emissive[c])
                << technique << ", " << visibility << ", " << x << ", " << y;
          }
        }
      EXPECT_GT(through, 50) << technique;
      EXPECT_GT(beside, 50) << technique;
    }
}

TEST_F(MirroredPanes, AutoIsTheExactTechniqueWhereSomethingReflects) {
  FrameRequest r = request_of("auto");
  Scene scene = room();
  FramePlan plan = plan_of(scene, r);
  EXPECT_EQ(plan.reflections, "");
  add_patch(&scene, 0.1f);
  plan = plan_of(scene, r);
  EXPECT_EQ(plan.reflections, "raytraced");
  // At rest in full resolution: steps of two pixels vanish.
  r.settings.reset("reflections.resolution");
  EXPECT_TRUE(renderer_.finish_background_work(r));
  const auto steps = [&] {
    const Image image = renderer_.read_debug_view("reflection");
    return image.width;
  };
  renderer_.render(r, true);
  EXPECT_EQ(steps(), r.width / 2);
  renderer_.render(r, true);
  EXPECT_EQ(steps(), r.width);
}

/// Maps and indirect light are wanted where surfaces hide the sky from each other, however far the scene is open.
TEST_F(MirroredPanes, OpenScenesHaveIndirectLightWherePartsFaceEachOther) {
  FrameRequest r = request_of("off");
  r.mode = "uniform";
  Scene alone;
  alone.materials = {plain("grey", glm::vec3(0.5f))};
  alone.materials[0].double_sided = false;
  add_box(&alone, {-1, -1, -1}, {1, 1, 1}, 0);
  const FramePlan single = plan_of(alone, r);
  ASSERT_TRUE(left_out(single, "visibility"));
  EXPECT_EQ(left_out(single, "visibility")->decided_by, kScene);
  EXPECT_EQ(single.shading().indirect, "none");
  EXPECT_TRUE(single.shading().shadow_rays);
  Scene floor = alone;
  add(&floor, make_grid({-50, -1, 50}, {100, 0, 0}, {0, 0, -100}, 4, 0), "floor");
  const FramePlan both = plan_of(floor, r);
  EXPECT_EQ(both.shading().visibility, "baked");
  EXPECT_EQ(both.shading().indirect, "baked");
}

}  // namespace
}  // namespace maquette::test
