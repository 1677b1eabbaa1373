#pragma once

#include "render/prt/transfer.h"

namespace maquette {

/// Vertices to which nothing arrives because they lie within another body: most of what they meet, weighted by the
/// cosine, are back sides. [vertex]
std::vector<bool> find_buried_vertices(const TransferMesh& mesh, const FlatGeometry& geometry,
                                       const CubeDirections& directions, const RayScene& scene,
                                       const ArrivingLight& light);

/// Where two bodies meet, a triangle may be seen in part although a corner is buried in the other body. A buried vertex
/// takes what arrives at the nearest of its neighbours that is lit, ring by ring, so that the seen part does not darken
/// towards it. Buried vertices without lit ones in their part stay black. [vertex] whose light it takes: mostly its
/// own.
std::vector<std::uint32_t> light_sources(const TransferMesh& mesh, const std::vector<bool>& buried,
                                         const ArrivingLight& light);
void take_light_of(const std::vector<std::uint32_t>& sources, ArrivingLight* light);

}  // namespace maquette
