#pragma once

#include <cstddef>

#include "render/gl/objects.h"

namespace maquette {

struct CellBrdfIndex;
class LocalPca;

/// Cell BRDFs on the GPU, read through shaders/octree/cells.glsl.
class CellBrdfBuffers {
 public:
  CellBrdfBuffers(const CellBrdfIndex& index, const LocalPca& pca);
  void bind() const;  ///< units 36 (code of each node), 37 (codes), 38 (pairs of the clusters), 39 (what they show)
  std::size_t bytes() const { return nodes_.bytes() + codes_.bytes() + pairs_.bytes() + seen_.bytes(); }

 private:
  Buffer nodes_, codes_, pairs_, seen_;
  Texture node_view_, code_view_, pair_view_, seen_view_;
};

}  // namespace maquette
