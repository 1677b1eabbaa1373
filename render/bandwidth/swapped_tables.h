#pragma once

#include <vector>

#include "render/shading/shading_mode.h"

namespace maquette {

/// The tiles that show a material with another measured table than in the frame before: only these are shaded anew.
class SwappedTables {
 public:
  void find(const LayerContext& layer);
  const TileList& tiles() const { return tiles_; }
  static std::vector<ShaderVariant> shader_variants();

 private:
  TileList tiles_;
  TileCounter counter_;
};

}  // namespace maquette
