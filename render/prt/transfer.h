#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "render/prt/cube_light.h"
#include "render/prt/transfer_mesh.h"
#include "render/raytraced/ray_scene.h"
#include "scenes/btf/btf.h"

namespace maquette {

/// What of the light of each direction arrives at the vertices: visibility times cosine, the mean over points of the
/// direction's texel, and from where in the vertex's frame.
struct ArrivingLight {
  struct Entry {
    std::uint16_t direction = 0;  ///< of the cube
    float arriving = 0.0f;        ///< mean of visibility times cosine, above 0
    glm::vec3 local{0.0f};        ///< mean of the visible directions weighted by their cosine, unit, z > 0
  };
  std::vector<std::size_t> first;  ///< [vertex], and the end
  std::vector<Entry> entries;
};

struct ArrivingOptions {
  int rays = 2;  ///< a side of the points of a texel
};

/// Where a vertex's rays start.
glm::vec3 transfer_ray_origin(const TransferVertex& v);

/// One ray for each vertex and each point of a texel above its horizon. Deterministic. Empty once cancelled.
ArrivingLight trace_arriving_light(const TransferMesh& mesh, const CubeDirections& directions, const RayScene& scene,
                                   const ArrivingOptions& options, const std::atomic<bool>& cancel);

/// Lights of a view with their weights, found for all entries of the vertices of a group: made once for all views that
/// have the same lights.
class LightTable {
 public:
  LightTable(const ArrivingLight& arriving, const std::vector<std::uint32_t>& vertices,
             std::shared_ptr<const DirectionMesh> lights);
  const std::shared_ptr<const DirectionMesh>& lights() const { return lights_; }
  /// Transfer of a component of a view, [direction][vertex of the group]: arriving light times `weights` of its lights.
  /// Empty `weights`: 1 (the mean).
  Eigen::MatrixXf transfer(Eigen::Index directions, const std::vector<float>& weights, int stride, int component) const;

 private:
  struct Entry {
    std::uint16_t direction;
    std::array<std::uint16_t, 3> light;
    std::array<float, 3> share;  ///< times the arriving light
  };
  std::shared_ptr<const DirectionMesh> lights_;
  std::vector<std::size_t> first_;
  std::vector<Entry> entries_;
};

/// Vertices of each group.
std::vector<std::vector<std::uint32_t>> vertices_of_groups(const TransferMesh& mesh, std::size_t groups);

}  // namespace maquette
