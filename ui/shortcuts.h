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
  help,
  leave,
  close
};

/// One line of the list of keys. The keys are read from here by the window, the panel Help, and the manual.
struct Shortcut {
  Command command = Command::none;
  std::string keys;  ///< `Ctrl+Y`, `F11`, `Page Up`, `[`; several behind commas; `1 to 9`
  std::string what;
};
struct ShortcutGroup {
  std::string title;
  std::vector<Shortcut> shortcuts;
};
const std::vector<ShortcutGroup>& shortcut_groups();

/// The command of one key as it is written above, with `Ctrl+` before it where that is held; none where there is none.
/// Digits are Command::camera.
Command command_of(const std::string& key);

}  // namespace maquette
