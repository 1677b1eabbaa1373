#include "render/frame/constants.h"

#include <cmath>

#include "render/frame/camera.h"

namespace maquette {

FrameConstants make_frame_constants(const SceneState& scene, const FrameRequest& request, const GridSize& size) {
  const CameraFrame camera = make_camera_frame(request.camera, request.width, request.height, scene.bounds());
  const EnvironmentBuffers& environment = scene.environment();
  FrameConstants c{};
  c.clip_from_world = clip_from_world(camera);
  c.eye = glm::vec4(camera.eye, camera.orthographic ? 0.0f : 1.0f);
  c.forward = glm::vec4(camera.forward, 2.0f * camera.half_y / static_cast<float>(request.height * size.side));
  c.right = glm::vec4(camera.right * camera.half_x, 0.0f);
  c.up = glm::vec4(camera.up * camera.half_y, 0.0f);
  c.environment = glm::vec4(std::cos(request.env_rotation_rad), std::sin(request.env_rotation_rad), request.env_scale,
                            static_cast<float>(environment.tables().luminance_integral));
  c.size = glm::ivec4(size.grid_width(), size.grid_height(), size.side, 0);
  c.sampling = glm::ivec4(1, 2, 0, static_cast<int>(request.seed));
  c.environment_size = glm::ivec4(environment.environment().width, environment.environment().height, environment.bias(),
                                  EnvironmentBuffers::kListLength);
  const PackedSky& sky = environment.sky();
  c.sky_nodes = glm::ivec4(sky.columns, sky.spans, sky.last_row, sky.offset > 0.0f ? 1 : 0);
  c.bandwidth_size = glm::ivec4(environment.tables().bandwidth_width, environment.tables().bandwidth_height,
                                scene.lights() ? scene.lights()->count() : 0, 0);
  c.section = glm::vec3(camera.section) == glm::vec3(0.0f) ? glm::vec4(0.0f, 0.0f, 0.0f, 1.0f) : camera.section;
  c.quality = glm::vec4(1.0f, 1.0f, 0.0f, environment.sun_luminance());
  return c;
}

glm::vec3 from_eye(const FrameConstants& frame, const glm::vec3& world) {
  const glm::vec3 d = world - glm::vec3(frame.eye), forward(frame.forward);
  return frame.eye.w > 0.0f ? d : forward * glm::dot(forward, d);
}

float pixel_width(const FrameConstants& frame, float depth) {
  return (frame.eye.w > 0.0f ? depth : 1.0f) * frame.forward.w;
}

}  // namespace maquette
