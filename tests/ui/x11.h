#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// What xdotool cannot do on an X11 display (`:7`).
namespace maquette::test {

/// 8-bit RGB of the whole screen, row 0 on top.
struct ScreenPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};
/// Throws std::runtime_error without such a display.
ScreenPicture grab_screen(const std::string& display);

/// Drops files on the program's window at a pixel of the screen, as a file manager does (XDND 5). False where no window
/// is there, or it takes none.
bool drop_files(const std::string& display, int x, int y, const std::vector<std::string>& files);

/// What desktops set where the screen is dense: 192 for twice the scale. For programs that start later.
void set_dpi(const std::string& display, int dpi);

struct WindowSize {
  int width = 0, height = 0;
  bool operator==(const WindowSize&) const = default;
};
/// Of the program's window in pixels; 0 where there is none.
WindowSize window_size(const std::string& display);

}  // namespace maquette::test
