#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "render/bake/bake_runner.h"
#include "render/gl/objects.h"
#include "render/scene_state/geometry.h"
#include "render/visibility/visibility_kind.h"

namespace maquette {

struct VisibilityKey {
  std::uint32_t geometry_epoch = 0;
  std::vector<bool> transmits;
  std::vector<Passage> passages;
  bool operator==(const VisibilityKey&) const = default;
};

/// The visibility bake of one scene on the GPU.
class VisibilityBuffers final : public KeyedBake<VisibilityKey, VisibilityJob, DrawnVisibility> {
 public:
  VisibilityBuffers() : KeyedBake(std::make_shared<VisibilityKind>()) {}
  const char* name() const override { return "visibility"; }
  /// Starts a bake when `geometry_epoch`, `transmits` or `passages` differ from those of the last one, and uploads one
  /// that is done; until then the old one stays. True when what is drawn has changed. Throws what made a bake fail,
  /// once.
  bool update(const FlatGeometry& geometry, const std::vector<bool>& transmits, const std::vector<Passage>& passages,
              std::uint32_t geometry_epoch);
  /// By which the cache keeps the bake of this.
  std::string key(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                  const std::vector<Passage>& passages) const;
  /// Forgets the bake: another scene.
  void clear();

  /// The bake that is drawn with; null while there is none.
  const std::shared_ptr<const VisibilityBake>& bake() const { return bake_; }
  bool ready() const override { return static_cast<bool>(words_); }
  void bind() const;  ///< units 25 (words, [vertex][side][18]), 30 (bandwidth, [vertex], cycles/m) and 35
                      ///< (transmittance, [vertex])
  std::size_t bytes() const override { return words_.bytes() + bandwidth_.bytes() + transmittance_.bytes(); }

 private:
  std::shared_ptr<const VisibilityBake> bake_;
  Buffer words_, bandwidth_, transmittance_;
  Texture word_view_, bandwidth_view_, transmittance_view_;
};

}  // namespace maquette
