#pragma once

#include <embree3/rtcore.h>

#include <cstring>
#include <glm/glm.hpp>

namespace maquette {

/// From `near` to `far`, in lengths of the direction.
inline RTCRay embree_ray(const glm::vec3& origin, const glm::vec3& direction, float near, float far) {
  RTCRay ray;
  // Embree reads four floats at once: they come straight from a store of all four, and not from four stores.
  using Four = float __attribute__((vector_size(16)));
  const Four from{origin.x, origin.y, origin.z, near}, along{direction.x, direction.y, direction.z, 0.0f};
  std::memcpy(&ray.org_x, &from, sizeof from);
  std::memcpy(&ray.dir_x, &along, sizeof along);
  ray.tfar = far;
  ray.mask = ~0u;
  ray.id = ray.flags = 0;
  return ray;
}

}  // namespace maquette
