// `bezier.draw=points` on the cockpit's windshield: vertices are drawn where rays hit them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/environment.h"
#include "scenes/scene.h"
#include "viewer/session.h"

namespace maquette {
namespace {

class ReflectedPoints : public ::testing::Test {
 protected:
  /// Metres from the pane to the surface that each pixel mirrors; 0 for the sky, or without a pane.
  Image distances(const std::string& technique, const std::string& draw) {
    FrameRequest r;
    r.mode = "splitsum";
    r.width = 320;
    r.height = 180;
    r.reflections = technique;
    SceneOptions options;
    options.camera = "driver";
    r.camera = camera_of_options(*scene_, options);
    r.settings.set_from_text("reflections.resolution", "full");
    r.settings.set_from_text("bezier.draw", draw);
    EXPECT_TRUE(renderer_.finish_background_work(r));
    stats_ = renderer_.render(r);
    const Image image = renderer_.read_debug_view("reflection_distance");
    EXPECT_TRUE(take_gl_errors().empty());
    return image;
  }
  void SetUp() override {
    scene_ = std::make_shared<Scene>(load_scene("builtin:cockpit"));
    renderer_.set_scene(scene_);
    renderer_.set_environment(std::make_shared<Environment>(load_environment("builtin:clear-sky")));
  }
  GlContext context_ = GlContext::create_headless();
  std::shared_ptr<Scene> scene_;
  Renderer renderer_;
  FrameStats stats_;
};

TEST_F(ReflectedPoints, StandWhereRaysSeeThem) {
  const Image rays = distances("raytraced", "triangles"), points = distances("bezier", "points");
  EXPECT_GT(stats_.technique.at("reflected_triangles"), 5000.0);
  int count = 0, seen = 0, before = 0;
  for (int y = 1; y + 1 < rays.height; ++y)
    for (int x = 1; x + 1 < rays.width; ++x) {
      const float d = points.at(x, y, 0);
      if (!(d > 0.0f)) continue;
      float nearest = 1e30f;
      bool same = false;
      for (int k = 0; k < 9; ++k) {
        const float r = rays.at(x + k % 3 - 1, y + k / 3 - 1, 0);
        if (!(r > 0.0f)) continue;
        nearest = std::min(nearest, r);
        same = same || std::abs(r - d) < 0.02f * d;
      }
      ++count;
      seen += same;
      before += nearest < 1e30f && d < 0.97f * nearest;
    }
  EXPECT_GT(count, 2000);
  // Points behind surfaces are visible through the gaps between other points (every other one in this view), but none
  // is nearer than the hit of the ray.
  EXPECT_GT(seen, count / 3);
  EXPECT_LT(before, count / 100);
}

}  // namespace
}  // namespace maquette
