#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "render/gl/objects.h"
#include "render/indirect/indirect_worker.h"

namespace maquette {

/// The baked indirect light of one scene on the GPU, and the worker that makes it.
class IndirectBuffers {
 public:
  /// Starts a bake where `job` differs from the last one, and uploads one that is done; until then the old one stays,
  /// lit as it was. While the sky turns from call to call the next one waits for twice the time that the last one took:
  /// frames need the processor. True when what is drawn has changed. Throws what made a bake fail, once.
  bool update(const IndirectJob& job);
  void wait();   ///< until what `update` started is done; the next `update` uploads it
  void clear();  ///< forgets the bake: another scene
  /// The input of the last bake asked for; a new one is made only when something has changed.
  const std::shared_ptr<const IndirectInput>& input() const { return asked_input_; }

  bool ready() const { return static_cast<bool>(words_); }
  /// What is drawn is of the sky that was asked for last.
  bool current() const { return ready() && shown_ == asked_ && shown_input_ == asked_input_; }
  bool busy() const { return waiting_ || (worker_ && worker_->busy()); }
  double progress() const { return worker_ ? worker_->progress() : 0.0; }
  void bind() const;  ///< unit 45: [side][vertex] of four words (shaders/shared/indirect.glsl)
  int sides() const { return sides_; }
  int bias() const { return bias_; }
  std::size_t bytes() const { return words_.bytes(); }

 private:
  using Clock = std::chrono::steady_clock;
  void submit(const IndirectJob& job);
  std::unique_ptr<IndirectWorker> worker_;
  std::optional<IndirectJob> waiting_;  ///< asked for, not yet submitted
  Clock::time_point submitted_, done_;  ///< the last one
  std::shared_ptr<const IndirectInput> asked_input_, shown_input_;
  std::shared_ptr<const VisibilityBake> asked_visibility_;
  std::optional<IndirectSky> asked_, shown_;
  Buffer words_;
  Texture view_;
  int sides_ = 1, bias_ = 0;
};

}  // namespace maquette
