#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "render/reference/path_scene.h"

namespace maquette {

struct RayHit {
  float distance = 0.0f;  ///< in units of the direction's length
  std::uint32_t triangle = 0;
  glm::vec2 barycentric{0.0f};  ///< weights of the second and third corner
};

enum class RayKind {
  camera,        ///< culls back faces of single-sided surfaces, as rasterisation does; stops at blended surfaces
  path,          ///< passes blended surfaces at random
  reconnection,  ///< stops at everything that absorbs or reflects light
};

struct Ray {
  glm::vec3 origin{0.0f};
  glm::vec3 direction{0.0f, 0.0f, 1.0f};
  float near = 0.0f;
  float far = 3.4e38f;
};

/// Rays through the neighbouring pixels, for texture footprints; directions are as long as the ray's own.
struct RayDifferential {
  glm::vec3 origin_x{0.0f}, origin_y{0.0f};
  glm::vec3 direction_x{0.0f}, direction_y{0.0f};
};

/// Fills PathScene::device and embree. Throws Error when the ray tracer does not start or runs out of memory.
void build_hierarchy(PathScene* scene);

/// Nearest surface that stops the ray; panes do. `chance`: random number that decides about blended surfaces.
/// `differential`: what cuts out is the mean alpha of its footprint, as rasterisation has it; null: unfiltered.
bool intersect(const PathScene& scene, const Ray& ray, RayKind kind, std::uint32_t chance, RayHit* hit,
               const RayDifferential* differential = nullptr);
/// What a shadow ray passed through. The transmittance of its panes is computed later, once they are in the cache.
struct RayPassage {
  static constexpr std::uint32_t kMostPanes = 8;  ///< not yet computed
  struct Pane {
    std::uint32_t triangle;
    glm::vec2 barycentric{};
  };
  glm::vec3 transmittance{};  ///< without the panes below
  std::uint32_t pane_count;
  std::array<Pane, kMostPanes> panes;
};
/// Whether any light may pass; `passage` is valid only then.
bool find_passage(const PathScene& scene, const Ray& ray, RayPassage* passage);
/// Transmittance per channel along `direction`, panes included.
glm::vec3 transmittance(const PathScene& scene, const glm::vec3& direction, const RayPassage& passage);
/// Both in one step: transmittance per channel along a straight line. Panes and blended surfaces attenuate, all other
/// surfaces block.
glm::vec3 transmittance(const PathScene& scene, const Ray& ray);
/// The panes and blended surfaces along a ray, nearest first, whatever else it crosses; each surface once.
void find_transparent(const PathScene& scene, const Ray& ray, std::vector<RayHit>* hits);
/// Nearest surface that is neither; cut-out ones only where something of them is.
bool find_opaque(const PathScene& scene, const Ray& ray, RayHit* hit);
/// Whether there is nothing in between, not even a pane.
bool is_unoccluded(const PathScene& scene, const Ray& ray);

}  // namespace maquette
