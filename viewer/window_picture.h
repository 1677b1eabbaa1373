#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "render/gl/objects.h"
#include "render/renderer.h"
#include "ui/layout.h"
#include "viewer/moving_scale.h"
#include "viewer/still_edges.h"
#include "viewer/window_session.h"

namespace maquette {

/// What the picture needs to know in one iteration of the window's loop.
struct PictureUpdate {
  int width_px = 1, height_px = 1;  ///< in framebuffer pixels
  bool panels_busy = false;         ///< the mouse moves, or another picture is drawn: averaging may wait
  bool playing = false;             ///< a path plays: nothing rests, not even where the camera does
  bool more_events = false;         ///< more mouse events are waiting: drawing may wait
  double now_s = 0.0;
};

/// The picture of the scene in the window: draws a frame when one is due, stores the tone mapped picture, copies it to
/// the window. Frames are coarser while something moves, and are averaged while nothing does, finally with smooth
/// edges.
class WindowPicture {
 public:
  static constexpr int kMostAveraged = 1024;

  /// The first picture of another look is coarse where the frame before took longer.
  void set_slow_look_ms(double ms) { slow_look_ms_ = ms; }
  /// Draws if needed. Returns whether a frame was drawn.
  bool update(WindowSession* session, const PictureUpdate& input);
  /// Copies the picture into framebuffer 0 at x, y (from the bottom left).
  void blit(int x, int y) const;
  /// `x`, `y`: 0 to 1 over the picture, y down.
  Renderer::Pick pick(WindowSession* session, float x, float y) const;

  const std::optional<FrameStats>& stats() const { return stats_; }
  /// As it is on screen, tone mapped, row 0 below; empty before the first frame.
  const Texture& shown() const { return picture_; }
  /// The request of the last frame.
  const FrameRequest& drawn() const { return drawn_; }
  /// Nothing moves, and the picture is the requested one.
  bool still() const { return stats_ && !moving_ && !failed_; }
  const std::vector<float>& history_ms() const { return history_ms_; }
  /// Of each pass by its title, 0 where a frame skipped it.
  const std::map<std::string, std::vector<float>>& pass_history_ms() const { return pass_history_ms_; }
  const std::vector<PassTime>& smooth_passes() const { return smooth_passes_; }
  glm::ivec2 drawn_size() const { return {drawn_.width, drawn_.height}; }
  bool converged() const { return stats_ && !moving_ && stats_->accumulated_frames >= kMostAveraged; }
  /// Nothing to do until the user acts.
  bool resting(double now_s) const { return converged() && now_s - last_change_s_ > 1.0; }

 private:
  /// The choices of a user with which a scene may be refused.
  struct Choices {
    std::string mode, reflections;
    Settings settings;
    int msaa = 1;
    std::set<std::string> reflectors;
    std::map<std::string, std::string> part_modes;
  };
  static Choices choices_of(const EditorState& state);
  float next_moving_scale(const WindowSession& session, const PictureUpdate& input, MovingScale::Kind kind);
  void draw(WindowSession* session, const FrameRequest& request, bool accumulate);
  void restore_valid_state(WindowSession* session);
  void present(WindowSession* session, int width_px, int height_px);
  void note_times();
  void note_cost(bool move);

  std::optional<FrameStats> stats_;
  std::vector<float> history_ms_;
  std::map<std::string, std::vector<float>> pass_history_ms_;
  std::vector<PassTime> smooth_passes_;
  FrameRequest drawn_;        ///< of the last frame
  FrameRequest last_wanted_;  ///< at full size and with the samples of a moving frame; shows whether anything moved
  std::optional<Choices> last_valid_;  ///< the last that nothing refused
  std::uint64_t last_revision_ = 0, last_material_revision_ = 0, looks_taken_ = 0;
  double last_change_s_ = -1e9, slow_look_ms_ = 100.0;
  double drawn_s_ = -1e9;  ///< when the newest frame was begun
  bool moving_ = false;
  float last_moving_scale_ = 1.0f;
  MovingScale moving_scale_;
  MovingScale::Kind moving_kind_ = MovingScale::Kind::other;
  StillEdges still_edges_;
  bool failed_ = false;  ///< the present request cannot be drawn; the last valid picture stays
  bool background_ = false;
  float shown_exposure_ev_ = 0.0f;
  std::string shown_tonemap_, shown_view_;
  Texture picture_;
  GlName<FramebufferTraits> framebuffer_;
};

}  // namespace maquette
