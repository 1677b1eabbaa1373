#include "render/octree/cell_rays.h"

#include <cmath>
#include <vector>

#include "render/octree/octree_triangles.h"
#include "render/raytraced/embree_ray.h"
#include "render/raytraced/ray_device.h"
#include "scenes/error.h"

namespace maquette {

CellRays::CellRays(const OctreeSource& source, const OctreeGrid& grid) : device_(new_ray_device()) {
  if (!device_) throw Error("octree", "the ray tracer does not start", "see `maquette doctor`");
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  const double cells_per_m = std::exp2(grid.depth) / grid.side_m;
  std::vector<std::uint32_t> indices;
  for_each_triangle(source, [&](std::size_t first, std::size_t item) {
    if (source.textures.cut_out(source.materials[item])) return;
    for (std::size_t k = 0; k < 3; ++k) indices.push_back(source.geometry.indices[first + k]);
  });
  if (!indices.empty()) {
    RTCGeometry mesh = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto& positions = source.geometry.positions;
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, positions.size()));
    auto* corners = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, indices.size() / 3));
    if (!vertices || !corners) throw Error("octree", "not enough memory for the rays of cell BRDFs");
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const glm::dvec3 p = (glm::dvec3(positions[i]) - grid.corner) * cells_per_m;
      for (int axis = 0; axis < 3; ++axis)
        vertices[3 * i + static_cast<std::size_t>(axis)] = static_cast<float>(p[axis]);
    }
    std::copy(indices.begin(), indices.end(), corners);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene_.get(), mesh);
    rtcReleaseGeometry(mesh);
  }
  rtcCommitScene(scene_.get());
}

bool CellRays::free(const glm::vec3& from, const glm::vec3& direction, float distance) const {
  if (!(distance > 0.0f)) return true;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = embree_ray(from, direction, 0.0f, distance);
  rtcOccluded1(scene_.get(), &context, &ray);
  return ray.tfar >= 0.0f;
}

}  // namespace maquette
