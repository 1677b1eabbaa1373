#pragma once

#include <glm/glm.hpp>
#include <vector>

namespace maquette {

/// Directions of a hemisphere in bins of a square parabolic map (shaders/shared/parabolic.glsl), local frame z =
/// normal. Bins are clipped at the horizon, once and here: their solid angles sum to 2 pi, projected to pi.
/// Only bins that reach above the horizon are numbered, row by row; row 0 is at y = -1.
class Lumisphere {
 public:
  static constexpr int kDefaultSide = 16, kLargestSide = 64;
  explicit Lumisphere(int side = kDefaultSide);

  int side() const { return side_; }
  int count() const { return static_cast<int>(bins_.size()); }
  /// Bin of a map cell [y * side + x], -1 below the horizon; and back.
  int bin_of_cell(int cell) const { return bin_of_cell_[static_cast<std::size_t>(cell)]; }
  int cell_of_bin(int bin) const { return bins_[static_cast<std::size_t>(bin)].cell; }
  /// Bin of a unit direction above the horizon.
  int bin_of(const glm::vec3& direction) const;
  /// Bin of a cell, or, below the horizon and beyond the map's border, the one next to it.
  int bin_near_cell(int x, int y) const;
  /// sr, clipped at the horizon.
  double solid_angle(int bin) const { return bins_[static_cast<std::size_t>(bin)].solid_angle; }
  /// Integral of the cosine over the clipped bin, sr.
  double projected(int bin) const { return bins_[static_cast<std::size_t>(bin)].projected; }
  /// Direction in which outgoing light is sampled: of the cell's centre, or, where that is below the horizon, of the
  /// point next to it at kGrazing of the disc's radius. Unit.
  glm::vec3 direction(int bin) const { return bins_[static_cast<std::size_t>(bin)].direction; }
  static constexpr float kGrazing = 0.98f;

  /// A direction of a bin. The mean of `weight` times a function over uniform (u, v) in [0, 1)^2 is the function's
  /// cosine-weighted mean over the clipped bin. `density`: 1/sr, with which the direction is drawn; weight 0: none was.
  struct Sample {
    glm::vec3 direction{0.0f, 0.0f, 1.0f};
    float weight = 0.0f, density = 0.0f;
  };
  Sample draw(int bin, const glm::vec2& uv) const;
  /// Density (1/sr) with which draw() gives a direction of this bin.
  float density(int bin, const glm::vec3& direction) const;

 private:
  static constexpr int kColumns = 16;  ///< of a bin's own sampling table
  struct Bin {
    int cell = 0;
    double solid_angle = 0.0, projected = 0.0;
    glm::vec3 direction{0.0f, 0.0f, 1.0f};
    float running[kColumns + 1] = {};  ///< running share of the columns' projected solid angles
  };
  /// A line of constant x through a bin. Along it samples have a linear density, as the projected solid angle nearly
  /// has, so that their weights are nearly constant.
  struct Column {
    float low = 0.0f, high = 0.0f;
    float slope = 0.0f;  ///< density of a position t in [0, 1]: 1 + slope (2 t - 1)
    float mass = 0.0f;   ///< of projected solid angle, any unit
  };
  Column column(const Bin& bin, float x) const;
  float low(int index) const { return -1.0f + 2.0f * static_cast<float>(index) / static_cast<float>(side_); }
  /// Density over the map's area at a point of the bin.
  float area_density(const Bin& bin, const glm::vec2& p) const;

  int side_;
  std::vector<Bin> bins_;
  std::vector<int> bin_of_cell_;
};

}  // namespace maquette
