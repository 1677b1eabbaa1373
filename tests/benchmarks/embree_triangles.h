#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <vector>

namespace maquette::bench {

/// Embree over single triangles, without the product's pairs and filters: a committed scene, which the caller releases.
/// `indices`: three corners of every triangle.
inline RTCScene build_embree_triangles(RTCDevice device, const std::vector<glm::vec3>& positions,
                                       const std::vector<std::uint32_t>& indices) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  std::memcpy(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, positions.size()),
              positions.data(), 12 * positions.size());
  std::memcpy(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, indices.size() / 3),
              indices.data(), 4 * indices.size());
  rtcCommitGeometry(mesh);
  rtcAttachGeometry(scene, mesh);
  rtcReleaseGeometry(mesh);
  rtcCommitScene(scene);
  return scene;
}

}  // namespace maquette::bench
