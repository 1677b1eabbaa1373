#pragma once

#include <optional>
#include <string>
#include <vector>

namespace maquette {

/// What the window has done so far, for programs that drive it and wait for what they asked.
struct WindowState {
  long frames = 0;                ///< of the window, shown
  long pictures = 0;              ///< of the scene, drawn
  int averaged = 0;               ///< pictures in the one that is shown
  bool still = false;             ///< nothing moves, and the picture is the requested one
  int waiting = 0;                ///< events that came and were not handed out yet
  std::vector<std::string> work;  ///< in the background

  bool operator==(const WindowState&) const = default;
};

/// The file that the environment's `MAQUETTE_WINDOW_STATE` names; empty: none.
std::string window_state_file();
/// One line of JSON, written beside and renamed. Throws Error.
void write_window_state(const std::string& file, const WindowState& state);
/// Nothing where there is no such file, or another one.
std::optional<WindowState> read_window_state(const std::string& file);

}  // namespace maquette
