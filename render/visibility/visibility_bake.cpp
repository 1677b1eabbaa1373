#include "render/visibility/visibility_bake.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <type_traits>

#include "render/math/shared_formulas.h"
#include "render/raytraced/ray_device.h"
#include "render/visibility/visibility_points.h"
#include "scenes/error.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kDirectionCount = kVisibilitySide * kVisibilitySide;
constexpr int kPacket = 16;  // 4 x 4 cells: rays of one origin within 45 degrees
/// Smallest elevation of rays above the tangent plane (sine).
constexpr float kMinElevation = 0.01f;
constexpr std::size_t kPointsPerTask = 16;
static_assert(kVisibilitySide == shared::kVisibilityCells);

using DevicePointer = std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(&rtcReleaseDevice)>;
using ScenePointer = std::unique_ptr<std::remove_pointer_t<RTCScene>, decltype(&rtcReleaseScene)>;

/// Cancels a running build: Embree calls this between its tasks.
bool continue_build(void* cancel, double) { return !static_cast<const std::atomic<bool>*>(cancel)->load(); }

struct Triangles {
  std::vector<glm::vec3> positions;
  std::vector<std::array<std::uint32_t, 3>> indices;
};

/// Null when cancelled. Embree copies the buffers (it reads 16 bytes from the last vertex). `filter`: may be null.
ScenePointer build_triangles(RTCDevice device, const Triangles& triangles, RTCFilterFunctionN filter, void* user,
                             const std::atomic<bool>& cancel) {
  ScenePointer scene(rtcNewScene(device), &rtcReleaseScene);
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* positions = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                            triangles.positions.size());
  void* indices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t),
                                          triangles.indices.size());
  if (positions && indices) {
    std::memcpy(positions, triangles.positions.data(), triangles.positions.size() * sizeof(glm::vec3));
    std::memcpy(indices, triangles.indices.data(), triangles.indices.size() * sizeof(triangles.indices[0]));
    rtcSetGeometryUserData(mesh, user);
    rtcSetGeometryOccludedFilterFunction(mesh, filter);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene.get(), mesh);
  }
  rtcReleaseGeometry(mesh);
  rtcSetSceneProgressMonitorFunction(scene.get(), continue_build, const_cast<std::atomic<bool>*>(&cancel));
  if (positions && indices) rtcCommitScene(scene.get());
  const RTCError error = rtcGetDeviceError(device);
  if (cancel) return {nullptr, &rtcReleaseScene};
  if (error != RTC_ERROR_NONE) {
    throw Error("visibility",
                "the ray tracer could not take " + std::to_string(triangles.indices.size()) + " triangles",
                "free memory, or set shading.visibility=none");
  }
  return scene;
}

/// One ray per cell, through its centre: the bilinear lookup is then a tent filter that neither shifts nor roughens
/// shadows. Jitter inside the cell was worse, measured on a floor under a pillared roof, 3 cm between vertices, against
/// 200 jittered bakes: RMS of the sky fraction 1.4 % (centres), 2.3 % (jitter by vertex); difference between neighbours
/// 1.7 %, 3.2 %; shadow of a sun 0.14, 0.19.
struct CellDirections {
  std::array<glm::vec3, kDirectionCount> direction{};
  CellDirections() {
    for (int b = 0; b < kDirectionCount; ++b) {
      direction[static_cast<std::size_t>(b)] =
          shared::visibility_cell_direction(glm::ivec2(b % kVisibilitySide, b / kVisibilitySide));
    }
  }
};

/// The ray of a cell. It starts on the side of the surface that the cell belongs to, and is mirrored to that side when
/// the cell's direction lies across the surface.
struct CellRay {
  glm::vec3 origin{};
  glm::vec3 direction{};
};

CellRay make_ray(const VisibilityPoint& at, const glm::vec3& w) {
  const float elevation = glm::dot(at.normal, w);
  const float side = elevation > -at.horizon_slack ? 1.0f : -1.0f;
  CellRay ray{at.position + at.inset + at.normal * (side * at.lift), w};
  const float above = side * elevation;
  const float wanted = std::max(std::abs(above), kMinElevation);
  if (wanted != above) ray.direction = glm::normalize(w + at.normal * (side * (wanted - above)));
  return ray;
}

/// Sixteen rays of one origin. Those that are not set are zero: where Embree has its assertions on and traces eight at
/// once, it looks at them too.
struct Packet {
  alignas(64) int valid[kPacket] = {};
  RTCRay16 rays = {};
  void set(int i, const CellRay& ray) {
    valid[i] = -1;
    rays.org_x[i] = ray.origin.x;
    rays.org_y[i] = ray.origin.y;
    rays.org_z[i] = ray.origin.z;
    rays.dir_x[i] = ray.direction.x;
    rays.dir_y[i] = ray.direction.y;
    rays.dir_z[i] = ray.direction.z;
    rays.tnear[i] = 0.0f;
    rays.tfar[i] = std::numeric_limits<float>::infinity();
    rays.time[i] = 0.0f;
    rays.mask[i] = 0xffffffffu;
    rays.id[i] = static_cast<unsigned>(i);
    rays.flags[i] = 0;
  }
};

VisibilityBits trace_point(RTCScene scene, const VisibilityPoint& at, const CellDirections& cells) {
  VisibilityBits bits{};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  Packet packet;
  for (int block = 0; block < kDirectionCount / kPacket; ++block) {
    int bit[kPacket];
    for (int i = 0; i < kPacket; ++i) {
      const int x = 4 * (block & 3) + (i & 3);
      const int y = 4 * (block >> 2) + (i >> 2);
      bit[i] = y * kVisibilitySide + x;
      packet.set(i, make_ray(at, cells.direction[static_cast<std::size_t>(bit[i])]));
    }
    rtcOccluded16(packet.valid, scene, &context, &packet.rays);
    for (int i = 0; i < kPacket; ++i) {
      const bool open = packet.rays.tfar[i] >= 0.0f;  // Embree marks a hit with -infinity
      if (open) bits[static_cast<std::size_t>(bit[i] >> 5)] |= 1u << (bit[i] & 31);
    }
  }
  return bits;
}

/// The panes of the scene, in the units of the points, and the transmittance of each triangle.
struct Panes {
  Triangles triangles;
  std::vector<Passage> passages;  ///< of each triangle
};

Panes find_panes(const FlatGeometry& geometry, const std::vector<bool>& transmits, const std::vector<Passage>& passages,
                 const VisibilityPoints& points) {
  Panes panes;
  for (std::size_t item = 0; item < std::min(passages.size(), geometry.items.size()); ++item) {
    if (!transmits[item] || passages[item] == Passage{}) continue;
    const DrawItem& drawn = geometry.items[item];
    for (std::uint32_t k = drawn.first_index; k + 2 < drawn.first_index + drawn.index_count; k += 3) {
      const auto first = static_cast<std::uint32_t>(panes.triangles.positions.size());
      for (std::uint32_t corner = 0; corner < 3; ++corner)
        panes.triangles.positions.emplace_back(
            (glm::dvec3(geometry.positions[geometry.indices[k + corner]]) - points.center) / points.scale_m);
      panes.triangles.indices.push_back({first, first + 1, first + 2});
      panes.passages.push_back(passages[item]);
    }
  }
  return panes;
}

struct PassingContext {
  RTCIntersectContext base;  // first member: Embree passes back a pointer to it
  float transmittance[kPacket];
};

/// Records each pane on the way and lets the ray continue.
void pass_pane(const RTCFilterFunctionNArguments* args) {
  const auto& passages = static_cast<const Panes*>(args->geometryUserPtr)->passages;
  auto* context = reinterpret_cast<PassingContext*>(args->context);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    args->valid[i] = 0;
    const glm::vec3 direction(RTCRayN_dir_x(args->ray, args->N, i), RTCRayN_dir_y(args->ray, args->N, i),
                              RTCRayN_dir_z(args->ray, args->N, i));
    const glm::vec3 normal(RTCHitN_Ng_x(args->hit, args->N, i), RTCHitN_Ng_y(args->hit, args->N, i),
                           RTCHitN_Ng_z(args->hit, args->N, i));
    const Passage& passage = passages[RTCHitN_primID(args->hit, args->N, i)];
    const float length = glm::length(normal) * glm::length(direction);
    const float cosine = length > 0.0f ? std::min(std::abs(glm::dot(direction, normal)) / length, 1.0f) : 1.0f;
    context->transmittance[RTCRayN_id(args->ray, args->N, i)] *=
        passage.share * shared::fresnel_pane(cosine, passage.ior, passage.inside).y;
  }
}

/// Mean over up to sixteen open cells on each side.
glm::vec2 trace_transmittance(RTCScene scene, const VisibilityPoint& at, const VisibilityBits& bits,
                              const CellDirections& cells) {
  glm::vec2 mean(1.0f);
  for (int side = 0; side < 2; ++side) {
    const glm::vec3 normal = side == 0 ? at.normal : -at.normal;
    std::array<std::size_t, kDirectionCount> open;
    std::size_t count = 0;
    for (std::size_t b = 0; b < kDirectionCount; ++b)
      if (((bits[b >> 5] >> (b & 31u)) & 1u) && glm::dot(normal, cells.direction[b]) > 0.0f) open[count++] = b;
    if (count == 0) continue;
    Packet packet;
    PassingContext context;
    rtcInitIntersectContext(&context.base);
    float weight[kPacket] = {};
    const std::size_t rays = std::min<std::size_t>(count, kPacket);
    for (std::size_t i = 0; i < rays; ++i) {
      const glm::vec3& direction = cells.direction[open[(2 * i + 1) * count / (2 * rays)]];
      packet.set(static_cast<int>(i), make_ray(at, direction));
      context.transmittance[i] = 1.0f;
      weight[i] = glm::dot(normal, direction);
    }
    rtcOccluded16(packet.valid, scene, &context.base, &packet.rays);
    float sum = 0.0f, weights = 0.0f;
    for (std::size_t i = 0; i < rays; ++i) {
      sum += weight[i] * context.transmittance[i];
      weights += weight[i];
    }
    mean[side] = sum / weights;
  }
  return mean;
}

/// Calls back from one thread at a time, at most about 200 times, with increasing values.
class ProgressReport {
 public:
  ProgressReport(const std::function<void(double)>& report, std::size_t total) : report_(report), total_(total) {}
  void add(std::size_t done) {
    const std::size_t now = done_.fetch_add(done) + done;
    if (!report_ || now * 200 / total_ == (now - done) * 200 / total_) return;
    const std::lock_guard lock(mutex_);
    if (now > reported_) report_(static_cast<double>(reported_ = now) / static_cast<double>(total_));
  }

 private:
  const std::function<void(double)>& report_;
  std::size_t total_;
  std::atomic<std::size_t> done_{0};
  std::size_t reported_ = 0;
  std::mutex mutex_;
};

struct Traced {
  std::vector<VisibilityBits> bits;
  std::vector<glm::vec2> transmittance;
};

Traced trace_points(const VisibilityPoints& points, const Panes& panes, const std::atomic<bool>& cancel,
                    const std::function<void(double)>& progress) {
  Traced traced;
  traced.bits.resize(points.points.size());
  traced.transmittance.assign(points.points.size(), glm::vec2(1.0f));
  if (points.triangles.empty())
    for (VisibilityBits& open : traced.bits) open.fill(0xffffffffu);
  if (points.triangles.empty() && panes.passages.empty()) return traced;
  const DevicePointer device(new_ray_device(), &rtcReleaseDevice);
  if (!device) throw Error("visibility", "the ray tracer does not start", "set shading.visibility=none");
  Triangles occluders{{}, points.triangles};
  for (const VisibilityPoint& point : points.points) occluders.positions.push_back(point.position);
  const ScenePointer scene = build_triangles(device.get(), occluders, nullptr, nullptr, cancel);
  const ScenePointer pane_scene =
      build_triangles(device.get(), panes.triangles, pass_pane, const_cast<Panes*>(&panes), cancel);
  if (!scene || !pane_scene) return traced;
  const CellDirections cells;
  ProgressReport report(progress, points.points.size());
  parallel_ranges<std::size_t>(0, points.points.size(), kPointsPerTask, [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      if (cancel) return;
      const VisibilityPoint& at = points.points[i];
      if (!points.triangles.empty()) traced.bits[i] = trace_point(scene.get(), at, cells);
      if (!panes.passages.empty())
        traced.transmittance[i] = trace_transmittance(pane_scene.get(), at, traced.bits[i], cells);
    }
    report.add(range.size());
  });
  return traced;
}

}  // namespace

std::optional<VisibilityBake> bake_visibility(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                                              const std::vector<Passage>& passages, const std::atomic<bool>& cancel,
                                              const std::function<void(double)>& progress) {
  if (cancel) return std::nullopt;
  const VisibilityPoints points = build_visibility_points(geometry, transmits, cancel);
  if (cancel) return std::nullopt;
  const Traced traced = trace_points(points, find_panes(geometry, transmits, passages, points), cancel, progress);
  if (cancel) return std::nullopt;
  const std::vector<float> bandwidth = compute_visibility_bandwidth(points, traced.bits);
  VisibilityBake bake;
  VisibilityBits open;
  open.fill(0xffffffffu);
  bake.vertices.assign(geometry.positions.size(), open);
  bake.bandwidth.assign(geometry.positions.size(), 0.0f);
  bake.transmittance.assign(geometry.positions.size(), glm::vec2(1.0f));
  for (std::size_t v = 0; v < points.point_of_vertex.size(); ++v) {
    const std::uint32_t point = points.point_of_vertex[v];
    if (point == kNoPoint) continue;
    bake.vertices[v] = traced.bits[point];
    bake.bandwidth[v] = bandwidth[point];
    bake.transmittance[v] = traced.transmittance[point];
  }
  if (cancel) return std::nullopt;
  if (progress) progress(1.0);
  return bake;
}

}  // namespace maquette
