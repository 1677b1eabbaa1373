#include "render/reference/traversal.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "render/math/low_discrepancy.h"
#include "render/raytraced/embree_ray.h"
#include "render/raytraced/ray_device.h"
#include "render/reference/surface.h"
#include "scenes/error.h"

namespace maquette {

namespace {

/// What the filter functions need to know about their ray.
struct RayContext {
  RTCIntersectContext base;  // first: Embree hands back a pointer to it
  const PathScene* scene;
  RayKind kind;
  std::uint32_t chance;
  RayPassage* passage;                  ///< for shadow rays
  const RayDifferential* differential;  ///< may be null
  std::vector<RayHit>* found = nullptr;
};

bool is_black(const glm::vec3& transmittance) { return !(transmittance.x + transmittance.y + transmittance.z > 0.0f); }

/// A hit of one of the ray tracer's primitives.
struct MeshHit {
  unsigned mesh, primitive;
  float u, v;
};

/// The triangle of a hit: the second half of a quad runs from its third corner, v2, to v3 and v1.
/// Source: Embree's manual, RTC_GEOMETRY_TYPE_QUAD.
RayHit triangle_of(const PathScene& scene, const MeshHit& h) {
  const std::uint32_t pairs = scene.pair_count[h.mesh], begin = scene.mesh_begin[h.mesh];
  if (h.primitive >= pairs) return {0.0f, begin + pairs + h.primitive, {h.u, h.v}};
  const std::uint32_t first = begin + 2 * h.primitive;
  if (h.u + h.v <= 1.0f) return {0.0f, first, {h.u, h.v}};
  return {0.0f, first + 1, {1.0f - h.u, 1.0f - h.v}};
}

struct Candidate {
  std::uint32_t triangle;
  glm::vec2 barycentric{};
  glm::vec3 direction{};
};

Candidate candidate_of(const PathScene& scene, const RTCFilterFunctionNArguments* args) {
  const RayHit hit = triangle_of(scene, {RTCHitN_geomID(args->hit, args->N, 0), RTCHitN_primID(args->hit, args->N, 0),
                                         RTCHitN_u(args->hit, args->N, 0), RTCHitN_v(args->hit, args->N, 0)});
  return {hit.triangle,
          hit.barycentric,
          {RTCRayN_dir_x(args->ray, args->N, 0), RTCRayN_dir_y(args->ray, args->N, 0),
           RTCRayN_dir_z(args->ray, args->N, 0)}};
}

/// Filter of every mesh, for camera rays only (set in the context).
void cull_backs(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const RayContext*>(args->context);
  const Candidate c = candidate_of(*context->scene, args);
  const TracedTriangle& t = context->scene->triangles[c.triangle];
  if ((t.material & kBothSides) == 0 && glm::dot(t.geometric, c.direction) > 0.0f) args->valid[0] = 0;
}

bool is_transparent(const TracedMaterial& m) { return m.blended || m.values.glass; }

/// Filter of every mesh, set in the context: stores what is transparent and lets every ray pass.
void collect_transparent(const RTCFilterFunctionNArguments* args) {
  auto* context = reinterpret_cast<RayContext*>(args->context);
  const Candidate c = candidate_of(*context->scene, args);
  if (is_transparent(context->scene->material_of(c.triangle)))
    context->found->push_back({RTCRayN_tfar(args->ray, args->N, 0), c.triangle, c.barycentric});
  args->valid[0] = 0;
}

/// Filter of every mesh, set in the context.
void pass_transparent(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const RayContext*>(args->context);
  const Candidate c = candidate_of(*context->scene, args);
  if (is_transparent(context->scene->material_of(c.triangle))) args->valid[0] = 0;
}

/// Filter of the mesh kAlpha, nearest hit: skips cut-out surfaces, and blended ones at random.
void skip_by_alpha(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const RayContext*>(args->context);
  const Candidate c = candidate_of(*context->scene, args);
  const TracedMaterial& m = context->scene->material_of(c.triangle);
  if (m.masked) {
    const float alpha = context->differential
                            ? alpha_at(*context->scene, c.triangle, c.barycentric, *context->differential)
                            : alpha_at(*context->scene, c.triangle, c.barycentric);
    if (alpha < m.values.alpha_cutoff) args->valid[0] = 0;
  }
  if (m.blended && context->kind == RayKind::path) {
    const float u =
        static_cast<float>(mix_seed(context->chance, context->scene->triangles[c.triangle].source) >> 8) * 0x1p-24f;
    if (u >= alpha_at(*context->scene, c.triangle, c.barycentric)) args->valid[0] = 0;
  }
}

/// Filter of panes, shadow rays: stores the pane. Its transmittance is computed once nothing has stopped the ray,
/// because most rays are stopped; by then the panes are in the cache.
void pass_pane(const RTCFilterFunctionNArguments* args) {
  auto* context = reinterpret_cast<RayContext*>(args->context);
  if (context->kind == RayKind::reconnection) return;
  const Candidate c = candidate_of(*context->scene, args);
  __builtin_prefetch(&context->scene->triangles[c.triangle]);
  RayPassage& passage = *context->passage;
  if (passage.pane_count == RayPassage::kMostPanes) {
    passage.transmittance = transmittance(*context->scene, c.direction, passage);
    passage.pane_count = 0;
    if (is_black(passage.transmittance)) return;
  }
  passage.panes[passage.pane_count++] = {c.triangle, c.barycentric};
  args->valid[0] = 0;
}

/// Filter of the mesh kAlpha, shadow rays: multiplies the transmittance.
void attenuate_by_alpha(const RTCFilterFunctionNArguments* args) {
  auto* context = reinterpret_cast<RayContext*>(args->context);
  const PathScene& scene = *context->scene;
  const Candidate c = candidate_of(scene, args);
  const TracedMaterial& m = scene.material_of(c.triangle);
  float alpha = alpha_at(scene, c.triangle, c.barycentric);
  if (m.masked) alpha = alpha < m.values.alpha_cutoff ? 0.0f : 1.0f;
  if (!(alpha > 0.0f)) args->valid[0] = 0;
  if (context->kind == RayKind::reconnection || !(alpha > 0.0f)) return;
  glm::vec3 passes(1.0f - alpha);
  if (m.clear() > 0.0f) passes += alpha * pane_transmittance(scene, c.triangle, c.barycentric, c.direction);
  glm::vec3& left = context->passage->transmittance;
  left *= passes;
  if (!is_black(left)) args->valid[0] = 0;
}

/// Corners of the ray tracer's primitives.
void write_corners(const PathScene& scene, std::size_t mesh, std::uint32_t* out) {
  const std::uint32_t begin = scene.mesh_begin[mesh], end = scene.mesh_begin[mesh + 1];
  const std::uint32_t alone = begin + 2 * scene.pair_count[mesh];
  for (std::uint32_t t = begin; t < alone; t += 2, out += 4) {
    const std::uint32_t *first = scene.corners(t), *second = scene.corners(t + 1);
    out[0] = first[0];
    out[1] = first[1];
    out[2] = second[0];
    out[3] = first[2];
  }
  for (std::uint32_t t = alone; t < end; ++t) {
    out = std::copy_n(scene.corners(t), 3, out);
    if (scene.quads) *out++ = scene.corners(t)[2];
  }
}

void add_mesh(PathScene* scene, std::size_t mesh) {
  const std::uint32_t count = scene->mesh_begin[mesh + 1] - scene->mesh_begin[mesh] - scene->pair_count[mesh];
  if (count == 0) return;
  RTCGeometry handle =
      rtcNewGeometry(scene->device.get(), scene->quads ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
  const auto& positions = scene->geometry.positions;
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(handle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, positions.size()));
  auto* corners = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(handle, RTC_BUFFER_TYPE_INDEX, 0, scene->quads ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3,
                              scene->quads ? 16 : 12, count));
  if (vertices && corners) {
    std::memcpy(vertices, positions.data(), positions.size() * 12);
    write_corners(*scene, mesh, corners);
    if (mesh == PathScene::kPanes) rtcSetGeometryOccludedFilterFunction(handle, pass_pane);
    if (mesh == PathScene::kAlpha) {
      rtcSetGeometryIntersectFilterFunction(handle, skip_by_alpha);
      rtcSetGeometryOccludedFilterFunction(handle, attenuate_by_alpha);
    }
    rtcCommitGeometry(handle);
    rtcAttachGeometryByID(scene->embree.get(), handle, static_cast<unsigned>(mesh));
  }
  rtcReleaseGeometry(handle);
}

}  // namespace

void build_hierarchy(PathScene* scene) {
  scene->device.reset(new_ray_device());
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

namespace {

bool trace_nearest(const PathScene& scene, const Ray& ray, RayContext* context, RayHit* hit) {
  RTCRayHit query;
  query.ray = embree_ray(ray.origin, ray.direction, ray.near, ray.far);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene.embree.get(), &context->base, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  *hit = triangle_of(scene, {query.hit.geomID, query.hit.primID, query.hit.u, query.hit.v});
  hit->distance = query.ray.tfar;
  return true;
}

}  // namespace

bool intersect(const PathScene& scene, const Ray& ray, RayKind kind, std::uint32_t chance, RayHit* hit,
               const RayDifferential* differential) {
  if (scene.log) scene.log({ray.origin, ray.direction, ray.near, ray.far, false});
  RayContext context;
  rtcInitIntersectContext(&context.base);
  context.scene = &scene;
  context.kind = kind;
  context.chance = chance;
  context.differential = differential;
  if (kind == RayKind::camera) context.base.filter = cull_backs;
  return trace_nearest(scene, ray, &context, hit);
}

namespace {

/// Whether two triangles have an edge in common, where a ray may hit both.
bool share_an_edge(const TracedTriangle& a, const TracedTriangle& b) {
  int common = 0;
  for (const glm::vec3& p : a.positions) common += std::count(b.positions.begin(), b.positions.end(), p) > 0;
  return common >= 2;
}

/// Traces a ray with a filter of every mesh. `found`: for the filter.
bool trace_filtered(const PathScene& scene, const Ray& ray, RTCFilterFunctionN filter, std::vector<RayHit>* found,
                    RayHit* hit) {
  RayContext context{};
  rtcInitIntersectContext(&context.base);
  context.base.filter = filter;
  context.scene = &scene;
  context.kind = RayKind::camera;
  context.found = found;
  return trace_nearest(scene, ray, &context, hit);
}

}  // namespace

void find_transparent(const PathScene& scene, const Ray& ray, std::vector<RayHit>* hits) {
  constexpr float kSame = 1e-5f;  // relative distance of two hits of one edge
  hits->clear();
  RayHit none;
  trace_filtered(scene, ray, collect_transparent, hits, &none);
  std::sort(hits->begin(), hits->end(), [](const RayHit& a, const RayHit& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.triangle < b.triangle);
  });
  const auto same = [&](const RayHit& a, const RayHit& b) {
    return b.distance - a.distance <= kSame * b.distance &&
           share_an_edge(scene.triangles[a.triangle], scene.triangles[b.triangle]);
  };
  hits->erase(std::unique(hits->begin(), hits->end(), same), hits->end());
}

bool find_opaque(const PathScene& scene, const Ray& ray, RayHit* hit) {
  return trace_filtered(scene, ray, pass_transparent, nullptr, hit);
}

namespace {

bool passes(const PathScene& scene, const Ray& ray, RayKind kind, RayPassage* passage) {
  if (scene.log) scene.log({ray.origin, ray.direction, ray.near, ray.far, true});
  passage->transmittance = glm::vec3(1.0f);
  passage->pane_count = 0;
  RayContext context;
  rtcInitIntersectContext(&context.base);
  context.scene = &scene;
  context.kind = kind;
  context.chance = 0;
  context.passage = passage;
  context.differential = nullptr;
  RTCRay query = embree_ray(ray.origin, ray.direction, ray.near, ray.far);
  rtcOccluded1(scene.embree.get(), &context.base, &query);
  return query.tfar >= 0.0f;
}

}  // namespace

bool find_passage(const PathScene& scene, const Ray& ray, RayPassage* passage) {
  return passes(scene, ray, RayKind::path, passage);
}

glm::vec3 transmittance(const PathScene& scene, const glm::vec3& direction, const RayPassage& passage) {
  glm::vec3 result = passage.transmittance;
  for (std::uint32_t i = 0; i < passage.pane_count; ++i) {
    const RayPassage::Pane& pane = passage.panes[i];
    result *= pane_transmittance(scene, pane.triangle, pane.barycentric, direction);
  }
  return result;
}

glm::vec3 transmittance(const PathScene& scene, const Ray& ray) {
  RayPassage passage;
  return find_passage(scene, ray, &passage) ? transmittance(scene, ray.direction, passage) : glm::vec3(0.0f);
}

bool is_unoccluded(const PathScene& scene, const Ray& ray) {
  RayPassage passage;
  return passes(scene, ray, RayKind::reconnection, &passage);
}

}  // namespace maquette
