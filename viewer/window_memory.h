#pragma once

#include <string>
#include <vector>

namespace maquette {

/// What windows remember from one run to the next, in `window.json` of the state folder: never anything of a picture.
struct WindowMemory {
  static constexpr std::size_t kMostRecent = 12;

  std::vector<std::string> recent;  ///< scenes and reviews, absolute, latest first
  bool left_open = true, right_open = true;
  float text_scale = 1.0f;
  int width = 0, height = 0;  ///< of the window; 0: none yet
  bool operator==(const WindowMemory&) const = default;

  /// To the front; built-in scenes are not noted.
  void note(const std::string& source);
};

/// What is damaged or not there is as if new.
WindowMemory load_window_memory();
/// Failures are ignored: it is a convenience.
void save_window_memory(const WindowMemory& memory);

}  // namespace maquette
