#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/parallel.h"

namespace maquette {

/// One level of a mip chain, linear RGBA, row 0 on top.
struct MipLevel {
  int width = 0, height = 0;
  std::vector<glm::vec4> texels;
  const glm::vec4& at(int x, int y) const {
    return texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

/// Source texels that texel `i` of `count` covers along one axis of `size`, with their shares.
struct MipSpan {
  int first, last;
  float begin, end;
  MipSpan(int i, int count, int size) {
    const float step = static_cast<float>(size) / static_cast<float>(count);
    begin = static_cast<float>(i) * step;
    end = begin + step;
    first = static_cast<int>(begin);
    last = std::min(static_cast<int>(std::ceil(end)), size) - 1;
  }
  float share(int source) const {
    const auto at = static_cast<float>(source);
    return (std::min(end, at + 1.0f) - std::max(begin, at)) / (end - begin);
  }
};

/// The level of half the size, rounded down, of an image of `width` x `height` texels `texel(x, y)`: each texel is the
/// mean of the area that it covers, so that the mean over the image stays the same for odd sizes too.
template <typename Texel>
MipLevel halve(int width, int height, const Texel& texel) {
  MipLevel out{std::max(1, width / 2), std::max(1, height / 2), {}};
  out.texels.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  parallel_for(0, out.height, [&](int y) {
    const MipSpan rows(y, out.height, height);
    glm::vec4* target = &out.texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(out.width)];
    for (int x = 0; x < out.width; ++x) {
      const MipSpan columns(x, out.width, width);
      glm::vec4 sum(0.0f);
      for (int sy = rows.first; sy <= rows.last; ++sy)
        for (int sx = columns.first; sx <= columns.last; ++sx)
          sum += rows.share(sy) * columns.share(sx) * texel(sx, sy);
      target[x] = sum;
    }
  });
  return out;
}

inline MipLevel halve(const MipLevel& level) {
  return halve(level.width, level.height, [&](int x, int y) { return level.at(x, y); });
}

}  // namespace maquette
