// What a ray shows on the seen side of a section plane.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/frame/camera.h"

namespace maquette {
namespace {

TEST(SeenDepths, AreThoseOfSeenPoints) {
  std::mt19937 random(1);
  const auto real = [&](float reach) { return std::uniform_real_distribution<float>(-reach, reach)(random); };
  const auto point = [&](float reach) { return glm::vec3(real(reach), real(reach), real(reach)); };
  const Bounds bounds{glm::vec3(-1.0f), glm::vec3(1.0f)};
  for (int round = 0; round < 2000; ++round) {
    CameraView view;
    view.eye = point(5.0f);
    view.target = point(1.0f);
    view.height_m = round % 3 == 0 ? 2.0f : 0.0f;
    view.section = round % 50 == 0 ? glm::vec4(0.0f) : glm::vec4(glm::normalize(point(1.0f)), real(2.0f));
    const CameraFrame camera = make_camera_frame(view, 4, 3, bounds);
    const EyeRay ray = camera.ray_through({real(1.0f), real(1.0f)});
    const glm::vec2 depths = camera.seen_depths(ray);
    for (int k = 0; k < 40; ++k) {
      const float depth = 0.25f * static_cast<float>(k) + 0.01f;
      const double kept = static_cast<double>(view.section.w) -
                          glm::dot(glm::dvec3(view.section),
                                   glm::dvec3(ray.origin) + static_cast<double>(depth) * glm::dvec3(ray.direction));
      if (std::abs(kept) < 1e-4) continue;
      const bool seen = depth >= camera.near_m && (kept > 0.0 || view.section == glm::vec4(0.0f));
      EXPECT_EQ(depth >= depths.x && depth <= depths.y, seen) << round << " at " << depth << " m";
    }
  }
}

TEST(SeenDepths, ARayWithinThePlaneIsAllOrNothing) {
  CameraView view;
  view.eye = {0.0f, 0.0f, 3.0f};
  view.target = glm::vec3(0.0f);
  view.section = {0.0f, 1.0f, 0.0f, 0.5f};
  const CameraFrame camera = make_camera_frame(view, 4, 4, Bounds());
  const glm::vec2 seen = camera.seen_depths(camera.ray_through({0.0f, 0.0f}));
  EXPECT_GT(seen.y, 1e30f);
  view.section.w = -0.5f;
  const CameraFrame cut = make_camera_frame(view, 4, 4, Bounds());
  const glm::vec2 hidden = cut.seen_depths(cut.ray_through({0.0f, 0.0f}));
  EXPECT_GE(hidden.x, hidden.y);
}

}  // namespace
}  // namespace maquette
