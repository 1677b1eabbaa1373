#pragma once

#include <glm/glm.hpp>

namespace maquette::test {

/// What shaders/octree/trace_rays.comp reads and writes.
struct RayRecord {
  glm::vec3 origin{};
  float t_min;
  glm::vec3 direction{};
  float t_max, t_box, width, spread, unused;
};
struct HitRecord {
  float t;
  int node, level, steps;
};

}  // namespace maquette::test
