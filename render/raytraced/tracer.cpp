#include "render/raytraced/tracer.h"

#include <cmath>

#include "render/raytraced/ray_scene.h"
#include "render/reference/path_scene.h"
#include "render/reference/traversal.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

class RaytracedReflections : public ReflectorTechnique {
 public:
  explicit RaytracedReflections(bool glossy) : glossy_(glossy) {}
  void trace(const ReflectionFrame& frame) override {
    const FlatGeometry& geometry = frame.buffers->geometry();
    if (!scene_.scene || epoch_ != frame.geometry_epoch || occluding_ != *frame.occluding) {
      scene_ = build_ray_scene(geometry, *frame.occluding);
      epoch_ = frame.geometry_epoch;
      occluding_ = *frame.occluding;
    }
    ReflectionTargets& t = *frame.targets;
    const auto count = static_cast<std::size_t>(t.width) * static_cast<std::size_t>(t.height);
    std::vector<glm::vec4> origins(count), directions(count);
    const auto bytes = static_cast<GLsizei>(count * sizeof(glm::vec4));
    glGetTextureImage(t.ray_origin.get(), 0, GL_RGBA, GL_FLOAT, bytes, origins.data());
    glGetTextureImage(t.ray_direction.get(), 0, GL_RGBA, GL_FLOAT, bytes, directions.data());
    std::vector<std::uint32_t> hits(count, 0u);
    parallel_for(0, t.height, [&](int y) {
      for (int x = 0; x < t.width; ++x) {
        const std::size_t i =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(t.width) + static_cast<std::size_t>(x);
        if (directions[i].w <= 0.0f) continue;
        if (glossy_) {
          const auto met = nearest(frame, {glm::vec3(origins[i]), glm::vec3(directions[i]), kNear_m});
          hits[i] = met ? met->triangle + 1u : 0u;
          continue;
        }
        const auto reflector = static_cast<std::size_t>(directions[i].w - 0.5f);
        hits[i] = hit(frame, origins[i], directions[i], geometry.items[(*frame.reflectors)[reflector].item]);
      }
    });
    t.triangle.upload(0, t.width, t.height, GL_RED_INTEGER, GL_UNSIGNED_INT, hits.data());
    const GLubyte no_effort[2] = {0, 0};
    glClearTexImage(t.effort.get(), 0, GL_RG_INTEGER, GL_UNSIGNED_BYTE, no_effort);
    rays_ = 0.0;
    for (const glm::vec4& d : directions) rays_ += d.w > 0.0f ? 1.0 : 0.0;
    frame.timer->end("rays");
  }
  void add_counters(std::map<std::string, double>* counters) const override {
    (*counters)[glossy_ ? "glossy_rays" : "rays"] = rays_;
  }

 private:
  static constexpr float kNear_m = 1e-4f;  ///< surfaces that touch the one that reflects count from here on

  /// Index + 1 of the triangle that the ray hits. A mirror does not
  /// see itself: the ray starts on the true surface, and facets of a concave one lie in front of it.
  std::uint32_t hit(const ReflectionFrame& frame, const glm::vec4& origin, const glm::vec4& direction,
                    const DrawItem& own) const {
    constexpr int kOwnFacets = 8;
    float near = kNear_m;
    for (int passed = 0; passed <= kOwnFacets; ++passed) {
      const auto met = nearest(frame, {glm::vec3(origin), glm::vec3(direction), near});
      if (!met) return 0u;
      const std::uint32_t first = 3 * met->triangle;
      if (first < own.first_index || first >= own.first_index + own.index_count) return met->triangle + 1u;
      near = std::nextafter(met->distance, 1e30f);
    }
    return 0u;
  }
  std::optional<RayScene::Hit> nearest(const ReflectionFrame& frame, const Ray& ray) const {
    if (!frame.cut_out) return scene_.nearest(ray.origin, ray.direction, ray.near);
    RayHit met;
    if (!find_opaque(*frame.cut_out, ray, &met)) return std::nullopt;
    return RayScene::Hit{frame.cut_out->triangles[met.triangle].source, met.distance};
  }

  RayScene scene_;
  std::uint32_t epoch_ = 0;
  std::vector<bool> occluding_;
  double rays_ = 0.0;
  bool glossy_ = false;
};

}  // namespace

std::unique_ptr<ReflectorTechnique> make_raytraced_reflections() {
  return std::make_unique<RaytracedReflections>(false);
}
std::unique_ptr<ReflectorTechnique> make_glossy_raytraced_reflections() {
  return std::make_unique<RaytracedReflections>(true);
}

}  // namespace maquette
