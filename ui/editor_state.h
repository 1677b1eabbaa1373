#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "render/renderer.h"
#include "render/technique/settings.h"
#include "review/camera_path.h"
#include "review/look.h"
#include "scenes/node_paths.h"
#include "scenes/scene.h"
#include "ui/file_browser.h"
#include "ui/inspection_state.h"
#include "ui/shortcuts.h"

/// What the window edits and shows, as plain values: panels read and change them, viewer/ applies them.
namespace maquette {

enum class Tool { camera, dent, reflect, region, stored, distance };

/// Settings of the error tab.
struct ErrorView {
  enum class Show { picture, heat, wiper };
  bool open = false;      ///< the tab is visible: only then is anything measured. Set by the panel in each frame
  bool all_light = true;  ///< against all light paths; else against unshadowed direct light
  Show show = Show::picture;
  float wiper = 0.5f;   ///< share of the picture's width, from the left, that shows the technique
  float budget = 0.1f;  ///< largest relative RMSE for the proposed settings
};

/// Results of the error meter.
struct MeterFacts {
  bool has_error = false;
  double error = 0.0, low = 0.0, high = 0.0;  ///< relative RMSE and its 95 % interval
  int pixels = 0, paths = 0;                  ///< compared; traced through each
  double seconds = 0.0;                       ///< from the camera's last move to this result
  std::string status;                         ///< one line: what it does, or why it cannot measure
  std::string curve;                          ///< where the curve of the mode comes from; empty: there is none
  std::string reference_answer;               ///< where the reference would be better after the same time
  std::string budget_answer;                  ///< the settings that keep the budget, or why none do
  bool can_apply = false;
  bool measuring_curve = false;
  struct Reflector {
    std::string name;
    double error = 0.0, time_ms = 0.0;  ///< of a frame
    std::string why;                    ///< it cannot draw this view; else empty
  };
  std::vector<Reflector> reflectors;  ///< techniques that were compared in this view
  bool comparing_reflectors = false;
};

/// The path that is being edited and played.
struct PathView {
  int path = 0, key = -1;   ///< chosen ones
  double time_s = 0.0;      ///< on the path
  bool goes_there = false;  ///< once: the picture is to show that time
  bool playing = false, recording = false;
  Playing playback = Playing::once;
  int late_frames = 0;  ///< of the last playback: those that a 25th of a second passed without
};

/// How another look is shown beside the one at hand.
struct CompareView {
  enum class How { wiper, side_by_side, difference };
  bool on = false;
  How how = How::wiper;
  std::string other;  ///< name of the other look; empty: the one that was shown before
};

/// How the picture is saved as a file, settled.
struct PictureFile {
  int width = 1920, height = 1080;
  int msaa = 16;     ///< samples a pixel
  int frames = 16;   ///< that are averaged; of a mode that traces whole pictures so many paths a pixel
  bool png = false;  ///< else EXR
};

/// Everything the panels change: the look at hand, and how the window shows it.
struct EditorState : Look {
  std::vector<Look> looks;        ///< kept ones of the review
  std::vector<CameraPath> paths;  ///< of the review
  PathView path_view;
  std::string continued_journal;  ///< once: of an untitled review that is to be opened
  int msaa = 1;                   ///< samples a pixel
  int still_msaa = 4;             ///< once nothing moves, if more
  std::string debug_view;         ///< empty: the picture
  float still_scale = 1.0f;       ///< picture pixels a framebuffer pixel, per axis, when nothing moves
  float moving_scale = 0.0f;      ///< the same while something moves; 0: chosen for a fluid picture
  ErrorView error_view;
  InspectionView inspection;
  CompareView compare;
  PictureFile picture_file;
  std::vector<glm::vec3> measured;  ///< ends of a distance, at most two points, m
  Tool tool = Tool::camera;
  float dent_depth_m = 0.02f;  ///< of a press without a drag; negative pulls out
  float dent_radius_m = 0.2f;
  float fly_speed = 0.25f;  ///< scene radii a second

  int selected_node = -1;
  int selected_material = -1;
  int reveal_node = -1;  ///< the tree opens and scrolls there once
  bool reveal_material = false;
  bool left_open = true;
  bool right_open = true;
  int left_tab = -1;             ///< to be opened once: 0 materials, 1 scene, 2 help, 3 review
  int right_tab = -1;            ///< to be opened once: 0 look, 1 render, 2 frame, 3 error, 4 inspection
  bool right_first = false;      ///< the right side was opened last: the left one gives way where both have no room
  int keyboard_step = 0;         ///< once: to the next control (1) or the one before (-1)
  bool keyboard_types = false;   ///< Enter begins to type in the control that has the keyboard. Set in each frame
  std::string keyboard_goes_to;  ///< once: a part of the window (`toolbar`, `left`, `right`, `picture`)
  bool open_path_popup = false, save_path_popup = false, start_popup = false, menu_popup = false;
  bool presenting = false;  ///< the picture alone
  float text_scale = 1.0f;  ///< of all panels, beside that of the display
  std::string frame_pass;   ///< whose times the tab Frame plots; empty: the whole frame's
  std::array<char, 256> material_search{};
  std::array<char, 256> node_search{};
  std::array<char, 1024> path{};
  FileBrowser browser;
};

enum class MessageLevel { note, warning, error };
struct EditorState;
struct Message {
  MessageLevel level = MessageLevel::note;
  std::string text;
  bool unread = true;       ///< shown in the strip below the picture until dismissed
  std::string topic = {};   ///< of advice, which goes when it is stale; else empty
  std::string remedy = {};  ///< label of the button that does what is advised; empty: none
  std::function<void(EditorState*)> carry_out = {};
};

/// Read-only results from the renderer and the session.
struct EditorFacts {
  const Registry* registry = &builtin_registry();
  const Scene* scene = nullptr;
  const std::vector<std::string>* node_paths = nullptr;  ///< of the scene's nodes (scenes/node_paths.h)
  const FrameStats* stats = nullptr;                     ///< of the last frame, nullptr before the first
  std::vector<std::string> cameras;                      ///< bookmarks, in order of the keys 1 to 9
  std::vector<BackgroundWork> background;
  std::map<std::string, double> seconds_left;  ///< of `background`, once it can be told
  std::string picture_in_work;                 ///< file that is being drawn; empty: none
  std::string loading;                         ///< what is being read; empty: nothing
  std::string device;
  std::vector<std::string> environment_files;  ///< opened so far, besides the built-in ones
  std::vector<std::string> brdf_files;
  std::vector<std::string> recent_files;          ///< scenes and reviews, latest first
  std::map<std::string, unsigned> look_pictures;  ///< texture of each kept look, where ready
  Bounds bounds;                                  ///< of the scene, m
  const std::vector<Message>* messages = nullptr;
  const std::map<std::string, unsigned>* swatches = nullptr;  ///< texture of each library BRDF's ball, where ready
  std::vector<float> frame_history_ms;                        ///< oldest first
  std::vector<PassTime> smooth_passes;
  std::map<std::string, std::vector<float>> pass_history_ms;  ///< of each pass, as long as `frame_history_ms`
  std::optional<glm::vec2> sun_deg;  ///< elevation, azimuth from +Z towards +X; nothing where the light has no sun
  std::set<int> reflecting;          ///< nodes that are reflectors, whether in view or not
  glm::ivec2 picture_px{0};
  float suggested_exposure_ev = 0.0f;
  MeterFacts meter;
  InspectionFacts inspection;
  StoredLightFacts stored_light;
  bool can_undo = false, can_redo = false;
  std::string review_file;  ///< empty: untitled
  bool review_changed = false, review_read_only = false;
  std::string command;     ///< of the shell, which renders this picture
  bool converged = false;  ///< the accumulation limit is reached

  /// Path of a node of the scene.
  std::string path_of(int node) const {
    return (node_paths ? *node_paths : maquette::node_paths(*scene))[static_cast<std::size_t>(node)];
  }
};

/// Actions that the panels request, each done once.
struct EditorActions {
  std::vector<Command> commands;  ///< as if their keys had been pressed
  bool save = false;              ///< the review; asks for a name where it has none
  std::string save_path;          ///< the review, under this name
  bool keep_look = false;
  int go_to_look = -1;
  int next_look = 0;  ///< 1 or -1
  bool new_path = false, turntable = false, add_key = false, record_path = false, play_path = false;
  bool export_path = false;
  bool save_picture = false;  ///< as `EditorState::picture_file` says
  bool cancel_picture = false;
  std::string drop_source;  ///< of a material, let go over what is under the mouse
  int add_animation = -1;   ///< index of one of the scene: a path that it plays along
  int step_path = 0;        ///< frames
  std::string open_path;    ///< scene, environment or BRDF, by its extension
  int go_to_camera = -1;
  bool frame_scene = false;
  bool meter_exposure = false;
  bool undo = false, redo = false;
  int dismiss_message = -1;       ///< index of the one that was read
  bool dismiss_messages = false;  ///< all of them
  bool compare_reflectors = false;
  bool measure_curve = false;  ///< of the present mode in the present view
  InspectionActions inspection;
  bool apply_budget = false;  ///< sets the mode's samples to those that keep the budget
};

}  // namespace maquette
