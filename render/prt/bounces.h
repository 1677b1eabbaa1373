#pragma once

#include <Eigen/Core>
#include <atomic>
#include <vector>

#include "render/prt/transfer.h"

namespace maquette {

/// From where other vertices send light to a vertex: rays that end on the fronts of parts, shared among the vertices
/// around each hit.
struct GatheredLight {
  struct Entry {
    std::uint32_t source = 0;  ///< vertex
    float weight = 0.0f;       ///< cosine times solid angle, sr; of all a vertex' entries at most pi
    glm::vec3 local{0.0f};     ///< mean direction in the receiving vertex' frame, weighted by the cosine; unit, z > 0
  };
  std::vector<std::size_t> first;  ///< [vertex], and the end
  std::vector<Entry> entries;
};

/// One ray for each vertex and texel of `directions` above its horizon, through its middle. Deterministic. Empty once
/// cancelled. Vertices that `sources` names others for take what those gather.
GatheredLight gather_light(const TransferMesh& mesh, const FlatGeometry& geometry, const CubeDirections& directions,
                           const RayScene& scene, const std::vector<std::uint32_t>& sources,
                           const std::atomic<bool>& cancel);

/// Share of the light of each direction that a material reflects, by colour: [light][rgb], the lights those of its
/// first view. Of its mean texel, views interpolated; at most 1.
std::vector<float> reflected_shares(const Btf& material);

/// What vertices send after one and more reflections, and how it returns.
struct Bounces {
  GatheredLight gathered;
  int side = 0;  ///< of the faces of the light's cube, half of that of direct light
  /// [rgb * direction][vertex]: radiance that leaves a vertex for light of 1 from a direction of the cube, after 1, 2,
  /// ... reflections, summed. Every reflection after the first one's arrival is by `reflected_shares`, to all sides
  /// equally.
  Eigen::MatrixXf sent;
};

struct BounceInput {
  const TransferMesh& mesh;
  const FlatGeometry& geometry;
  const RayScene& scene;
  const CubeDirections& directions;  ///< of direct light
  const ArrivingLight& arriving;
  const std::vector<std::shared_ptr<const Btf>>& materials;  ///< [group]
  const std::vector<std::uint32_t>& sources;                 ///< [vertex] itself, or the one whose light it takes
};
/// `count`: reflections before the last one, which the transfer of each view is. Cost: entries times directions.
Bounces compute_bounces(const BounceInput& input, int count, const std::atomic<bool>& cancel);

/// Adds reflected light to direct transfer: `direct` [direction][vertex of the group] becomes [rgb][direction][vertex].
/// `weights`: of the lights of a view, as LightTable::transfer takes them.
Eigen::MatrixXf add_bounces(const Eigen::MatrixXf& direct, const Bounces& bounces, const DirectionMesh& lights,
                            const std::vector<std::uint32_t>& vertices, const std::vector<float>& weights, int stride,
                            int component);

}  // namespace maquette
