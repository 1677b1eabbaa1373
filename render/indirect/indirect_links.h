#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "render/scene_state/geometry.h"
#include "render/visibility/visibility_points.h"

namespace maquette {

struct PathScene;

/// All inputs of the transport links: everything that indirect light depends on except the sky.
struct IndirectInput {
  Scene scene;  ///< materials after overrides; hidden nodes have visible = false
  std::shared_ptr<const FlatGeometry> geometry;
  int variant = -1;
  std::vector<bool> transmits;  ///< as for the visibility bake
  /// BrdfTables::albedo of each measured material, otherwise empty; in the order of scene.materials.
  std::vector<std::vector<glm::vec3>> measured_albedo;
  std::vector<std::uint64_t> measured_hash;  ///< of each table, 0: analytic
};

/// Where one ray of a point ends: a point of another surface, and the share of the light there that is reflected along
/// the ray.
struct IndirectLink {
  std::uint32_t target = kNoPoint;  ///< side * points + point; kNoPoint: the sky, or nothing that reflects
  std::uint32_t color = 0;          ///< reflectance, three times ten bits, 1023 is 1
};

/// A neighbour for smoothing, and its share of the mean.
struct IndirectNeighbour {
  std::uint32_t point;
  float weight;
};

/// Transport links between surfaces, independent of the light: for a new light, or a rotated one, the sums are computed
/// again without tracing a ray.
struct IndirectLinks {
  VisibilityPoints points;
  std::vector<std::uint32_t> vertex_of_point;  ///< one of the vertices that share it
  int sides = 1;                               ///< 2: some material is double-sided, so back faces are baked too
  int rays = 0;                                ///< per point and side, cosine-distributed
  std::vector<IndirectLink> links;             ///< [side][point][ray]
  std::vector<glm::vec3> lamps;  ///< [side][point] irradiance of the scene's own lights, with shadows; may be empty
  /// Weights of the smoothing: of the point itself, and [first_neighbour[point], first_neighbour[point + 1]) of the
  /// list.
  std::vector<float> own_weight;
  std::vector<std::uint32_t> first_neighbour;  ///< [point + 1]
  std::vector<IndirectNeighbour> neighbours;
  std::shared_ptr<const PathScene> scene;  ///< what rays meet
  std::size_t bytes() const {
    return links.size() * sizeof(IndirectLink) + lamps.size() * sizeof(glm::vec3) + own_weight.size() * sizeof(float) +
           first_neighbour.size() * sizeof(std::uint32_t) + neighbours.size() * sizeof(IndirectNeighbour);
  }
};

/// Traces with the functions of the reference path tracer: panes transmit their share, textures colour the reflected
/// light. About `budget` rays in all, 16 to 256 a point. Null once `cancel` is set. `first`: takes what 4 rays a point
/// find, which are traced before the others.
std::shared_ptr<const IndirectLinks> trace_indirect_links(const IndirectInput& input, std::size_t budget,
                                                          const std::atomic<bool>& cancel,
                                                          const std::function<void(double)>& progress = {},
                                                          const std::function<void(const IndirectLinks&)>& first = {});

/// Local direction of ray `r` of `rays`, cosine-distributed; z is the normal.
glm::vec3 indirect_ray_direction(int r, int rays);
/// The frame of a point's ray pattern in world space, about its normal on one side. Each point rotates the pattern by
/// its own angle, to decorrelate the errors of neighbours.
struct IndirectFrame {
  glm::vec3 t{}, b{}, n{};
  glm::vec3 to_world(const glm::vec3& d) const { return t * d.x + b * d.y + n * d.z; }
};
IndirectFrame indirect_frame(const VisibilityPoint& point, std::size_t index, int side);
/// Where the rays of a point's side begin, world.
struct IndirectStart {
  IndirectFrame frame;
  glm::vec3 origin{};
};
IndirectStart indirect_start(const IndirectLinks& links, std::size_t index, int side);

}  // namespace maquette
