#pragma once

#include <embree3/rtcore.h>

#include <glm/glm.hpp>

namespace maquette {

/// From `near` to `far`, in lengths of the direction.
inline RTCRay embree_ray(const glm::vec3& origin, const glm::vec3& direction, float near, float far) {
  RTCRay ray{};
  ray.org_x = origin.x;
  ray.org_y = origin.y;
  ray.org_z = origin.z;
  ray.tnear = near;
  ray.dir_x = direction.x;
  ray.dir_y = direction.y;
  ray.dir_z = direction.z;
  ray.tfar = far;
  ray.mask = ~0u;
  return ray;
}

}  // namespace maquette
