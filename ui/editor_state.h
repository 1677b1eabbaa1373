#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "render/renderer.h"
#include "render/technique/settings.h"
#include "scenes/scene.h"
#include "ui/inspection_state.h"

/// What the window edits and shows, as plain values: panels read and change them, viewer/ applies them.
namespace maquette {

/// What undo restores.
struct Edits {
  std::string environment = "builtin:clear-sky";
  float env_rotation_deg = 0.0f;
  float env_scale = 1.0f;
  int variant = -1;
  std::map<std::string, std::string> materials;  ///< material name -> source; absent: as in the file
  /// Control points of the dented meshes' cages, by mesh.
  std::map<int, std::shared_ptr<const std::vector<glm::vec3>>> dents;
  std::set<int> hidden_nodes;
  std::set<std::string> reflectors;       ///< nodes that reflect; empty: those that the scene marks
  std::map<int, std::string> part_modes;  ///< index of a node -> shading mode of it and of what is below it
  bool operator==(const Edits&) const = default;
};

enum class Tool { camera, dent, reflect, region };

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
  std::string budget_answer;                  ///< the settings that keep the budget, or why none do
  bool can_apply = false;
  bool measuring_curve = false;
};

/// Everything the panels change.
struct EditorState {
  Edits edits;
  CameraView camera;
  std::string mode = builtin_registry().default_mode;
  std::string reflections = kAutoReflections;  ///< reflector technique
  Settings settings;
  int msaa = 1;        ///< samples a pixel
  int still_msaa = 4;  ///< once nothing moves, if more
  float exposure_ev = 0.0f;
  bool auto_exposure = true;  ///< computed again for each scene, environment and scene camera
  std::string tonemap = "pbr-neutral";
  std::string debug_view;     ///< empty: the picture
  float still_scale = 1.0f;   ///< picture pixels a framebuffer pixel, per axis, when nothing moves
  float moving_scale = 0.0f;  ///< the same while something moves; 0: chosen for a fluid picture
  ErrorView error_view;
  InspectionView inspection;
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
  int left_tab = -1;   ///< to be opened once: 0 materials, 1 scene, 2 help
  int right_tab = -1;  ///< to be opened once: 0 look, 1 render, 2 frame, 3 error, 4 inspection
  bool open_path_popup = false;
  std::array<char, 256> material_search{};
  std::array<char, 256> node_search{};
  std::array<char, 1024> path{};
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
  const FrameStats* stats = nullptr;  ///< of the last frame, nullptr before the first
  std::vector<std::string> cameras;   ///< bookmarks, in order of the keys 1 to 9
  std::vector<BackgroundWork> background;
  std::string loading;  ///< what is being read; empty: nothing
  std::string device;
  std::vector<std::string> environment_files;  ///< opened so far, besides the built-in ones
  std::vector<std::string> brdf_files;
  const std::vector<Message>* messages = nullptr;
  const std::map<std::string, unsigned>* swatches = nullptr;  ///< texture of each library BRDF's ball, where ready
  std::vector<float> frame_history_ms;                        ///< oldest first
  std::vector<PassTime> smooth_passes;
  std::set<int> reflecting;  ///< nodes that are reflectors, whether in view or not
  glm::ivec2 picture_px{0};
  float suggested_exposure_ev = 0.0f;
  MeterFacts meter;
  InspectionFacts inspection;
  bool can_undo = false;
  std::string command;     ///< of the shell, which renders this picture
  bool converged = false;  ///< the accumulation limit is reached
};

/// Actions that the panels request, each done once.
struct EditorActions {
  std::string open_path;  ///< scene, environment or BRDF, by its extension
  int go_to_camera = -1;
  bool frame_scene = false;
  bool meter_exposure = false;
  bool undo = false;
  bool dismiss_messages = false;
  bool measure_curve = false;  ///< of the present mode in the present view
  InspectionActions inspection;
  bool apply_budget = false;   ///< sets the mode's samples to those that keep the budget
};

}  // namespace maquette
