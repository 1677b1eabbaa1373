#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "render/frame/request.h"
#include "render/scene_state/scene_state.h"

namespace maquette {

/// What a pixel shows.
struct Pick {
  bool hit = false;
  int node = -1;
  int primitive = -1;
  int material = -1;
  std::uint32_t triangle = 0;
  bool back = false;  ///< the side that its corners go round clockwise
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f, 1.0f, 0.0f};
};

/// Of a triangle of the scene that a ray through `position` along `ray` met.
Pick pick_triangle(const SceneState& scene, std::uint32_t triangle, const glm::vec3& position, const glm::vec3& ray);
/// By a ray through the pixel (from the top left). Every triangle is tried: a click is rare, and 360,000 take a few
/// milliseconds.
Pick pick_by_ray(const SceneState& scene, const FrameRequest& request, int x, int y);

}  // namespace maquette
