#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/gl/objects.h"
#include "render/renderer.h"
#include "ui/layout.h"
#include "viewer/moving_scale.h"
#include "viewer/still_edges.h"
#include "viewer/window_session.h"

namespace maquette {

/// One turn of the window's loop, for the picture.
struct PictureTurn {
  int width_px = 1, height_px = 1;  ///< in framebuffer pixels
  bool panels_busy = false;         ///< the mouse moves: averaging may wait
  bool more_events = false;         ///< of the mouse are waiting: everything may wait
  double now_s = 0.0;
};

/// The scene's part of the window: draws a frame when one is due, keeps the tone mapped picture, copies it to the
/// window. Coarser while something moves; averages while nothing does, with smooth edges in the end.
class WindowPicture {
 public:
  static constexpr int kMostAveraged = 1024;

  /// Draws if needed. Returns whether a frame was drawn.
  bool update(WindowSession* session, const PictureTurn& turn);
  /// Copies the picture into framebuffer 0 at x, y (from the bottom left).
  void blit(int x, int y) const;
  /// `x`, `y`: 0 to 1 over the picture, y down.
  Renderer::Pick pick(WindowSession* session, float x, float y) const;

  const std::optional<FrameStats>& stats() const { return stats_; }
  /// The request of the last frame.
  const FrameRequest& drawn() const { return drawn_; }
  /// Nothing moves, and the picture is what was asked for.
  bool still() const { return stats_ && !moving_ && !failed_; }
  const std::vector<float>& history_ms() const { return history_ms_; }
  const std::vector<PassTime>& smooth_passes() const { return smooth_passes_; }
  glm::ivec2 drawn_size() const { return {drawn_.width, drawn_.height}; }
  bool converged() const { return stats_ && !moving_ && stats_->accumulated_frames >= kMostAveraged; }
  /// Nothing to do until the user acts.
  bool resting(double now_s) const { return converged() && now_s - last_change_s_ > 1.0; }

 private:
  float choose_moving_scale(const WindowSession& session, const PictureTurn& turn, MovingScale::Kind kind);
  void draw(WindowSession* session, const FrameRequest& request, bool accumulate);
  void go_back(WindowSession* session);
  void present(WindowSession* session, int width_px, int height_px);
  void note_times();
  void note_cost(bool move);

  std::optional<FrameStats> stats_;
  std::vector<float> history_ms_;
  std::vector<PassTime> smooth_passes_;
  FrameRequest drawn_;        ///< of the last frame
  FrameRequest last_wanted_;  ///< at full size and the samples a pixel of a move, to see whether anything moved
  std::optional<FrameRequest> sound_;  ///< the last that nothing refused, with the state's samples a pixel
  std::uint64_t last_revision_ = 0, last_paint_revision_ = 0;
  double last_change_s_ = -1e9;
  bool moving_ = false;
  float last_moving_scale_ = 1.0f;
  MovingScale moving_scale_;
  MovingScale::Kind moving_kind_ = MovingScale::Kind::other;
  StillEdges still_edges_;
  bool failed_ = false;  ///< the present request cannot be drawn; the last good picture stays
  bool background_ = false;
  float shown_exposure_ev_ = 0.0f;
  std::string shown_tonemap_, shown_view_;
  Texture picture_;
  GlName<FramebufferTraits> framebuffer_;
};

}  // namespace maquette
