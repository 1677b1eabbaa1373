#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/reference/light_sampling.h"

namespace maquette {

/// A direction of the environment, drawn by the plain importance.
struct alignas(32) PresampledDirection {
  glm::vec3 direction;  ///< world, unit
  float density;        ///< 1/sr, without a guide
  glm::vec3 radiance;   ///< cd/m2
};

/// Directions towards the environment, drawn before paths need them: over the two numbers that choose within a leaf of
/// the partition lies a grid of strata, each with one direction drawn evenly in it. A draw is one read then, instead of
/// searches through tables of megabytes.
///
/// Each direction has the leaf's own density, so each estimate is unbiased by itself; what paths share is where in its
/// stratum a direction lies. Others are taken every kPathsASet paths, and from kMostPaths on every path draws its own,
/// so that pictures converge without limit. A guide that learns from the first set and draws from it again ties its
/// densities to the same jitter, for the first 64 paths: a second-order effect, below their noise. Source: Wyman and
/// Panteleev 2021, "Rearchitecting Spatiotemporal Resampling for Production", Sec. 4.1 (lights presampled; the strata
/// are ours).
class PresampledEnvironment {
 public:
  static constexpr std::uint32_t kPathsASet = 64;
  static constexpr std::uint32_t kMostPaths = 1024;
  static constexpr int kMostSide = 32;  ///< strata along each number

  /// `environment`: without a guide. `pixels`: few of them are not worth many directions for their first paths.
  PresampledEnvironment(const EnvironmentLight& environment, int leaves, std::size_t pixels, std::uint32_t seed);

  /// Draws what the first `paths` paths of a pixel need. Not while others use the samples.
  void prepare(std::uint32_t paths);
  /// Whether there are directions for a path; prepare has to have drawn them.
  static bool serves(std::uint32_t path) { return path < kMostPaths; }
  /// Of path `path`, by two numbers in [0, 1).
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
