#pragma once

#include <string>

namespace maquette {

/// One ffmpeg process that makes a video of PNG files as they come. The video gets its name when it is whole.
class VideoPipe {
 public:
  /// Whether the name is one of a video: .mp4, .mkv or .mov.
  static bool is_video(const std::string& path);
  /// Throws Error when ffmpeg is not installed: says what to install.
  static void require_ffmpeg();

  VideoPipe(std::string path, double frames_per_second);
  /// Ends the process, without a video unless `finish` was called.
  ~VideoPipe();
  VideoPipe(const VideoPipe&) = delete;
  VideoPipe& operator=(const VideoPipe&) = delete;

  /// The next frame, a PNG file. Throws Error with the last line of what ffmpeg says.
  void add(const std::string& png_file);
  /// Throws Error, and leaves a video of that name as it was, where not all frames can be read again.
  void finish();

 private:
  [[noreturn]] void fail();
  int wait();

  std::string path_, beside_, log_;
  int input_ = -1;
  int process_ = -1;
  int frames_ = 0;
};

}  // namespace maquette
