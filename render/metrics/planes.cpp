#include "render/metrics/planes.h"

#include <algorithm>

#include "scenes/parallel.h"

namespace maquette {
namespace {

int index_in(int i, int count) { return std::clamp(i, 0, count - 1); }

}  // namespace

Plane convolve(const Plane& plane, const Kernel& across, const Kernel& down) {
  const int w = plane.width, h = plane.height;
  const auto stride = static_cast<std::size_t>(w);
  const int rx = static_cast<int>(across.size()) / 2, ry = static_cast<int>(down.size()) / 2;
  Plane rows(w, h), result(w, h);
  parallel_ranges<int>(0, h, 16, [&](const IndexRange<int>& range) {
    std::vector<float> padded(stride + across.size() - 1);
    for (int y = range.begin(); y < range.end(); ++y) {
      const float* in = &plane.data[static_cast<std::size_t>(y) * stride];
      for (std::size_t i = 0; i < padded.size(); ++i)
        padded[i] = in[static_cast<std::size_t>(index_in(static_cast<int>(i) - rx, w))];
      float* out = &rows.data[static_cast<std::size_t>(y) * stride];
      for (std::size_t k = 0; k < across.size(); ++k) {
        const float *from = padded.data() + k, weight = across[k];
#pragma omp simd
        for (std::size_t x = 0; x < stride; ++x) out[x] += weight * from[x];
      }
    }
  });
  parallel_ranges<int>(0, h, 16, [&](const IndexRange<int>& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      float* out = &result.data[static_cast<std::size_t>(y) * stride];
      for (std::size_t k = 0; k < down.size(); ++k) {
        const auto row = static_cast<std::size_t>(index_in(y + static_cast<int>(k) - ry, h));
        const float *from = &rows.data[row * stride], weight = down[k];
#pragma omp simd
        for (std::size_t x = 0; x < stride; ++x) out[x] += weight * from[x];
      }
    }
  });
  return result;
}

}  // namespace maquette
