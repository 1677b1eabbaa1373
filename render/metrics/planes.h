#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace maquette {

/// One channel of a picture, row 0 on top, as input of the metrics' filters.
struct Plane {
  int width = 0;
  int height = 0;
  std::vector<float> data;
  Plane() = default;
  Plane(int w, int h) : width(w), height(h), data(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
};
using Planes = std::array<Plane, 3>;

/// An odd number of weights; the middle one belongs to the pixel itself.
using Kernel = std::vector<float>;

/// Convolves rows with `across`, then columns with `down`; border pixels are repeated outwards.
Plane convolve(const Plane& plane, const Kernel& across, const Kernel& down);

}  // namespace maquette
