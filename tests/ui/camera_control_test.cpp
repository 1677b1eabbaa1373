#include "ui/camera_control.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

namespace maquette {
namespace {

CameraView sample_camera() {
  CameraView camera;
  camera.eye = {3.0f, 1.0f, 4.0f};
  camera.target = {0.5f, 0.5f, 0.0f};
  camera.fov_y_rad = 0.7f;
  return camera;
}

float distance(const CameraView& camera) { return glm::length(camera.target - camera.eye); }
glm::vec3 forward(const CameraView& camera) { return glm::normalize(camera.target - camera.eye); }

/// Picture coordinates, y down, in a picture of this height and square pixels.
glm::vec2 project(const CameraView& camera, const glm::vec3& point, float height) {
  const glm::vec3 f = forward(camera), r = glm::normalize(glm::cross(f, camera.up)), u = glm::cross(r, f);
  const glm::vec3 d = point - camera.eye;
  const float scale = 0.5f * height / std::tan(0.5f * camera.fov_y_rad) / glm::dot(d, f);
  return {glm::dot(d, r) * scale, -glm::dot(d, u) * scale};
}

TEST(CameraControl, OrbitKeepsTargetAndDistance) {
  CameraView camera = sample_camera();
  const CameraView before = camera;
  orbit(&camera, 0.8f, -0.3f);
  EXPECT_EQ(camera.target, before.target);
  EXPECT_NEAR(distance(camera), distance(before), 1e-5f);
  EXPECT_GT(glm::length(camera.eye - before.eye), 0.5f);
  orbit(&camera, -0.8f, 0.3f);
  EXPECT_NEAR(glm::length(camera.eye - before.eye), 0.0f, 1e-4f);
}

TEST(CameraControl, OrbitTurnsByTheAngleAsked) {
  CameraView camera;
  camera.eye = {0.0f, 0.0f, 2.0f};
  orbit(&camera, glm::half_pi<float>(), 0.0f);
  EXPECT_NEAR(camera.eye.x, 2.0f, 1e-5f);
  EXPECT_NEAR(camera.eye.z, 0.0f, 1e-5f);
}

TEST(CameraControl, NeverPassesThePole) {
  CameraView camera = sample_camera();
  for (int i = 0; i < 50; ++i) orbit(&camera, 0.0f, -0.4f);
  EXPECT_LT(forward(camera).y, -0.99f);
  EXPECT_GT(forward(camera).y, -1.0f);
  for (int i = 0; i < 50; ++i) look_around(&camera, 0.1f, 0.4f);
  EXPECT_GT(forward(camera).y, 0.99f);
  EXPECT_TRUE(std::isfinite(camera.target.x));
}

TEST(CameraControl, PanFollowsTheMouse) {
  CameraView camera = sample_camera();
  const glm::vec3 point = camera.target;
  pan(&camera, 37.0f, -12.0f, 600.0f);
  const glm::vec2 now = project(camera, point, 600.0f);
  EXPECT_NEAR(now.x, 37.0f, 1e-2f);
  EXPECT_NEAR(now.y, -12.0f, 1e-2f);
}

TEST(CameraControl, DollyNeverReachesTheTarget) {
  CameraView camera = sample_camera();
  const float before = distance(camera);
  dolly(&camera, 1.0f);
  EXPECT_NEAR(distance(camera), 0.9f * before, 1e-5f);
  for (int i = 0; i < 1000; ++i) dolly(&camera, 40.0f);
  EXPECT_GT(distance(camera), 0.0f);
}

TEST(CameraControl, PivotDoesNotMoveThePicture) {
  CameraView camera = sample_camera();
  const glm::vec3 before = forward(camera);
  set_target_distance(&camera, 0.35f);
  EXPECT_NEAR(distance(camera), 0.35f, 1e-6f);
  EXPECT_NEAR(glm::length(forward(camera) - before), 0.0f, 1e-5f);
  set_target_distance(&camera, -1.0f);
  EXPECT_NEAR(distance(camera), 0.35f, 1e-6f);
}

TEST(CameraControl, FrameShowsTheWholeBox) {
  const Bounds bounds{{-2.0f, -1.0f, 3.0f}, {5.0f, 1.5f, 4.0f}};
  for (const float aspect : {0.4f, 1.0f, 2.5f}) {
    CameraView camera = sample_camera();
    frame_bounds(&camera, bounds, aspect);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 p(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                        corner & 4 ? bounds.max.z : bounds.min.z);
      const glm::vec2 at = project(camera, p, 2.0f);
      EXPECT_LE(std::abs(at.x), aspect) << "aspect " << aspect;
      EXPECT_LE(std::abs(at.y), 1.0f) << "aspect " << aspect;
    }
  }
}

TEST(CameraControl, ANarrowPictureKeepsTheWidthOnce) {
  CameraView camera = sample_camera();
  const float half = std::tan(0.5f * camera.fov_y_rad);
  camera.aspect = 1.6f;
  fit_aspect(&camera, 0.8f);
  EXPECT_NEAR(std::tan(0.5f * camera.fov_y_rad), 2.0f * half, 1e-5f);
  fit_aspect(&camera, 0.4f);
  EXPECT_NEAR(std::tan(0.5f * camera.fov_y_rad), 2.0f * half, 1e-5f);
  camera.aspect = 1.6f;
  fit_aspect(&camera, 2.0f);
  EXPECT_NEAR(std::tan(0.5f * camera.fov_y_rad), 2.0f * half, 1e-5f);
}

/// Of parallel rays, in pixels of half the height.
glm::vec2 project_parallel(const CameraView& camera, const glm::vec3& p) {
  const glm::vec3 right = glm::normalize(glm::cross(forward(camera), camera.up));
  const glm::vec3 d = p - camera.eye;
  return glm::vec2(glm::dot(d, right), glm::dot(d, glm::cross(right, forward(camera)))) * (2.0f / camera.height_m);
}

TEST(CameraControl, OrthographicKeepsTheSizeAtTheTarget) {
  CameraView camera = sample_camera();
  const float height = camera.height_at(distance(camera));
  set_orthographic(&camera, true);
  EXPECT_FLOAT_EQ(camera.height_m, height);
  const glm::vec3 eye = camera.eye;
  dolly(&camera, 1.0f);
  EXPECT_FLOAT_EQ(camera.height_m, 0.9f * height);
  EXPECT_EQ(camera.eye, eye);
  set_orthographic(&camera, false);
  EXPECT_NEAR(camera.height_at(distance(camera)), 0.9f * height, 1e-5f);
}

TEST(CameraControl, OrthographicPanMovesAsMuchAsThePointer) {
  CameraView camera = sample_camera();
  set_orthographic(&camera, true);
  const glm::vec3 p(0.3f, 0.2f, 0.1f);
  const glm::vec2 before = project_parallel(camera, p);
  pan(&camera, 30.0f, -20.0f, 200.0f);
  const glm::vec2 moved = project_parallel(camera, p) - before;
  EXPECT_NEAR(moved.x, 0.3f, 1e-5f);
  EXPECT_NEAR(moved.y, 0.2f, 1e-5f);
}

TEST(CameraControl, OrthographicFrameShowsTheWholeBox) {
  const Bounds bounds{{-2.0f, -1.0f, 3.0f}, {5.0f, 1.5f, 4.0f}};
  for (const float aspect : {0.4f, 1.0f, 2.5f}) {
    CameraView camera = sample_camera();
    set_orthographic(&camera, true);
    frame_bounds(&camera, bounds, aspect);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 p(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                        corner & 4 ? bounds.max.z : bounds.min.z);
      const glm::vec2 at = project_parallel(camera, p);
      EXPECT_LE(std::abs(at.x), aspect) << "aspect " << aspect;
      EXPECT_LE(std::abs(at.y), 1.0f) << "aspect " << aspect;
      EXPECT_GT(glm::dot(p - camera.eye, forward(camera)), 0.0f);
    }
    camera.aspect = 1.6f;
    const float height = camera.height_m;
    fit_aspect(&camera, 0.8f);
    EXPECT_FLOAT_EQ(camera.height_m, 2.0f * height);
  }
}

TEST(CameraControl, FlyMovesAlongTheView) {
  CameraView camera = sample_camera();
  const CameraView before = camera;
  fly(&camera, {0.0f, 0.0f, 2.0f});
  EXPECT_NEAR(glm::length(camera.eye - (before.eye + 2.0f * forward(before))), 0.0f, 1e-5f);
  EXPECT_NEAR(distance(camera), distance(before), 1e-5f);
}

}  // namespace
}  // namespace maquette
