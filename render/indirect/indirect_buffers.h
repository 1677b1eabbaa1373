#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/bake/bake_runner.h"
#include "render/gl/objects.h"
#include "render/indirect/indirect_kind.h"

namespace maquette {

/// Indirect light under one sky, on the GPU.
struct IndirectKey {
  Buffer words;
  Texture view;
  IndirectSky sky;
  IndirectBounces bounces = IndirectBounces::all;
  std::shared_ptr<const IndirectInput> input;
  int sides = 1, bias = 0;
  std::uint32_t serial = 0;  ///< of the bake
};

/// The baked indirect light of one scene on the GPU. While the environment rotates, bakes are
/// made for where it is going to stand, and the picture lies between two of them: with visibility maps of 0.22 rad,
/// indirect light changes as smoothly.
class IndirectBuffers final : public BakeRunner<IndirectJob, IndirectResult> {
 public:
  IndirectBuffers() : BakeRunner(std::make_shared<IndirectKind>(), IndirectKind::spares) {}
  const char* name() const override { return "indirect"; }
  /// Starts a bake where `job` differs from the last one, and uploads one that is done; until then the old ones stay,
  /// lit as they were. True when there is another key than before. Throws what made a bake fail, once.
  bool update(const IndirectJob& job);
  /// By which the cache keeps the bake of `job`, whose visibility it does not need.
  std::string key(const IndirectJob& job) const { return kind().key(job); }
  void wait() override;  ///< until the very light that `update` was given is done
  void cancel() override {
    BakeRunner::cancel();
    submitted_.reset();
  }
  void clear();  ///< forgets the bake: another scene
  /// The input of the last bake asked for; a new one is made only when something has changed.
  const std::shared_ptr<const IndirectInput>& input() const { return asked_input_; }

  bool ready() const override { return !keys_.empty(); }
  /// What is drawn is all the light of the sky that was asked for last.
  bool current() const;
  bool busy() const override {
    return (ready() && !current()) || (BakeRunner::busy() && submitted_bounces_ != IndirectBounces::none);
  }
  /// Whether rays are traced as soon as there is time, so that an environment that starts to rotate need not wait for
  /// them: the cache on disk knows the answer for one light, and not them.
  void set_prepares(bool prepares) { prepares_ = prepares; }
  /// The one or two that the sky asked for last lies between, the earlier one first, and the weight of the last.
  const std::vector<IndirectKey>& keys() const { return keys_; }
  float blend() const;
  std::size_t bytes() const override;

 private:
  void submit_sky(float rotation_rad, IndirectBounces bounces);
  void follow(float turn_rad);
  void settle();  ///< asks for all the light of the sky as it stands
  void take_result();

  std::shared_ptr<const IndirectInput> asked_input_;
  std::shared_ptr<const VisibilityBake> asked_visibility_;
  std::optional<IndirectSky> asked_;
  std::optional<IndirectSky> submitted_;  ///< in work or done
  IndirectBounces submitted_bounces_ = IndirectBounces::all;
  bool prepares_ = false;
  std::shared_ptr<const IndirectInput> prepared_;  ///< whose rays were asked for
  int frames_ = 0;                                 ///< since the last one was submitted
  int latency_ = 4;                                ///< frames that the last one took
  std::uint32_t serial_ = 0;
  std::vector<IndirectKey> keys_;
};

}  // namespace maquette
