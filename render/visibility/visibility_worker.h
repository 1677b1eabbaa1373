#pragma once

#include <vector>

#include "render/background_worker.h"
#include "render/visibility/visibility_bake.h"

namespace maquette {

struct VisibilityJob {
  FlatGeometry geometry;  ///< positions, normals, indices and items suffice
  std::vector<bool> transmits;
  std::vector<Passage> passages;
};

/// Bakes visibility on a thread of its own, through the disk cache.
class VisibilityWorker : public BackgroundWorker<VisibilityJob, VisibilityBake> {
 public:
  using Job = VisibilityJob;
  VisibilityWorker();
};

}  // namespace maquette
