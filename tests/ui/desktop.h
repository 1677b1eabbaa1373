#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "ui/layout.h"

namespace maquette::test {

/// 8-bit RGB of a whole screen, row 0 on top.
struct ScreenPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};
/// Mean absolute difference (0 to 255) of blocks of 8 x 8 pixels, which average out most of the noise.
double difference(const ScreenPicture& a, const ScreenPicture& b, const Rect& rect);
/// Standard deviation of the luma over a rectangle: 0 for an empty area.
double contrast(const ScreenPicture& picture, const Rect& rect);

/// A separate screen (Xvfb on a free display), the program running on it, and a mouse and keyboard (xdotool).
class Desktop {
 public:
  /// Empty when Xvfb, xdotool and ImageMagick are installed, else what is missing.
  static std::string missing_tools();
  /// Throws std::runtime_error when the screen does not come up.
  Desktop(int width, int height);
  ~Desktop();
  Desktop(const Desktop&) = delete;
  Desktop& operator=(const Desktop&) = delete;

  void start(const std::vector<std::string>& arguments);
  bool running();
  /// At once, without a chance to write anything.
  void kill_program();
  /// Waits for the program's end, at most for this time; its exit code, or -1.
  int wait_for_exit(double seconds);
  ScreenPicture grab() const;
  /// One xdotool call, as in {"mousemove", "10", "20", "click", "1"}.
  void input(const std::vector<std::string>& arguments) const;
  void move(float x, float y) const;
  void click(const Rect& rect) const;
  /// Polls until the screen meets the condition; false after `seconds`.
  bool wait_until(const std::function<bool(const ScreenPicture&)>& done, double seconds) const;
  /// As X11 names it, `:7`.
  std::string display() const;
  /// What another program would paste.
  std::string clipboard() const;
  /// What the program wrote to standard error.
  std::string errors() const;
  /// Where the program keeps journals of untitled reviews.
  std::string state_folder() const { return folder_ + "/state/maquette"; }
  /// The screen as a .png file.
  void save_screen(const std::string& file) const;

 private:
  int width_, height_;
  int screen_process_ = -1, program_ = -1;
  std::string display_, folder_;
};

}  // namespace maquette::test
