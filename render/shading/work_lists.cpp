#include "render/shading/work_lists.h"

#include <algorithm>

#include "render/gl/bindings.h"

namespace maquette {

namespace {

void make_item_lists(WorkLists* lists) {
  for (int k = 0; k < 2; ++k) {
    lists->items[k] = Buffer("work items", static_cast<std::size_t>(std::max(lists->capacity, lists->least)) * 8);
    lists->partial[k] = Buffer("partial sums", static_cast<std::size_t>(lists->capacity) * 16);
    lists->partial_view[k] = Texture::make_buffer("partial sums", GL_RGBA32F, lists->partial[k]);
  }
}

}  // namespace

void WorkLists::bind() const {
  for (GLuint k = 0; k < 2; ++k) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, k == 0 ? kBufferMeasuredItems : kBufferAnalyticItems, items[k].get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, k == 0 ? kBufferMeasuredPoints : kBufferAnalyticPoints, points[k].get());
  }
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferCounters, counters.get());
}

bool WorkLists::grow(unsigned wanted) {
  const auto now = static_cast<unsigned>(capacity), limit = static_cast<unsigned>(most);
  if (wanted <= now || now >= limit) return false;
  capacity = static_cast<int>(std::min(limit, std::max(wanted + wanted / 4, 2 * now)));
  make_item_lists(this);
  return true;
}

int band_rows_of(const GridSize& size, bool predicted) {
  // One item a point in uniform, about eight where they are predicted (the sample counts average to the base count).
  // The largest list stays below the 128 MiB that a storage buffer may have.
  const int band_points = predicted ? 1 << 19 : 1 << 20;
  return std::clamp(band_points / size.grid_width() / 32 * 32, 32, group_count(size.grid_height(), 32) * 32);
}

WorkLists make_work_lists(const GridSize& size, bool predicted) {
  WorkLists lists;
  const int w = size.grid_width();
  lists.band_rows = band_rows_of(size, predicted);
  const int band_points = w * std::min(lists.band_rows, size.grid_height());
  // The reflected picture is shaded by four rows at least. Frames of default counts ask for less than two a point.
  lists.capacity = std::max({(predicted ? 2 : 1) * band_points, 4 * kMostReflectedItems * w, 4096});
  lists.most = std::max(predicted ? 10 * band_points : 0, lists.capacity);
  // The prediction lists its quads there (classify.comp): those of a tile, with several points a pixel one in four.
  const int tiles = group_count(w, kTileSide) * group_count(size.grid_height(), kTileSide);
  lists.least = predicted ? tiles * (size.side > 1 ? 4 : 16) : 0;
  lists.counters = Buffer("counters", 2 * 8 * sizeof(unsigned));
  for (Buffer& points : lists.points) points = Buffer("shaded points", static_cast<std::size_t>(band_points) * 16);
  make_item_lists(&lists);
  return lists;
}

void count_groups(const WorkLists& lists, ProgramCache* programs) {
  dispatch(programs->get({"shading/arguments.comp", "", {}}), 1, 1);
  glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, lists.counters.get());
}

}  // namespace maquette
