#pragma once

#include <cstddef>
#include <vector>

#include "render/gbuffer/tiles.h"

namespace maquette {

/// Work items of a reflected point at most: one of a pane, more of a mirror, which shows more.
constexpr int kMostReflectedItems = 2;

/// Lists of shading work for one band of the grid, of measured and of analytic materials, which run different code.
struct WorkLists {
  int capacity = 0;   ///< work items of each list; grows with what frames ask for
  int most = 0;       ///< that a list may grow to
  int least = 0;      ///< items of each list at least: what the prediction lists there
  int band_rows = 0;  ///< grid rows shaded at a time, a multiple of 32: bounds the lists for huge pictures
  Buffer counters;    ///< List of shaders/shading/shade.comp, twice
  Buffer items[2], points[2], partial[2];
  Texture partial_view[2];

  /// Binds what the shaders that list work write.
  void bind() const;
  /// Room for so many work items in each list, and some more; what they held is gone. False when they have it already,
  /// or may not grow.
  bool grow(unsigned items);
  std::size_t bytes() const { return 2 * (items[0].bytes() + points[0].bytes() + partial[0].bytes()); }
};

/// `predicted`: several work items a point, as prediction and measurement ask for, and quads of the prediction.
WorkLists make_work_lists(const GridSize& size, bool predicted);
int band_rows_of(const GridSize& size, bool predicted);

/// Group counts of the indirect dispatches, from the lists' lengths (shaders/shading/arguments.comp).
void count_groups(const WorkLists& lists, ProgramCache* programs);

}  // namespace maquette
