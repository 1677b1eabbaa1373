#pragma once

#include <string>

#include "review/review.h"
#include "viewer/look_stage.h"

namespace maquette {

/// `maquette render` of a look, as a program of its own: the window stays at work, and the picture is the one that the
/// command makes, bit for bit.
class BackgroundRender {
 public:
  BackgroundRender() = default;
  ~BackgroundRender() { cancel(); }
  BackgroundRender(const BackgroundRender&) = delete;
  BackgroundRender& operator=(const BackgroundRender&) = delete;

  /// Draws the look at hand of the review into an .exr or .png file; ends the one before. `command`: what an .exr says
  /// that repeats it; empty: nothing. Throws Error.
  void start(const Review& review, const SettledFrame& settled, const std::string& output,
             const std::string& command = {});
  void cancel();
  bool busy() const { return process_ > 0; }
  /// True once, when it has ended; `error` is then empty, or what it said.
  bool poll(std::string* error);
  /// Share that is done, as the program has told.
  double progress() const;
  const std::string& output() const { return output_; }

 private:
  void clean_up();

  int process_ = -1;
  std::string review_file_, log_, output_;
};

}  // namespace maquette
