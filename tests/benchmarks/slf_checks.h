#pragma once

#include "render/slf/incident_bake.h"
#include "tests/benchmarks/stage.h"

namespace maquette::bench {

/// Case "checks": a small sun, a convex body, one texel against the plain tracer.
Figures check_incident_light(Stage& stage);

/// Case "library": Haar coefficients against direct bins under the light of a seat, for every built-in material that
/// the lumispheres are said to hold. `texels`: of these few.
Figures check_library(const Scene& scene, const IncidentBake& incident);

/// Case "ranks": the bake of the whole program under mpirun, of one and two processes of one core each.
Figures measure_ranks(const Options& options);

}  // namespace maquette::bench
