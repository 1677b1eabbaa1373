#pragma once

#include <vector>

#include "render/renderer.h"
#include "tests/benchmarks/stage.h"

/// The parts of a converged picture: a few very bright texels (a sun) by quadrature, everything else by samples.
namespace maquette::bench {

/// Light of a piece of the sphere that is small enough to stand for by its middle.
struct BrightDirection {
  glm::vec4 direction;  ///< xyz unit, environment's frame
  glm::vec4 light;      ///< rgb: integral of radiance over its solid angle (stored units * sr)
};

/// The environment as the shaders' tables hold it, in two summands that are packed without loss.
struct SplitEnvironment {
  std::shared_ptr<const Environment> rest;  ///< without its brightest texels
  std::vector<BrightDirection> bright[2];   ///< what was taken away, on a grid and on a finer one
};
/// Takes away the texels above 50 times the mean, at most 256; without such `rest` is all and `bright` is empty.
SplitEnvironment split_environment(const Environment& environment);

/// Reflected light of `directions` at every point of the last frame's G-buffer, by the product's own point and BRDF
/// formulas without any random choice. RGB in cd/m2, alpha as the view's.
Image shade_directions(Renderer& renderer, const std::vector<BrightDirection>& directions, bool all_measured);

/// The scene without panes and blended surfaces.
std::shared_ptr<const Scene> without_panes(const Scene& scene);

}  // namespace maquette::bench
