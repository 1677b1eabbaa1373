#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/gl/objects.h"
#include "render/materials/brdf_tables.h"
#include "render/reflections/lobe_bound.h"

namespace maquette {

/// Measured tables on the GPU, one slot each; a loaded table stays, so that switching back costs nothing.
class MaterialStore {
 public:
  /// Slot of a BRDF source (`builtin:NAME` or a path); loads it if it is new. Throws Error and keeps the others.
  int slot_of(const std::string& source);
  /// Share of BRDF samples that balances a table's lobe against lights of effective solid angle `environment_sr`.
  float brdf_share(int slot, float environment_sr) const;
  /// The largest local bandwidth of a table, cycles/rad.
  float bandwidth_limit(int slot) const { return entries_[static_cast<std::size_t>(slot)].bandwidth_limit; }
  /// mirror_roughness of a table.
  float roughness(int slot) const { return entries_[static_cast<std::size_t>(slot)].roughness; }
  /// Fitted on first use, from the table on the GPU: the file is not read again.
  const GgxFit& ggx(int slot);
  const SgFit& sg(int slot);
  const LobeBound& lobe_bound(int slot);
  /// BrdfTables::albedo of a slot.
  const std::vector<glm::vec3>& albedo(int slot) const { return entries_[static_cast<std::size_t>(slot)].albedo; }
  /// Hash of the filled table; cache key of everything derived from it.
  std::uint64_t hash(int slot) const { return entries_[static_cast<std::size_t>(slot)].hash; }
  void bind() const;  ///< units 10 to 13, 16 and 44
  std::size_t bytes() const {
    return words_.bytes() + theta_.bytes() + phi_.bytes() + albedo_.bytes() + bandwidth_.bytes() + lobes_.bytes();
  }
  std::size_t count() const { return entries_.size(); }

 private:
  struct Entry {
    std::string source;
    std::uint64_t stamp = 0;  ///< of the source when it was read
    float lobe_sr = 1.0f;     ///< effective solid angle of the lobe at 35 degrees
    float bandwidth_limit = 0.0f;
    float roughness = 1.0f;  ///< roughness of the mirroring part
    GgxFit ggx;
    SgFit sg;
    LobeBound bound;
    std::uint64_t hash = 0;  ///< of the table: key of its fits in the disk cache
    std::vector<glm::vec3> albedo;
    bool has_ggx = false, has_sg = false, has_bound = false;
  };
  void reserve(std::size_t slots);
  BrdfTable read_table(std::size_t slot) const;
  std::vector<Entry> entries_;
  std::size_t capacity_ = 0;
  Buffer words_, theta_, phi_, albedo_, bandwidth_, lobes_;
  Texture word_view_, theta_view_, phi_view_, albedo_view_, bandwidth_view_, lobe_view_;
};

/// Effective solid angle 1 / (integral of p^2) of a density that the importance cells of `tables` give at one
/// elevation.
float effective_solid_angle(const BrdfTables& tables, int elevation);

}  // namespace maquette
