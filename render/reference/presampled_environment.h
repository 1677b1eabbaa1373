#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/reference/light_sampling.h"

namespace maquette {

/// A direction of the environment, sampled by the plain importance.
struct alignas(32) PresampledDirection {
  glm::vec3 direction{};  ///< world, unit
  float density;          ///< 1/sr, of the plain importance
  glm::vec3 radiance{};   ///< cd/m2
};

/// Directions towards the environment, sampled before paths need them. For each leaf of the partition, the unit square
/// of random numbers is divided into a grid of strata, with one direction sampled uniformly in each. A path then reads
/// one entry instead of searching through tables of megabytes.
///
/// Each direction has the density of its leaf, so each estimate is unbiased by itself; paths only share the position of
/// a direction within its stratum. There is a new set for every kPathsASet paths. From kMostPaths on, every path
/// samples its own directions, so that pictures converge without limit. A guide that learns from the first set and then
/// samples from it correlates its densities with the same jitter, for the first 64 paths: a second-order effect, below
/// their noise. Source: Wyman and Panteleev 2021, "Rearchitecting Spatiotemporal Resampling for Production", Sec. 4.1
/// (presampled lights; the strata are ours).
class PresampledEnvironment {
 public:
  static constexpr std::uint32_t kPathsASet = 64;
  static constexpr std::uint32_t kMostPaths = 1024;
  static constexpr int kMostSide = 32;  ///< strata along each axis

  /// `environment`: without a guide. `pixels`: a picture with few of them gets a smaller first set.
  PresampledEnvironment(const EnvironmentLight& environment, int leaves, std::size_t pixels, std::uint32_t seed);

  /// Samples the directions for the first `paths` paths of a pixel. Not while others use the samples.
  void prepare(std::uint32_t paths);
  /// Whether prepare has made directions for a path.
  bool serves(std::uint32_t path) const { return path / kPathsASet < sets_.size(); }
  /// The direction for path `path`, by two numbers in [0, 1).
  const PresampledDirection& at(std::uint32_t path, int leaf, const glm::vec2& within) const {
    const Set& set = sets_[path / kPathsASet];
    const auto side = static_cast<float>(set.side);
    const int column = static_cast<int>(within.x * side), row = static_cast<int>(within.y * side);
    return set.samples[static_cast<std::size_t>((leaf * set.side + row) * set.side + column)];
  }

 private:
  struct Set {
    int side = 0;
    std::vector<PresampledDirection> samples;  ///< [leaf][row][column]
  };
  Set draw_set(int side) const;

  EnvironmentLight environment_;
  int leaves_, first_side_;
  std::uint32_t seed_;
  std::vector<Set> sets_;
};

}  // namespace maquette
