#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/frame/pass.h"
#include "render/frame/pass_timer.h"

namespace maquette {

/// What became of the planned passes of one frame: each was executed and timed, or skipped with a reason.
struct FrameRecord {
  std::vector<PassTime> times;  ///< of executed passes, in the order in which they first ended
  std::vector<SkippedPass> skipped;
};

/// Carries out the planned passes of one frame after the other, in order. Times each, and skips those whose key has not
/// changed since they last ran.
class Frame {
 public:
  /// Begins a frame. `software`: of the device, see PassTimer.
  void begin(bool software);
  /// Carries out `planned` by `passes`. `enter_layer` is called before the first pass of another layer than the one
  /// before. Every planned pass has exactly one that carries it out; anything else is our own mistake and asserts.
  void run(const std::vector<PlannedPass>& planned, const std::vector<Pass>& passes,
           const std::function<void(int)>& enter_layer);
  FrameRecord finish();

  PassTimer& timer() { return *timer_; }
  /// Called by a pass that carries out several planned ones: this one was not needed.
  void skip(const std::string& name, const std::string& why);
  /// The passes of a layer run again, whatever their keys: what they wrote is gone.
  void forget(int layer) {
    std::erase_if(keys_, [&](const auto& entry) { return entry.first.second == layer; });
  }

 private:
  using Id = std::pair<std::string, int>;  ///< name, layer
  void carry_out(const Pass& pass);

  std::map<Id, Key> keys_;  ///< that passes last ran with
  std::optional<PassTimer> timer_;
  std::vector<SkippedPass> skipped_;
  int layer_ = -1;  ///< of the pass at hand
};

}  // namespace maquette
