#pragma once

#include <vector>

#include "tests/support/radiosity.h"

namespace maquette::test {

/// builtin:cornell as diffuse triangles: world positions, the materials' own albedo and emission.
std::vector<DiffuseTriangle> cornell_triangles();

struct CornellPixel {
  int x = 0, y = 0;
  SurfaceHit hit;
};

/// The scene's camera `front`, square pictures, rays through pixel centres.
class CornellView {
 public:
  explicit CornellView(int side) : side_(side) {}
  /// Pixels that see the front of a flat surface, at least 15 cm from where walls meet. The smoothly shaded bevels of
  /// the boxes are excluded.
  std::vector<CornellPixel> pixels(const Radiosity& radiosity) const;
  int side() const { return side_; }

 private:
  int side_;
};

}  // namespace maquette::test
