#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "render/reference/hash_grid.h"
#include "render/reference/path_scene.h"

namespace maquette {

class EnvironmentLight;

/// Learns in which directions surfaces see lamps mirrored in panes, so that rays are sent there: a shadow ray cannot
/// find such a lamp, and a scattered ray finds it once in a hundred thousand.
///
/// Light is traced from the lamps over the panes to the next surface. Its directions of arrival are kept for each cell
/// of a HashGrid as a histogram over bins of equal solid angle. Scattered rays are then drawn from a mixture of BRDF
/// and histogram, so estimates stay unbiased whatever was learned. Source: Jensen 1995, "Importance Driven Path Tracing
/// Using the Photon Map" (the idea). Differs: only light that panes reflect.
class MirrorGuide {
 public:
  MirrorGuide(const PathScene& scene, const EnvironmentLight& environment, const HashGrid& grid, std::uint32_t seed);

  /// Traces `count` more light paths over the panes. Not while others use the guide; the result does not depend on the
  /// number of threads.
  void learn(std::size_t count);
  std::uint32_t cell_of(const glm::vec3& position, const glm::vec3& normal) const {
    return grid_.cell_of(position, normal);
  }
  /// Prefetches what has_light reads. Always inlined, as LightGuide::prefetch.
  [[gnu::always_inline]] void prefetch(std::uint32_t cell) const { __builtin_prefetch(&starts_[cell]); }
  /// Whether any light arrived in this cell.
  bool has_light(std::uint32_t cell) const { return starts_[cell + 1] > starts_[cell]; }
  /// Prefetches what sample and pdf read first in a cell with light.
  [[gnu::always_inline]] void prefetch_entries(std::uint32_t cell) const {
    __builtin_prefetch(&entries_[(starts_[cell] + starts_[cell + 1]) / 2]);
  }
  /// World direction towards a pane, in a cell with light.
  glm::vec3 sample(std::uint32_t cell, const glm::vec2& u) const;
  /// 1/sr.
  float pdf(std::uint32_t cell, const glm::vec3& direction) const;
  /// Density (1/sr) of a mixture: the share `mirror_share` is drawn by this guide and the rest with density `own`.
  float mixed_pdf(float own, std::uint32_t cell, float mirror_share, const glm::vec3& direction) const {
    return mirror_share > 0.0f ? (1.0f - mirror_share) * own + mirror_share * pdf(cell, direction) : own;
  }

 private:
  struct Arrival {
    std::uint32_t cell = HashGrid::kNoCell, bin = 0;
    double flux = 0.0;  ///< any unit
  };
  struct Entry {
    std::uint32_t bin;
    float cumulative;  ///< inclusive, over the cell's entries
  };
  static constexpr std::uint32_t kCopies = 8;  ///< of one light path's arrival, at positions and in directions close by
  /// Share of the light paths to a pane that start at lamps, in this cell of the light grid.
  float share_of_lamps(std::size_t cell) const;
  /// Leaves `arrivals` unchanged where the light does not arrive.
  void trace_light(std::uint32_t index, std::span<Arrival, kCopies> arrivals) const;
  void merge_arrivals(std::vector<Arrival> arrivals);

  const PathScene& scene_;
  const EnvironmentLight& environment_;
  HashGrid grid_;
  std::uint32_t seed_;
  std::uint32_t traced_ = 0;
  std::vector<std::uint32_t> panes_;   ///< triangles
  std::vector<double> areas_;          ///< [pane] cumulative
  std::vector<Arrival> arrivals_;      ///< merged, by cell and bin
  std::vector<std::uint32_t> starts_;  ///< [cell + 1] first entry
  std::vector<Entry> entries_;
};

}  // namespace maquette
