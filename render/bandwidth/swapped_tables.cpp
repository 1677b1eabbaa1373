#include "render/bandwidth/swapped_tables.h"

namespace maquette {

namespace {
const ShaderVariant kReplacedMaterials{"gbuffer/replaced_materials.comp", "", {}};
}  // namespace

std::vector<ShaderVariant> SwappedTables::shader_variants() { return {kReplacedMaterials}; }

void SwappedTables::find(const LayerContext& layer) {
  const Surfaces& surfaces = layer.surfaces;
  if (tiles_.counts.size() != surfaces.tiles().counts.size() ||
      tiles_.tiles.bytes() != surfaces.tiles().tiles.bytes()) {
    tiles_ = make_tile_list(surfaces.size(), surfaces.band_rows());
    counter_ = TileCounter(tiles_.counts.size());
  }
  tiles_.band_tiles = surfaces.tiles().band_tiles;
  tiles_.counts.assign(tiles_.counts.size(), 0);
  if (!layer.frame.scene.tables_swapped()) return;  // the flags are those of an earlier swap
  dispatch_tiles(counter_.begin(&layer.frame.programs, kReplacedMaterials, surfaces.band_rows(), tiles_, nullptr),
                 surfaces.tiles(), kPerTile);
  counter_.end(&tiles_, nullptr);
}

}  // namespace maquette
