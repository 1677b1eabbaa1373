#pragma once

#include <cstddef>
#include <vector>

#include "render/gl/objects.h"

namespace maquette {

/// Work items of a reflected point at most: one of a pane, more of a mirror, which shows more.
constexpr int kMostReflectedItems = 2;

/// The tiles of 8 x 8 grid points (shaders/shared/tiles.glsl) that show something, found with the G-buffer.
struct TileList {
  Buffer tiles;             ///< uint each, x | y << 16 in tiles; [band][tiles of a band]
  std::vector<int> counts;  ///< of each band
  bool dealt = false;       ///< every other one first: the cost of a tile follows its place in the picture
};
/// The order in which a list holds its tiles. Shaders append them as they get to them, but parts of the list are
/// predicted anew while the light turns, so that it must be the same in every run: by rows, runs of the upper and the
/// lower half by turns, since a software device gives each core one stretch of the list.
std::vector<unsigned> ordered_tiles(std::vector<unsigned> tiles);
/// Powers of two: how many invocations a tile takes, one a point, or one for four (shaders/shared/lookup.glsl).
constexpr int kTileLanes = 6, kLookupLanes = 4;

/// Quads of 2 x 2 grid points (shaders/bandwidth/quads.comp).
struct QuadList {
  Buffer quads;  ///< uint each, x | y << 16 of the first point
  int count = 0;
};

/// Images and lists whose size follows the picture's. Grid: width * side, height * side points (side^2 samples a
/// pixel).
struct FrameTargets {
  int width = 0, height = 0, side = 0;
  bool bandwidth = false, texture_bandwidth = false;
  int item_capacity = 0;  ///< work items of each list; grows with what frames ask for
  int most_items = 0;     ///< that a list may grow to
  int band_rows = 0;      ///< grid rows shaded at a time, a multiple of 32: bounds the lists for huge pictures
  TileList surface_tiles, sky_tiles, repainted_tiles;
  Buffer tile_counts;                 ///< of both lists, by band
  QuadList plain_quads, mixed_quads;  ///< with several points a pixel, mode `bandwidth`
  Buffer quad_counts;
  GlName<FramebufferTraits> framebuffer;
  Texture triangle, depth_buffer, surface, depth, guide, texture_nu;
  Texture weights;  ///< of upsampling (shaders/bandwidth/fill.comp)
  Texture open;     ///< of the sky, towards mirror directions (shaders/bandwidth/open.comp)
  /// Light by way of other surfaces at each point, of the bakes with even and odd numbers; made when first needed.
  Texture indirect[2];
  Texture energy, bend, axes, pyramid;
  Texture marks, radiance, picture;
  Buffer counters, items[2], points[2], partial[2];
  Texture partial_view[2];

  int grid_width() const { return width * side; }
  int grid_height() const { return height * side; }
  /// The prediction's quads make whole blocks of 2 x 2: tiles make the pyramid's second level as well.
  bool whole_blocks() const { return energy.width() % 2 == 0 && energy.height() % 2 == 0; }
  /// Entries of a band in the lists of tiles.
  int band_tiles() const { return (grid_width() + kTile - 1) / kTile * (band_rows / kTile); }
  /// Room for so many work items in each list, and some more; what they held is gone. False when they have it already,
  /// or may not grow.
  bool grow_lists(unsigned items);
  /// An empty list with room for all tiles.
  TileList make_tile_list() const;
  static constexpr int kTile = 8;
};

/// `chunked`: several work items a point (mode bandwidth). Throws Error when the picture is larger than the driver
/// allows.
FrameTargets make_frame_targets(int width, int height, int side, bool bandwidth, bool texture_bandwidth);

}  // namespace maquette
