#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "ui/editor_state.h"

namespace maquette {

/// Stores the edits before each finished change: a drag of a slider is one step.
class UndoStack {
 public:
  static constexpr std::size_t kDepth = 200;

  /// Call every frame. `busy`: a control or the mouse is held, the change continues.
  void observe(const Edits& edits, bool busy) {
    if (!settled_) settled_ = edits;
    if (busy || edits == *settled_) return;
    if (past_.size() == kDepth) past_.erase(past_.begin());
    past_.push_back(*settled_);
    settled_ = edits;
  }
  bool can_undo() const { return !past_.empty(); }
  /// The edits before the last change; nothing when there is none.
  std::optional<Edits> undo() {
    if (past_.empty()) return std::nullopt;
    settled_ = past_.back();
    past_.pop_back();
    return settled_;
  }
  /// A new scene: its first state is `edits`.
  void reset(const Edits& edits) {
    past_.clear();
    settled_ = edits;
  }
  /// `edits`: the part of the last change that could be applied; this is not a step of its own.
  void correct(const Edits& edits) {
    settled_ = edits;
    if (!past_.empty() && past_.back() == edits) past_.pop_back();
  }

 private:
  std::vector<Edits> past_;
  std::optional<Edits> settled_;
};

}  // namespace maquette
