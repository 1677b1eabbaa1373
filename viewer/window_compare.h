#pragma once

#include <future>
#include <optional>
#include <string>

#include "render/gl/objects.h"
#include "scenes/image.h"
#include "ui/layout.h"
#include "viewer/background_render.h"
#include "viewer/window_input.h"
#include "viewer/window_picture.h"
#include "viewer/window_session.h"

namespace maquette {

/// Settled pictures beside the window's own: another look, as B under a wiper, beside A, or as the difference that a
/// person sees; and a picture of the look at hand as a file. What is compared how is in the state (CompareView).
class WindowCompare {
 public:
  /// Compares with the look that was shown before, or no longer.
  void toggle(WindowSession* session);
  /// Shows the other look instead, by the same camera.
  void swap(WindowSession* session);
  /// Draws the look at hand, as large as the window shows it, into an .exr beside the review.
  void render_file(WindowSession* session, const WindowPicture& picture);
  /// The same in the size and the format that the panel names.
  void save_picture(WindowSession* session);
  void cancel_picture(WindowSession* session);
  /// The file that is being drawn, and how far it is.
  std::optional<BackgroundWork> picture_in_work() const;
  /// A picture is in work: the window's own may wait.
  bool drawing() const { return drawing_.busy() || file_.busy(); }
  /// Whether the event moves the wiper, and is nobody else's.
  bool takes(const PointerEvent& event, const EditorState& state, const Rect& picture);
  /// Draws the other look in the background once nothing moves.
  void update(WindowSession* session, const WindowPicture& picture);
  /// Over the picture, behind the panels: between ImGui::NewFrame and Render.
  void draw_overlay(const EditorState& state, const WindowPicture& picture, const Rect& rect) const;

 private:
  struct Wanted {
    Look look;  ///< with the camera at hand
    int width = 0, height = 0;
    bool operator==(const Wanted&) const = default;
  };
  void start_file(WindowSession* session, const SettledFrame& settled, const std::string& ending);
  void note_looks(const EditorState& state);
  const Look* find_other(EditorState* state);
  void stop(EditorState* state);
  void draw_other(WindowSession* session, const WindowPicture& picture, const Look& other);
  void show(float exposure_ev);
  void take_difference(WindowSession* session, const WindowPicture& picture);

  bool dragging_ = false, ready_ = false;
  std::string present_, other_;  ///< names of the looks that were shown last
  float wiper_ = 0.5f;           ///< share of the picture's width, from the left, that shows the present look
  BackgroundRender drawing_, file_;
  std::string again_;  ///< how the file that is being drawn is made again
  std::optional<Wanted> wanted_;
  int wanted_msaa_ = 1;       ///< samples a pixel that it is drawn with
  Image radiance_, display_;  ///< of the other look
  Texture texture_, difference_;
  float shown_ev_ = 0.0f;
  struct Difference {
    Image picture;  ///< in false colours
    double mean = 0.0;
  };
  std::future<Difference> comparing_;
  int compared_frames_ = 0;  ///< of the picture that was compared last
  double mean_flip_ = -1.0;  ///< negative: not known yet
};

}  // namespace maquette
