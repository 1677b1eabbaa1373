#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "render/reference/path_scene.h"
#include "render/reference/place_grid.h"

namespace maquette {

class EnvironmentLight;

/// Learns where lamps are seen mirrored in panes, so that surfaces lit this way look there: a shadow ray cannot find
/// such a lamp, and a scattered one finds it once in a hundred thousand.
///
/// Light is sent from the lamps over the panes to the next surface; the directions in which it arrives are kept by the
/// place (PlaceGrid) as a histogram over bins of equal solid angle. Scattered rays are then drawn from a mixture of
/// BRDF and histogram, so estimates stay unbiased whatever was learned. Source: Jensen 1995, "Importance Driven Path
/// Tracing Using the Photon Map" (the idea). Differs: light over panes only.
class MirrorGuide {
 public:
  MirrorGuide(const PathScene& scene, const EnvironmentLight& environment, const PlaceGrid& grid, std::uint32_t seed);

  /// Sends `count` more lights over the panes. Not while others use the guide; the same for any number of threads.
  void learn(std::size_t count);
  std::uint32_t cell_of(const glm::vec3& position, const glm::vec3& normal) const {
    return grid_.cell_of(position, normal);
  }
  /// Fetches what knows reads, ahead of time. In line at once, as LightGuide::prefetch.
  [[gnu::always_inline]] void prefetch(std::uint32_t cell) const { __builtin_prefetch(&starts_[cell]); }
  /// Whether any light arrived in this cell.
  bool knows(std::uint32_t cell) const { return starts_[cell + 1] > starts_[cell]; }
  /// Fetches what sample and pdf read first in a cell that it knows, ahead of time.
  [[gnu::always_inline]] void prefetch_entries(std::uint32_t cell) const {
    __builtin_prefetch(&entries_[(starts_[cell] + starts_[cell + 1]) / 2]);
  }
  /// World direction towards a pane, in a cell that it knows.
  glm::vec3 sample(std::uint32_t cell, const glm::vec2& u) const;
  /// 1/sr.
  float pdf(std::uint32_t cell, const glm::vec3& direction) const;
  /// 1/sr of directions of which the share `mirror_share` is drawn here and the others with density `own`.
  float mixed_pdf(float own, std::uint32_t cell, float mirror_share, const glm::vec3& direction) const {
    return mirror_share > 0.0f ? (1.0f - mirror_share) * own + mirror_share * pdf(cell, direction) : own;
  }

 private:
  struct Arrival {
    std::uint32_t cell = PlaceGrid::kNoCell, bin = 0;
    double flux = 0.0;  ///< any unit
  };
  struct Entry {
    std::uint32_t bin;
    float cumulative;  ///< inclusive, over the cell's entries
  };
  static constexpr std::uint32_t kCopies = 8;  ///< of one light's arrival, at places and in directions close by
  /// Of the light that is sent to a pane in this cell of the grid of lights.
  float share_of_lamps(std::size_t cell) const;
  /// Leaves them as they are where it does not arrive.
  void send(std::uint32_t index, std::span<Arrival, kCopies> arrivals) const;
  void collect(std::vector<Arrival> arrivals);

  const PathScene& scene_;
  const EnvironmentLight& environment_;
  PlaceGrid grid_;
  std::uint32_t seed_;
  std::uint32_t sent_ = 0;
  std::vector<std::uint32_t> panes_;   ///< triangles
  std::vector<double> areas_;          ///< [pane] cumulative
  std::vector<Arrival> arrivals_;      ///< merged, by cell and bin
  std::vector<std::uint32_t> starts_;  ///< [cell + 1] first entry
  std::vector<Entry> entries_;
};

}  // namespace maquette
