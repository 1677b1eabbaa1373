#pragma once

#include <atomic>

#include "render/prt/transfer.h"

namespace maquette {

/// How far light that is interpolated between the vertices of a part misses what arrives in the middles of their edges:
/// RMS over edges and directions, relative to the RMS of what arrives there. In a light cube of 6 x 8 x 8.
/// `part.level`: of the division that is judged.
double vertex_interpolation_error(const FlatGeometry& geometry, const TransferPart& part, const RayScene& scene,
                                  const std::atomic<bool>& cancel);

/// What was chosen for a part.
struct VertexDensity {
  int level = 0;
  double error = 0.0;  ///< at that level
};

/// Divides the triangles of each part (TransferPart::level) until its error is at most `error`, no part beyond
/// kMostTransferLevels and all parts together not beyond about `most` vertices: the part with the largest error is
/// divided first.
std::vector<VertexDensity> choose_vertex_density(const FlatGeometry& geometry, const RayScene& scene, double error,
                                                 std::size_t most, const std::atomic<bool>& cancel,
                                                 std::vector<TransferPart>* parts);

}  // namespace maquette
