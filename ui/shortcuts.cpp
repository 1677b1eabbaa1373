#include "ui/shortcuts.h"

#include <algorithm>

namespace maquette {

const std::vector<ShortcutGroup>& shortcut_groups() {
  using C = Command;
  static const std::vector<ShortcutGroup> kGroups = {
      {"Camera",
       {{C::none, "Left drag", "orbit"},
        {C::none, "Middle drag", "pan (Shift+left too)"},
        {C::none, "Wheel", "dolly"},
        {C::none, "Right drag", "look around; W A S D Q E fly"},
        {C::camera, "1 to 9", "scene cameras"},
        {C::frame_scene, "F", "frame the scene"}}},
      {"Work",
       {{C::none, "Click", "choose surface, material"},
        {C::none, "Ctrl+drag", "rotate the light"},
        {C::dent, "D", "dent tool on, off"},
        {C::none, "Drag (dent)", "down deeper, up to pull"},
        {C::none, "Wheel (dent)", "radius, button held"},
        {C::measure_distance, "M", "distance of two clicks"},
        {C::isolate, "I", "the chosen part alone, or all"},
        {C::undo, "Ctrl+Z", "undo"},
        {C::redo, "Ctrl+Y, Ctrl+Shift+Z", "redo"},
        {C::darker, "[", "darker by a quarter stop"},
        {C::brighter, "]", "brighter"},
        {C::leave, "Escape", "leave tool or presentation"}}},
      {"Review",
       {{C::keep_look, "L", "keep this look"},
        {C::previous_look, "Page Up", "previous look"},
        {C::next_look, "Page Down", "next look"},
        {C::compare, "C", "compare with the one before"},
        {C::compare_otherwise, "B", "wiper, side by side, FLIP"},
        {C::swap, "X", "swap A and B"},
        {C::render_file, "P", "settled picture as .exr"},
        {C::add_key, "K", "camera to the path"},
        {C::play, "Space", "play, stop"},
        {C::save, "Ctrl+S", "save"}}},
      {"Files",
       {{C::open, "O", "open by path"},
        {C::start_screen, "Ctrl+O", "recent and built-in scenes"},
        {C::none, "Drop .glb .gltf", "another scene"},
        {C::none, "Drop .hdr .exr", "another environment"},
        {C::none, "Drop .binary .btf", "the material there"},
        {C::none, "Drop .json", "a review, or a camera path"}}},
      {"Window",
       {{C::menu, "F10", "menu of all commands"},
        {C::panel, "Ctrl+1 to Ctrl+9", "tabs, from Materials to Inspect"},
        {C::next_part, "F6", "keys go to the next side"},
        {C::none, "Tab, arrows", "the next control there"},
        {C::none, "Space, Enter", "press it; arrows move a slider"},
        {C::none, "Enter (number)", "type it"},
        {C::sides, "Tab", "sides away and back"},
        {C::present, "F5", "picture alone, full screen"},
        {C::full_screen, "F11", "full screen"},
        {C::screenshot, "F12", "the window as .png"},
        {C::larger, "Ctrl++, Ctrl+=", "larger text"},
        {C::smaller, "Ctrl+-", "smaller text"},
        {C::usual_size, "Ctrl+0", "usual size"},
        {C::help, "F1, H", "this list"},
        {C::close, "Ctrl+Q", "close"}}},
  };
  return kGroups;
}

Command command_of(const std::string& key) {
  const bool digit = !key.empty() && key.back() >= '1' && key.back() <= '9';
  if (digit && key.size() == 1) return Command::camera;
  if (digit && key.size() == 6 && key.starts_with("Ctrl+")) return Command::panel;
  for (const ShortcutGroup& group : shortcut_groups())
    for (const Shortcut& shortcut : group.shortcuts) {
      if (shortcut.command == Command::none || shortcut.command == Command::camera ||
          shortcut.command == Command::panel)
        continue;
      for (std::size_t begin = 0; begin < shortcut.keys.size();) {
        const std::size_t end = std::min(shortcut.keys.find(", ", begin), shortcut.keys.size());
        if (shortcut.keys.compare(begin, end - begin, key) == 0) return shortcut.command;
        begin = end + 2;
      }
    }
  return Command::none;
}

}  // namespace maquette
