#pragma once

#include <optional>
#include <string>
#include <vector>

#include "review/camera_path.h"
#include "viewer/window_session.h"

namespace maquette {

/// Looks and camera paths in the window: records while the camera moves, plays, and carries out what the panel asks.
class WindowPaths {
 public:
  void carry_out(const EditorActions& actions, WindowSession* session, double now_s);
  /// In every iteration of the window's loop, before the session is updated.
  void update(WindowSession* session, double now_s);
  /// The camera is the path's: no change of the user's.
  bool playing() const { return playing_; }

 private:
  void show_time(WindowSession* session, double time_s);
  void play(WindowSession* session, double now_s);
  void record(WindowSession* session, double now_s);

  bool playing_ = false;
  double begin_s_ = 0.0;  ///< of playing or recording
  double last_frame_s_ = 0.0;
  std::optional<std::string> taken_;  ///< look of the path that was taken last
  std::vector<RecordedView> recorded_;
};

}  // namespace maquette
