#pragma once

#include <deque>
#include <string>
#include <variant>
#include <vector>

#include "viewer/window_input.h"

namespace maquette {

/// A key that was pressed or, for the modifiers alone, released, and the letter that it writes.
struct KeyEvent {
  int key = 0;  ///< GLFW_KEY_..., of letters where this keyboard has them; 0: of text alone
  bool ctrl = false, shift = false;
  bool released = false;
  bool repeated = false;  ///< the key is held
  unsigned text = 0;      ///< Unicode; 0: none
};
bool is_modifier(int key);
/// Arrows, Space, Enter and the like, which belong to the control that has the keyboard.
bool moves_among_controls(int key);
/// As the list of shortcuts writes it (ui/shortcuts.h): `Ctrl+Shift+Z`, `Page Up`, `[`; Shift counts beside Ctrl and
/// letters only.
std::string written_key(const KeyEvent& event);

/// What one frame of the window gets.
struct InputBatch {
  std::vector<PointerEvent> pointer;
  std::vector<KeyEvent> keys;
  bool typing = false;  ///< the keys write into a text field
};

/// Events that the callbacks collect between two frames. Frames may be slow: what a user does meanwhile is handed out
/// later in its order, no more in a frame than the panels can tell apart.
class Inbox {
 public:
  void add(const PointerEvent& event);
  /// Nothing where the same held key is waiting already.
  void add(const KeyEvent& event);
  /// Of the key before, if that writes nothing yet.
  void add_text(unsigned letter);

  /// Moves, and one turn of a button, or one key, or a run of letters into a text field. `typing`: a text field has
  /// the keyboard; `wait`: one is about to get it, and keys wait for that.
  InputBatch next(bool typing, bool wait);
  bool empty() const { return events_.empty(); }
  int waiting() const { return static_cast<int>(events_.size()); }

  std::vector<std::string> dropped;
  double last_event_s = -1e9;
  /// After the events so far: glfwGetCursorPos may already be ahead of an earlier press.
  double x = 0.0, y = 0.0;
  bool cursor_known = false;

 private:
  using Event = std::variant<PointerEvent, KeyEvent>;
  /// Whether the batch is complete without, or with, this event.
  enum class Take { no, yes, yes_and_end };
  Take take(const PointerEvent& event, const InputBatch& batch) const;
  Take take(const KeyEvent& event, const InputBatch& batch, bool wait) const;

  std::deque<Event> events_;
  bool key_was_down_ = false;  ///< in the last batch: the panels must see that it is up again
};

}  // namespace maquette
