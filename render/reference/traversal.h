#pragma once

#include <array>
#include <glm/glm.hpp>

#include "render/reference/path_scene.h"

namespace maquette {

struct RayHit {
  float distance = 0.0f;  ///< along the direction as given
  std::uint32_t triangle = 0;
  glm::vec2 barycentric{0.0f};  ///< weights of the second and third corner
};

enum class RayKind {
  camera,  ///< culls backs of single-sided surfaces as rasterisation does; stops at blended surfaces
  path,    ///< passes blended surfaces by chance
  link,    ///< stops at whatever takes or mirrors light
};

struct Ray {
  glm::vec3 origin{0.0f};
  glm::vec3 direction{0.0f, 0.0f, 1.0f};
  float near = 0.0f;
  float far = 3.4e38f;
};

/// Fills PathScene::device and embree. Throws Error when the ray tracer does not start or runs out of memory.
void build_hierarchy(PathScene* scene);

/// Nearest surface that stops the ray; panes do. `chance` decides about blended surfaces.
bool intersect(const PathScene& scene, const Ray& ray, RayKind kind, std::uint32_t chance, RayHit* hit);
/// What a shadow ray passed. Its panes are reckoned later, once they have come from memory.
struct Passage {
  static constexpr std::uint32_t kMostPanes = 8;  ///< that wait
  struct Pane {
    std::uint32_t triangle;
    glm::vec2 barycentric;
  };
  glm::vec3 transmittance;  ///< without the panes that wait
  std::uint32_t pane_count;
  std::array<Pane, kMostPanes> panes;
};
/// Whether anything may come through; `passage` is only worth something then.
bool find_passage(const PathScene& scene, const Ray& ray, Passage* passage);
/// Share of light per channel that comes through along `direction`, panes included.
glm::vec3 transmittance(const PathScene& scene, const glm::vec3& direction, const Passage& passage);
/// Both at once: share of light per channel that comes through along a straight line: panes and blended surfaces take
/// some, all else everything.
glm::vec3 transmittance(const PathScene& scene, const Ray& ray);
/// Whether nothing at all is in between, not even a pane.
bool is_clear(const PathScene& scene, const Ray& ray);

}  // namespace maquette
