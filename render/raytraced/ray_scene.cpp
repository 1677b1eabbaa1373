#include "render/raytraced/ray_scene.h"

#include <algorithm>

#include "render/raytraced/embree_ray.h"
#include "render/raytraced/ray_device.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr float kFar = 1e30f;

}  // namespace

std::optional<RayScene::Hit> RayScene::nearest(const glm::vec3& origin, const glm::vec3& direction, float near) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query{};
  query.ray = embree_ray(origin, direction, near, kFar);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return Hit{numbers[query.hit.primID], query.ray.tfar};
}

bool RayScene::is_blocked(const glm::vec3& origin, const glm::vec3& direction, float near) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = embree_ray(origin, direction, near, kFar);
  rtcOccluded1(scene.get(), &context, &ray);
  return ray.tfar < 0.0f;
}

RayScene build_ray_scene(const FlatGeometry& geometry, const std::vector<bool>& occluding) {
  RayScene out;
  std::vector<std::uint32_t> indices;
  for (std::size_t i = 0; i < geometry.items.size(); ++i) {
    if (!occluding[i]) continue;
    const DrawItem& item = geometry.items[i];
    for (std::uint32_t k = 0; k < item.index_count; ++k) indices.push_back(geometry.indices[item.first_index + k]);
    for (std::uint32_t k = 0; k < item.index_count / 3; ++k) out.numbers.push_back(item.first_index / 3 + k);
  }
  out.device = RayScene::DevicePointer(new_ray_device(), &rtcReleaseDevice);
  out.scene = RayScene::ScenePointer(rtcNewScene(out.device.get()), &rtcReleaseScene);
  rtcSetSceneFlags(out.scene.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry mesh = rtcNewGeometry(out.device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* p = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, geometry.positions.size());
  auto* t = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, indices.size() / 3);
  if (p && t && !indices.empty()) {
    std::copy_n(geometry.positions.data(), geometry.positions.size(), static_cast<glm::vec3*>(p));
    std::copy_n(indices.data(), indices.size(), static_cast<std::uint32_t*>(t));
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(out.scene.get(), mesh);
  }
  rtcReleaseGeometry(mesh);
  rtcCommitScene(out.scene.get());
  if (rtcGetDeviceError(out.device.get()) != RTC_ERROR_NONE)
    throw Error("--reflections", "the ray tracer could not be built", "free some memory");
  return out;
}

}  // namespace maquette
