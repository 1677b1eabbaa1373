#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "render/scene_state/geometry.h"

namespace maquette {

/// Triangles of the occluding items in Embree, and the index of each in the scene's index buffer.
struct RayScene {
  using DevicePointer = std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(&rtcReleaseDevice)>;
  using ScenePointer = std::unique_ptr<std::remove_pointer_t<RTCScene>, decltype(&rtcReleaseScene)>;
  DevicePointer device{nullptr, &rtcReleaseDevice};
  ScenePointer scene{nullptr, &rtcReleaseScene};
  std::vector<std::uint32_t> numbers;

  struct Hit {
    std::uint32_t triangle = 0;
    float distance = 0.0f;  ///< in multiples of the direction's length
  };
  /// First triangle hit at `near` (in multiples of the direction's length) or beyond.
  std::optional<Hit> nearest(const glm::vec3& origin, const glm::vec3& direction, float near) const;
  bool is_blocked(const glm::vec3& origin, const glm::vec3& direction, float near) const;
};

/// `occluding[i]`: include item i. Throws Error when memory is insufficient.
RayScene build_ray_scene(const FlatGeometry& geometry, const std::vector<bool>& occluding);

}  // namespace maquette
