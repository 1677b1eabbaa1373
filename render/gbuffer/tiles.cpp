#include "render/gbuffer/tiles.h"

#include <algorithm>
#include <utility>

#include "render/gl/bindings.h"

namespace maquette {

TileList make_tile_list(const GridSize& size, int band_rows) {
  const auto bands = static_cast<std::size_t>(group_count(size.grid_height(), band_rows));
  TileList list;
  list.band_tiles = group_count(size.grid_width(), kTileSide) * (band_rows / kTileSide);
  list.tiles = Buffer("tiles", bands * static_cast<std::size_t>(list.band_tiles) * sizeof(unsigned));
  list.counts.assign(bands, 0);
  return list;
}

std::vector<unsigned> ordered_tiles(std::vector<unsigned> tiles) {
  constexpr std::size_t kRun = 16;
  std::sort(tiles.begin(), tiles.end());
  const std::size_t half = (tiles.size() + 1) / 2;
  std::vector<unsigned> ordered;
  ordered.reserve(tiles.size());
  const auto append = [&](std::size_t first, std::size_t limit) {
    for (std::size_t i = first; i < std::min(first + kRun, limit); ++i) ordered.push_back(tiles[i]);
  };
  for (std::size_t run = 0; run < half; run += kRun) {
    append(run, half);
    append(half + run, tiles.size());
  }
  return ordered;
}

void order_tiles(TileList* list) {
  for (std::size_t band = 0; band < list->counts.size(); ++band) {
    std::vector<unsigned> tiles(static_cast<std::size_t>(list->counts[band]));
    if (tiles.empty()) continue;
    const std::size_t offset = band * static_cast<std::size_t>(list->band_tiles) * sizeof(unsigned);
    list->tiles.read(offset, tiles.size() * sizeof(unsigned), tiles.data());
    tiles = ordered_tiles(std::move(tiles));
    list->tiles.update(offset, tiles.size() * sizeof(unsigned), tiles.data());
  }
}

void dispatch_tiles(const Program& program, const TileList& list, int shift, std::optional<std::size_t> band,
                    TileShare share) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferTiles, list.tiles.get());
  const std::size_t first = band.value_or(0), last = band ? first + 1 : list.counts.size();
  for (std::size_t b = first; b < last; ++b) {
    const int count = (list.counts[b] - share.first + share.step - 1) / share.step;
    if (count <= 0) continue;
    glProgramUniform4i(program.get(), program.location("u_tiles"),
                       static_cast<int>(b) * list.band_tiles + share.first, count, share.step, list.interleaved);
    dispatch_list(program, count << shift);
  }
}

TileCounter::TileCounter(std::size_t bands) : counts_("tile counts", bands * 2 * sizeof(unsigned)) {}

const Program& TileCounter::begin(ProgramCache* programs, const ShaderVariant& shader, int band_rows,
                                  const TileList& first, const TileList* second) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferTileCounts, counts_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, first.tiles.get());
  if (second) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, second->tiles.get());
  counts_.clear_to_zero();
  const Program& program = programs->get(shader);
  program.set("u_band_rows", band_rows / kTileSide);
  return program;
}

void TileCounter::end(TileList* first, TileList* second) const {
  std::vector<unsigned> counts(2 * first->counts.size());
  counts_.read(0, counts_.bytes(), counts.data());
  for (std::size_t band = 0; band < first->counts.size(); ++band) {
    first->counts[band] = static_cast<int>(counts[2 * band]);
    if (second) second->counts[band] = static_cast<int>(counts[2 * band + 1]);
  }
}

void dispatch_quads(const Program& program, const QuadList& list, int invocations) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferQuads, list.quads.get());
  program.set("u_quads", list.count);
  dispatch_list(program, invocations * list.count);
}

}  // namespace maquette
