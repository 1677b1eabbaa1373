#pragma once

#include <functional>
#include <string>
#include <vector>

#include "render/frame/key.h"

namespace maquette {

/// One step of a frame as the plan has it: a plain value.
struct PlannedPass {
  std::string name;                     ///< one word of docs/vocabulary.md
  std::string reason;                   ///< why it is there
  std::vector<std::string> reads = {};  ///< resources (docs/vocabulary.md), each written by a pass before it
  std::vector<std::string> writes = {};
  int layer = -1;  ///< index in FramePlan::layers; -1: it is of the whole frame
};

/// A planned pass that a frame did not need to carry out.
struct SkippedPass {
  std::string name;
  std::string why;
  int layer = -1;
};

/// What carries out planned passes.
struct Pass {
  /// Of the plan. Several: one run carries them out together, because they take turns band by band or ray by ray,
  /// and `run` ends each on the timer (FrameContext::timer).
  std::vector<std::string> names;
  int layer = -1;
  /// All that its result depends on: it is skipped while that is the same as when it last ran. Asked when its turn
  /// comes. Null: it always runs.
  std::function<Key()> key = {};
  bool always = false;  ///< it runs though its key is unchanged; a later frame may skip it again
  /// Why this frame does not need it; an empty string: it does. May be null.
  std::function<std::string()> skip = {};
  std::function<void()> run = {};
};

}  // namespace maquette
