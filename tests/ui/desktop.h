#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/ui/x11.h"
#include "ui/layout.h"
#include "viewer/window_state.h"

namespace maquette::test {

/// Mean absolute difference (0 to 255) of blocks of 8 x 8 pixels, which average out most of the noise.
double difference(const ScreenPicture& a, const ScreenPicture& b, const Rect& rect);
/// Standard deviation of the luma over a rectangle: 0 for an empty area.
double contrast(const ScreenPicture& picture, const Rect& rect);

/// A separate screen (Xvfb on a free display), the program running on it, and a mouse and keyboard (xdotool).
class Desktop {
 public:
  /// No step takes so long: waiting ends then.
  static constexpr double kLimit_s = 600.0;

  /// Empty when Xvfb and xdotool are installed, else what is missing.
  static std::string missing_tools();
  /// Throws std::runtime_error when the screen does not come up.
  Desktop(int width, int height);
  ~Desktop();
  Desktop(const Desktop&) = delete;
  Desktop& operator=(const Desktop&) = delete;

  /// Returns once the program has shown a frame, or has ended.
  void start(const std::vector<std::string>& arguments);
  bool running();
  /// At once, without a chance to write anything.
  void kill_program();
  /// The program's exit code; -1: it was killed, or does not end.
  int wait_for_exit();
  ScreenPicture grab() const { return grab_screen(display()); }
  /// One xdotool call, as in {"mousemove", "10", "20", "click", "1"}; returns once the window has handed out all of its
  /// events and has shown what came of them.
  void input(const std::vector<std::string>& arguments);
  /// The same, without waiting for anything.
  void post(const std::vector<std::string>& arguments) const;
  void move(float x, float y);
  void click(const Rect& rect);
  /// Returns once the window has shown a few more frames; false where the program has ended.
  bool wait_for_frames();
  /// Looks at what the window has done, after each of its frames; false where the program has ended, or hangs.
  bool wait_for_state(const std::function<bool(const WindowState&)>& done);
  /// The same with what the screen shows.
  bool wait_until(const std::function<bool(const ScreenPicture&)>& done);
  /// What the window has done so far.
  WindowState state() const;
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
  std::string state_file() const { return folder_ + "/window.json"; }
  int width_, height_;
  int screen_process_ = -1, program_ = -1, exit_code_ = -1;
  std::string display_, folder_;
};

}  // namespace maquette::test
