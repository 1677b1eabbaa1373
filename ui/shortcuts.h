#pragma once

#include <string>
#include <vector>

namespace maquette {

/// What a key asks of the window.
enum class Command {
  none,  ///< of the mouse: listed only
  camera,
  frame_scene,
  dent,
  measure_distance,
  undo,
  redo,
  darker,
  brighter,
  keep_look,
  previous_look,
  next_look,
  compare,
  compare_otherwise,
  swap,
  render_file,
  add_key,
  play,
  save,
  open,
  start_screen,
  sides,
  present,
  full_screen,
  screenshot,
  larger,
  smaller,
  usual_size,
  menu,
  next_part,
  panel,
  isolate,
  help,
  leave,
  close
};

/// One line of the list of keys. The keys are read from here by the window, the panel Help, and the manual.
struct Shortcut {
  Command command = Command::none;
  std::string keys;  ///< `Ctrl+Y`, `F11`, `Page Up`, `[`; several behind commas; `1 to 9`, `Ctrl+1 to Ctrl+9`
  std::string what;
};
struct ShortcutGroup {
  std::string title;
  std::vector<Shortcut> shortcuts;
};
const std::vector<ShortcutGroup>& shortcut_groups();

/// The command of one key as it is written above, with `Ctrl+` before it where that is held; none where there is none.
/// Digits are Command::camera, with `Ctrl+` Command::panel.
Command command_of(const std::string& key);

/// Tabs of the left side, then of the right side, in the order of the keys Ctrl+1 to Ctrl+9.
inline constexpr const char* kPanelNames[] = {"Materials", "Scene", "Help",  "Review", "Look",
                                              "Render",    "Frame", "Error", "Inspect"};
inline constexpr int kLeftPanels = 4;

}  // namespace maquette
