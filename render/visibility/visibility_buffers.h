#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/geometry.h"
#include "render/gl/objects.h"
#include "render/visibility/visibility_worker.h"

namespace maquette {

/// The visibility bake of one scene on the GPU, and the worker that makes it.
class VisibilityBuffers {
 public:
  /// Starts a bake when `geometry_epoch`, `transmits` or `passages` differ from those of the last one, and uploads one
  /// that is done; until then the old one stays. True when what is drawn has changed. Throws what made a bake fail,
  /// once.
  bool update(const FlatGeometry& geometry, const std::vector<bool>& transmits, const std::vector<Passage>& passages,
              std::uint32_t geometry_epoch);
  /// Waits for the bake that `update` started; the next `update` uploads it.
  void wait();
  /// Forgets the bake: another scene.
  void clear();

  /// The bake that is drawn with; null while there is none.
  const std::shared_ptr<const VisibilityBake>& bake() const { return bake_; }
  bool ready() const { return static_cast<bool>(words_); }
  bool busy() const { return worker_ && worker_->busy(); }
  double progress() const { return worker_ ? worker_->progress() : 0.0; }
  void bind() const;  ///< units 25 (words, [vertex][side][18]), 30 (bandwidth, [vertex], cycles/m) and 35
                      ///< (transmittance, [vertex])
  std::size_t bytes() const { return words_.bytes() + bandwidth_.bytes() + transmittance_.bytes(); }

 private:
  std::unique_ptr<VisibilityWorker> worker_;
  std::vector<bool> transmits_;
  std::vector<Passage> passages_;
  std::uint32_t geometry_epoch_ = 0;
  bool asked_ = false;
  std::shared_ptr<const VisibilityBake> bake_;
  Buffer words_, bandwidth_, transmittance_;
  Texture word_view_, bandwidth_view_, transmittance_view_;
};

}  // namespace maquette
