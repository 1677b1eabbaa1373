#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/prt/cube_light.h"
#include "render/prt/factorised_transfer.h"

namespace maquette {

/// Haar coefficients of a light that are kept: those of all faces whose |light| times importance is largest.
struct KeptLight {
  std::vector<std::uint32_t> coefficients;  ///< ascending
  std::vector<glm::vec3> values;            ///< of each
};

/// `light`: [coefficient][rgb], after haar_transform_faces. `importance`: [coefficient]. `count`: at most so many.
/// The weakest of them are dimmed, down to nothing beside the best one that is left away: what is kept changes steadily
/// with the light, and nothing pops in and out while it turns.
KeptLight choose_coefficients(const CubeLight& light, const std::vector<float>& importance, std::size_t count);

/// What the left away part of a light adds to sums, relative to those of all of it (RMS, by importance).
double light_left_out(const CubeLight& light, const KeptLight& kept, const std::vector<float>& importance);

/// The light that is left of it: radiance of each direction.
CubeLight light_of_coefficients(const KeptLight& kept, int side);

/// The light side of many factorised transfers, one below the other, laid out so that a new light reads only the
/// columns of its kept coefficients: [tile][coefficient][row of the tile], half floats.
class RelightTable {
 public:
  static constexpr std::size_t kTile = 512;  ///< rows

  RelightTable() = default;
  /// `side`: of the cube's faces. Space for `rows` rows. `channels`: 3 where each colour of light has a q of its own.
  RelightTable(int side, std::size_t rows, int channels = 1);
  /// Appends one transfer's rows; returns the first. Throws nothing; `rows` of the constructor are not to be exceeded.
  std::size_t add(const TransferMatrix& matrix);

  std::size_t rows() const { return rows_; }
  std::size_t coefficients() const { return static_cast<std::size_t>(6 * side_ * side_); }
  /// [coefficient] RMS of q over the rows, each weighted by how many vertices use it (weights of components have the
  /// mean square 1).
  std::vector<float> importance() const;
  /// [row] sum over the kept coefficients of q times light, on all cores, in a fixed order: the same for every
  /// processor and number of threads.
  void sums(const KeptLight& light, std::vector<glm::vec4>* out) const;
  /// The same by plain scalar code, for comparison.
  void sums_by_scalars(const KeptLight& light, std::vector<glm::vec4>* out) const;
  std::size_t bytes() const { return q_.size() * sizeof(std::uint16_t); }

 private:
  std::size_t channel_size() const { return q_.size() / static_cast<std::size_t>(channels_); }
  template <typename Tile>
  void for_tiles(const Tile& tile, std::vector<glm::vec4>* out) const;

  int side_ = 0, channels_ = 1;
  std::size_t rows_ = 0;
  std::vector<std::uint16_t> q_;  ///< [channel][tile][coefficient][row of the tile]
  std::vector<double> squares_;   ///< [coefficient]
  double uses_ = 0.0;
};

/// The light's Haar coefficients under a rotation.
CubeLight haar_light(const CubePyramid& pyramid, const CubeDirections& directions,
                     const glm::dmat3& environment_from_cube);

}  // namespace maquette
