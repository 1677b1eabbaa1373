#pragma once

#include <string>

#include "render/slf/light_field.h"
#include "tests/benchmarks/stage.h"

namespace maquette::bench {

/// What the figures of the dissertation's chapter on surface light fields are made of.
struct FieldPictures {
  const FlatGeometry& geometry;
  const LightFieldAtlas& atlas;
  const IncidentField& incident;
  const LightField& stored;      ///< outgoing light, uncompressed
  const LightField& compressed;  ///< the same, 128 clusters
  std::string part;              ///< name of the node whose texels are shown
};

/// Writes into `folder`: `slices-incoming.png` (its figure 10.2: light that arrives at the part's texels from six
/// directions of their frames), `slices-outgoing.png` (10.3: light that leaves them), `slices-compressed.png` (10.4:
/// stored above, compressed below). Throws Error.
void save_slices(const Scene& scene, const FieldPictures& fields, const std::string& folder);

/// `local.png` (its figure 10.7): the light field beside local lighting by the environment and lamps alone, `r` in mode
/// slf.
void save_beside_local_lighting(Stage& stage, const FrameRequest& r, const std::string& folder);

}  // namespace maquette::bench
