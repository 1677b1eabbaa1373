#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

#include "scenes/scene.h"

namespace maquette {

/// The cage's topology, without refinement. Throws Error naming the fault when it is no surface.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> make_refiner(const SubdivisionCage& cage);

}  // namespace maquette
