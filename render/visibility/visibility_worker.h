#pragma once

#include <vector>

#include "render/background_worker.h"
#include "render/visibility/visibility_bake.h"
#include "render/visibility/visibility_sides.h"

namespace maquette {

struct VisibilityJob {
  FlatGeometry geometry;  ///< positions, normals, indices and items suffice
  std::vector<bool> transmits;
  std::vector<Passage> passages;
};

/// A bake and its masks as shaders read them.
struct DrawnVisibility {
  VisibilityBake bake;
  std::vector<VisibilitySides> sides;
};

/// Bakes visibility on a thread of its own, through the disk cache.
class VisibilityWorker : public BackgroundWorker<VisibilityJob, DrawnVisibility> {
 public:
  using Job = VisibilityJob;
  VisibilityWorker();
};

}  // namespace maquette
