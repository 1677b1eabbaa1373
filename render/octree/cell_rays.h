#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <type_traits>

#include "render/octree/octree_build.h"

namespace maquette {

/// Shadow rays among the surfaces of an octree, in finest cells from the root's corner. Cut-out surfaces do not block
/// them.
class CellRays {
 public:
  CellRays(const OctreeSource& source, const OctreeGrid& grid);
  /// True when nothing is hit between `from` and `from + distance * direction`.
  bool free(const glm::vec3& from, const glm::vec3& direction, float distance) const;

 private:
  struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  };
  struct ReleaseScene {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene> scene_;
};

}  // namespace maquette
