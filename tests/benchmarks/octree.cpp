// The octree: build time, traversal against Embree's single rays, and its visibility.
#include <embree3/rtcore.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <type_traits>

#include "render/gl/bindings.h"
#include "render/octree/octree_buffers.h"
#include "render/octree/octree_kind.h"
#include "render/octree/octree_shared.h"
#include "tests/benchmarks/embree_triangles.h"
#include "tests/benchmarks/stage.h"
#include "tests/support/octree_rays.h"

namespace maquette::bench {

namespace {

using test::HitRecord;
using test::RayRecord;

constexpr int kDepth = 9;
constexpr int kRays = 100000;
constexpr std::size_t kTwoMillion = 2000000;

using DevicePointer = std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(&rtcReleaseDevice)>;
using ScenePointer = std::unique_ptr<std::remove_pointer_t<RTCScene>, decltype(&rtcReleaseScene)>;

/// Embree over the triangles of the octree.
class EmbreeRays {
 public:
  explicit EmbreeRays(const OctreeJob& job)
      : device_(rtcNewDevice(nullptr), &rtcReleaseDevice), scene_(nullptr, &rtcReleaseScene) {
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0; i < job.geometry.items.size(); ++i) {
      const auto begin = job.geometry.indices.begin() + job.geometry.items[i].first_index;
      if (!job.transmits[i]) indices.insert(indices.end(), begin, begin + job.geometry.items[i].index_count);
    }
    scene_.reset(build_embree_triangles(device_.get(), job.geometry.positions, indices));
    rtcInitIntersectContext(&context_);
  }
  /// Distance, or -1. `normal` may be null.
  float trace(const glm::vec3& o, const glm::vec3& d, glm::vec3* normal) {
    RTCRayHit h{};
    h.ray.org_x = o.x, h.ray.org_y = o.y, h.ray.org_z = o.z;
    h.ray.dir_x = d.x, h.ray.dir_y = d.y, h.ray.dir_z = d.z;
    h.ray.tfar = 1e30f;
    h.ray.mask = 0xffffffffu;
    h.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_.get(), &context_, &h);
    if (h.hit.geomID == RTC_INVALID_GEOMETRY_ID) return -1.0f;
    if (normal) *normal = glm::normalize(glm::vec3(h.hit.Ng_x, h.hit.Ng_y, h.hit.Ng_z));
    return h.ray.tfar;
  }

 private:
  DevicePointer device_;
  ScenePointer scene_;
  RTCIntersectContext context_{};
};

struct Rays {
  std::vector<RayRecord> records;  ///< offset from the surface as in the shaders
  std::vector<bool> blocked;       ///< by Embree, from the surface itself
};

/// Cosine-distributed rays from the surfaces that `eye` sees in all directions.
Rays shadow_rays(EmbreeRays* embree, const shared::OctreeFrame& frame, const glm::vec3& eye) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  const auto direction = [&] { return glm::normalize(glm::vec3(normal(random), normal(random), normal(random))); };
  Rays rays;
  for (int tries = 0; static_cast<int>(rays.records.size()) < kRays && tries < 20 * kRays; ++tries) {
    const glm::vec3 d = direction();
    glm::vec3 n{};
    const float t = embree->trace(eye, d, &n);
    if (t < 0.0f) continue;
    if (glm::dot(n, d) > 0.0f) n = -n;
    const glm::vec3 p = eye + t * d, w = glm::normalize(1.001f * n + direction());
    const float cell_m = shared::octree_cell_at(frame, p) / frame.cells_per_m;
    RayRecord r{};
    r.origin = p + (0.25f * cell_m) * n;
    r.direction = w;
    r.t_max = 1e30f;
    r.t_box = 1.8f * cell_m;
    rays.records.push_back(r);
    rays.blocked.push_back(embree->trace(p + 2e-4f * n, w, nullptr) >= 0.0f);
  }
  return rays;
}

/// A sphere of many waves, `count` triangles at least: a fine mesh in every cell.
Scene dense_scene(std::size_t count) {
  const auto side = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(count) / 4.0)));
  const std::uint32_t columns = 2 * side;
  Primitive p;
  p.material = -1;
  for (std::uint32_t y = 0; y <= side; ++y)
    for (std::uint32_t x = 0; x <= columns; ++x) {
      const float u = 6.2831853f * static_cast<float>(x) / static_cast<float>(columns);
      const float v = 3.1415927f * static_cast<float>(y) / static_cast<float>(side);
      const float r = 2.0f + 0.2f * std::sin(9.0f * u) * std::sin(7.0f * v);
      p.positions.push_back(r * glm::vec3(std::cos(u) * std::sin(v), std::cos(v), std::sin(u) * std::sin(v)));
    }
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t a = y * (columns + 1) + x, b = a + columns + 1;
      p.indices.insert(p.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
    }
  Scene scene;
  scene.name = "dense";
  scene.meshes.push_back({"dense", {p}, nullptr});
  scene.nodes.emplace_back();
  scene.nodes[0].mesh = 0;
  scene.roots = {0};
  return scene;
}

std::string build_text(const Octree& octree, const Clock& took) {
  return number(took.wall_ms / 1000.0) + " s (" + number(took.cpu_ms / 1000.0) + " s of processor), " +
         number(static_cast<double>(octree.bytes()) / 1e6) + " MB, " + std::to_string(octree.leaf_count()) + " cells";
}

void measure_scene(Figures* figures, const std::string& name, const Scene& scene, const glm::vec3& eye, int repeats) {
  OctreeJob job = make_octree_job(scene, scene.materials, -1, kDepth);
  const Octree octree = build_octree({job.geometry, job.materials, job.transmits, *job.textures}, job.options);
  shared::octree_view = {octree.words.data(), octree.planes.data()};
  const shared::OctreeFrame frame = shared::octree_frame(octree);
  EmbreeRays embree(job);
  const Rays rays = shadow_rays(&embree, frame, eye);
  const OctreeBuffers buffers(octree);
  const Program program = Program::compute("octree/trace_rays.comp");
  const Buffer in = Buffer::from("rays", rays.records), out("hits", rays.records.size() * sizeof(HitRecord));
  buffers.bind();
  buffers.set_uniforms(program);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferOctreeRays, in.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferOctreeHits, out.get());
  std::vector<double> embree_ns, cpu_ns, gpu_ns;
  std::size_t wrong_block = 0, wrong_open = 0, steps = 0;
  const double per_ray = 1e6 / static_cast<double>(std::max<std::size_t>(rays.records.size(), 1));
  for (int k = 0; k <= repeats; ++k) {  // interleaved; the first round warms up
    const Clock a = now();
    std::size_t met = 0;
    for (const RayRecord& r : rays.records) met += embree.trace(r.origin, r.direction, nullptr) >= 0.0f;
    const Clock b = now();
    wrong_block = wrong_open = steps = 0;
    for (std::size_t i = 0; i < rays.records.size(); ++i) {
      const RayRecord& r = rays.records[i];
      const auto hit = shared::octree_trace(frame, {r.origin, r.direction, 0.0f, r.t_max, r.t_box, 0.0f, 0.0f});
      steps += static_cast<std::size_t>(hit.steps);
      wrong_block += hit.node >= 0 && !rays.blocked[i];
      wrong_open += hit.node < 0 && rays.blocked[i];
    }
    const Clock c = now();
    glUseProgram(program.get());
    glDispatchCompute(static_cast<GLuint>((rays.records.size() + 63) / 64), 1, 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    glFinish();
    const Clock d = now();
    if (k == 0 || met == 0) continue;
    embree_ns.push_back((b - a).cpu_ms * per_ray);
    cpu_ns.push_back((c - b).cpu_ms * per_ray);
    gpu_ns.push_back((d - c).cpu_ms * per_ray);
  }
  const auto middle = [](std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v.empty() ? 0.0 : v[v.size() / 2];
  };
  const double e = middle(embree_ns), c = middle(cpu_ns), g = middle(gpu_ns);
  const double count = static_cast<double>(std::max<std::size_t>(rays.records.size(), 1));
  figures->push_back(judged("rays, " + name + ", octree on the processor / Embree", "3 x",
                            number(c / e) + " x (" + number(c) + " / " + number(e) + " ns a ray and core, " +
                                number(static_cast<double>(steps) / count) + " steps)",
                            c <= 3.0 * e));
  figures->push_back(judged("rays, " + name + ", octree in the shader / Embree", "3 x",
                            number(g / e) + " x (" + number(g) + " ns)", g <= 3.0 * e));
  figures->push_back(shown("visibility, " + name + ", rays unlike Embree's",
                           number(100.0 * static_cast<double>(wrong_block) / count) + " % blocked, " +
                               number(100.0 * static_cast<double>(wrong_open) / count) + " % open"));
}

}  // namespace

Figures measure_octree(Stage& stage) {
  Figures figures;
  if (stage.options().wants("dense")) {
    const Scene scene = dense_scene(kTwoMillion);
    const OctreeJob job = make_octree_job(scene, scene.materials, -1, kDepth);
    const Clock begin = now();
    const Octree octree = build_octree({job.geometry, job.materials, job.transmits, *job.textures}, job.options);
    const Clock took = now() - begin;
    figures.push_back(judged("octree of 2 million triangles, depth 9", "15 s, 32 MB", build_text(octree, took),
                             took.wall_ms <= 15000.0 && octree.bytes() <= 32000000));
  }
  if (stage.options().wants("cockpit"))
    measure_scene(&figures, "cockpit", load_scene("builtin:cockpit"), {0.37f, 1.10f, -0.30f}, stage.options().repeats);
  if (stage.options().wants("ferrari")) {
    if (stage.options().data.empty()) {
      figures.push_back(absent("rays, Ferrari", "3 x", "needs --data"));
    } else {
      const Scene scene = load_scene(stage.options().data + "/scenes/ferrari458.glb");
      const Bounds bounds = compute_bounds(scene);
      measure_scene(&figures, "Ferrari", scene, bounds.center() + glm::vec3(0.0f, 0.9f, 2.5f) * bounds.radius(),
                    stage.options().repeats);
    }
  }
  // Accuracy of the picture: error against rays of the same estimator at a high count, and time.
  for (const char* name : {"none", "baked", "traced"}) {
    if (!stage.options().wants("visibility")) break;
    stage.show({.name = "cockpit/driver", .scene = "builtin:cockpit", .camera = "driver", .width = 160, .height = 90});
    FrameRequest traced = stage.request("uniform", 1024, 7);
    traced.settings.set_from_text("shading.visibility", "traced");
    stage.renderer().finish_background_work(traced);
    stage.renderer().render(traced);
    const Image reference = stage.renderer().read_radiance();
    FrameRequest request = stage.request("uniform", 256);
    request.settings.set_from_text("shading.visibility", name);
    stage.renderer().finish_background_work(request);
    stage.renderer().render(request);
    const Clock begin = now();
    stage.renderer().render(request);
    const Clock took = now() - begin;
    figures.push_back(shown(std::string("visibility=") + name + ", cockpit/driver 160 x 90, 256 samples",
                            number(100.0 * relative_rmse(stage.renderer().read_radiance(), reference)) + " %, " +
                                number(took.cpu_ms) + " ms of processor time"));
  }
  return figures;
}

}  // namespace maquette::bench
