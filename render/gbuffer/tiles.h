#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "render/gl/dispatch.h"
#include "render/gl/program_cache.h"

namespace maquette {

constexpr int kTileSide = 8;  ///< grid points along a tile's side

/// Size of the shading grid: `side` x `side` points a pixel.
struct GridSize {
  int width = 0, height = 0;  ///< of the picture
  int side = 1;
  int grid_width() const { return width * side; }
  int grid_height() const { return height * side; }
  bool operator==(const GridSize&) const = default;
};

/// Tiles of 8 x 8 grid points (shaders/shared/tiles.glsl), listed band by band of rows.
struct TileList {
  Buffer tiles;             ///< uint each, x | y << 16 in tiles; [band][tiles of a band]
  std::vector<int> counts;  ///< of each band
  int band_tiles = 0;       ///< entries of a band
  bool interleaved = false;  ///< every other one first: the cost of a tile follows its place in the picture
};
/// An empty list with room for all tiles of a grid, in bands of `band_rows` grid rows (a multiple of the tile's side).
TileList make_tile_list(const GridSize& size, int band_rows);

/// The order in which a list holds its tiles. Shaders append them as they get to them, but parts of the list are
/// predicted anew while the light rotates, so that it must be the same in every run: by rows, runs of the upper and the
/// lower half by turns, since a software device gives each core one stretch of the list.
std::vector<unsigned> ordered_tiles(std::vector<unsigned> tiles);
void order_tiles(TileList* list);

/// Every `step`-th tile of a list from `first` on.
struct TileShare {
  int first = 0, step = 1;
};

/// Powers of two: how many invocations a tile takes, one a point, one for four (shaders/shared/lookup.glsl), one a quad
/// of 2 x 2, one for 4 x 4 points, one.
constexpr int kPerPoint = 6, kPerFourPoints = 4, kPerQuad = 4, kPerBlock = 2, kPerTile = 0;

/// Runs a program over the tiles of a list, 2^shift invocations each; `band`: its tiles only.
void dispatch_tiles(const Program& program, const TileList& list, int shift, std::optional<std::size_t> band = {},
                    TileShare share = {});

/// Counts of two tile lists that one shader fills, by band.
class TileCounter {
 public:
  TileCounter() = default;
  explicit TileCounter(std::size_t bands);
  /// Binds the lists that `shader` fills, and gives its program. `second` may be null, here and after it ran.
  const Program& begin(ProgramCache* programs, const ShaderVariant& shader, int band_rows, const TileList& first,
                       const TileList* second);
  void end(TileList* first, TileList* second) const;

 private:
  Buffer counts_;
};

/// Quads of 2 x 2 grid points (shaders/bandwidth/quads.comp).
struct QuadList {
  Buffer quads;  ///< uint each, x | y << 16 of the first point
  int count = 0;
};
/// `invocations`: of a quad.
void dispatch_quads(const Program& program, const QuadList& list, int invocations);

}  // namespace maquette
