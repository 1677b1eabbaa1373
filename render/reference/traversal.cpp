#include "render/reference/traversal.h"

#include <array>
#include <cstring>

#include "render/embree_ray.h"
#include "render/low_discrepancy.h"
#include "render/reference/surface.h"
#include "scenes/error.h"

namespace maquette {

namespace {

/// What filters need to know of the ray that they are asked about.
struct RayContext {
  RTCIntersectContext base;  // first: Embree hands back a pointer to it
  const PathScene* scene;
  RayKind kind;
  std::uint32_t chance;
  Passage* passage;  ///< of shadow rays
};

bool all_taken(const glm::vec3& transmittance) { return !(transmittance.x + transmittance.y + transmittance.z > 0.0f); }

struct Candidate {
  std::uint32_t triangle;
  glm::vec2 barycentric;
  glm::vec3 direction;
  glm::vec3 geometric;
};

Candidate candidate_of(const PathScene& scene, const RTCFilterFunctionNArguments* args) {
  Candidate c;
  const unsigned mesh = RTCHitN_geomID(args->hit, args->N, 0);
  c.triangle = scene.mesh_begin[mesh] + RTCHitN_primID(args->hit, args->N, 0);
  c.barycentric = {RTCHitN_u(args->hit, args->N, 0), RTCHitN_v(args->hit, args->N, 0)};
  c.direction = {RTCRayN_dir_x(args->ray, args->N, 0), RTCRayN_dir_y(args->ray, args->N, 0),
                 RTCRayN_dir_z(args->ray, args->N, 0)};
  c.geometric = {RTCHitN_Ng_x(args->hit, args->N, 0), RTCHitN_Ng_y(args->hit, args->N, 0),
                 RTCHitN_Ng_z(args->hit, args->N, 0)};
  return c;
}

/// Of every mesh, for camera rays only (through the context).
void cull_backs(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const RayContext*>(args->context);
  const Candidate c = candidate_of(*context->scene, args);
  const bool single_sided = (context->scene->triangles[c.triangle].material & kBothSides) == 0;
  if (single_sided && glm::dot(c.geometric, c.direction) > 0.0f) args->valid[0] = 0;
}

/// Of the mesh that asks: whether a ray that looks for the nearest surface stops there.
void stop_at_covered(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const RayContext*>(args->context);
  const Candidate c = candidate_of(*context->scene, args);
  const TracedMaterial& m = context->scene->material_of(c.triangle);
  if (m.masked && alpha_at(*context->scene, c.triangle, c.barycentric) < m.values.alpha_cutoff) args->valid[0] = 0;
  if (m.blended && context->kind == RayKind::path) {
    const float u =
        static_cast<float>(mix_seed(context->chance, context->scene->triangles[c.triangle].source) >> 8) * 0x1p-24f;
    if (u >= alpha_at(*context->scene, c.triangle, c.barycentric)) args->valid[0] = 0;
  }
}

/// Of panes: what a shadow ray loses is reckoned once nothing has stopped it, as most are stopped, and by then the
/// panes have come from memory.
void pass_pane(const RTCFilterFunctionNArguments* args) {
  auto* context = reinterpret_cast<RayContext*>(args->context);
  if (context->kind == RayKind::link) return;
  const Candidate c = candidate_of(*context->scene, args);
  __builtin_prefetch(&context->scene->triangles[c.triangle]);
  Passage& passage = *context->passage;
  if (passage.pane_count == Passage::kMostPanes) {
    passage.transmittance = transmittance(*context->scene, c.direction, passage);
    passage.pane_count = 0;
    if (all_taken(passage.transmittance)) return;
  }
  passage.panes[passage.pane_count++] = {c.triangle, c.barycentric};
  args->valid[0] = 0;
}

/// Of the mesh that asks: what a shadow ray loses.
void take_share(const RTCFilterFunctionNArguments* args) {
  auto* context = reinterpret_cast<RayContext*>(args->context);
  const PathScene& scene = *context->scene;
  const Candidate c = candidate_of(scene, args);
  const TracedMaterial& m = scene.material_of(c.triangle);
  if (m.masked) {
    if (alpha_at(scene, c.triangle, c.barycentric) < m.values.alpha_cutoff) args->valid[0] = 0;
    return;
  }
  const float alpha = alpha_at(scene, c.triangle, c.barycentric);
  if (context->kind == RayKind::link) {
    if (!(alpha > 0.0f)) args->valid[0] = 0;
    return;
  }
  glm::vec3& left = context->passage->transmittance;
  left *= 1.0f - alpha;
  if (!all_taken(left)) args->valid[0] = 0;
}

void add_mesh(PathScene* scene, std::size_t mesh) {
  const std::uint32_t begin = scene->mesh_begin[mesh], end = scene->mesh_begin[mesh + 1];
  if (begin == end) return;
  RTCGeometry handle = rtcNewGeometry(scene->device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  const auto& positions = scene->geometry.positions;
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(handle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, positions.size()));
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(handle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, end - begin));
  if (vertices && indices) {
    std::memcpy(vertices, positions.data(), positions.size() * 12);
    for (std::uint32_t i = begin; i < end; ++i)
      std::memcpy(indices + 3 * std::size_t{i - begin}, scene->corners(i), 12);
    if (mesh == PathScene::kPanes) rtcSetGeometryOccludedFilterFunction(handle, pass_pane);
    if (mesh == PathScene::kAsks) {
      rtcSetGeometryIntersectFilterFunction(handle, stop_at_covered);
      rtcSetGeometryOccludedFilterFunction(handle, take_share);
    }
    rtcCommitGeometry(handle);
    rtcAttachGeometryByID(scene->embree.get(), handle, static_cast<unsigned>(mesh));
  }
  rtcReleaseGeometry(handle);
}

}  // namespace

void build_hierarchy(PathScene* scene) {
  scene->device.reset(rtcNewDevice(nullptr));
  if (!scene->device) throw Error("reference", "the ray tracer does not start", "use another --mode");
  scene->embree.reset(rtcNewScene(scene->device.get()));
  rtcSetSceneFlags(scene->embree.get(),
                   static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
  rtcSetSceneBuildQuality(scene->embree.get(), RTC_BUILD_QUALITY_MEDIUM);
  for (std::size_t mesh = 0; mesh < PathScene::kHidden; ++mesh) add_mesh(scene, mesh);
  rtcCommitScene(scene->embree.get());
  if (rtcGetDeviceError(scene->device.get()) != RTC_ERROR_NONE)
    throw Error("reference", "the ray tracer could not take " + std::to_string(scene->triangles.size()) + " triangles",
                "free memory, or use a lighter model");
}

bool intersect(const PathScene& scene, const Ray& ray, RayKind kind, std::uint32_t chance, RayHit* hit) {
  if (scene.log) scene.log({ray.origin, ray.direction, ray.near, ray.far, false});
  RayContext context;
  rtcInitIntersectContext(&context.base);
  context.scene = &scene;
  context.kind = kind;
  context.chance = chance;
  if (kind == RayKind::camera) context.base.filter = cull_backs;
  RTCRayHit query;
  query.ray = embree_ray(ray.origin, ray.direction, ray.near, ray.far);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene.embree.get(), &context.base, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit->distance = query.ray.tfar;
  hit->triangle = scene.mesh_begin[query.hit.geomID] + query.hit.primID;
  hit->barycentric = {query.hit.u, query.hit.v};
  return true;
}

namespace {

bool passes(const PathScene& scene, const Ray& ray, RayKind kind, Passage* passage) {
  if (scene.log) scene.log({ray.origin, ray.direction, ray.near, ray.far, true});
  passage->transmittance = glm::vec3(1.0f);
  passage->pane_count = 0;
  RayContext context;
  rtcInitIntersectContext(&context.base);
  context.scene = &scene;
  context.kind = kind;
  context.chance = 0;
  context.passage = passage;
  RTCRay query = embree_ray(ray.origin, ray.direction, ray.near, ray.far);
  rtcOccluded1(scene.embree.get(), &context.base, &query);
  return query.tfar >= 0.0f;
}

}  // namespace

bool find_passage(const PathScene& scene, const Ray& ray, Passage* passage) {
  return passes(scene, ray, RayKind::path, passage);
}

glm::vec3 transmittance(const PathScene& scene, const glm::vec3& direction, const Passage& passage) {
  glm::vec3 result = passage.transmittance;
  for (std::uint32_t i = 0; i < passage.pane_count; ++i) {
    const Passage::Pane& pane = passage.panes[i];
    result *= pane_transmittance(scene, pane.triangle, pane.barycentric, direction);
  }
  return result;
}

glm::vec3 transmittance(const PathScene& scene, const Ray& ray) {
  Passage passage;
  return find_passage(scene, ray, &passage) ? transmittance(scene, ray.direction, passage) : glm::vec3(0.0f);
}

bool is_clear(const PathScene& scene, const Ray& ray) {
  Passage passage;
  return passes(scene, ray, RayKind::link, &passage);
}

}  // namespace maquette
