#include "ui/widgets.h"

namespace maquette::panels {

namespace {

struct Shortcut {
  const char* keys;
  const char* what;
};
struct Group {
  const char* title;
  std::vector<Shortcut> shortcuts;
};

const std::vector<Group>& groups() {
  static const std::vector<Group> kGroups = {
      {"Camera",
       {{"Left drag", "orbit"},
        {"Middle drag", "pan (Shift+left too)"},
        {"Wheel", "dolly"},
        {"Right drag", "look around"},
        {"W A S D Q E", "fly, right button held"},
        {"1 to 9", "scene cameras"},
        {"F", "frame the scene"}}},
      {"Work",
       {{"Click", "choose surface, material"},
        {"Ctrl+drag", "rotate the light"},
        {"D", "dent tool on, off"},
        {"Drag (dent)", "down deeper, up to pull"},
        {"Wheel (dent)", "radius, button held"},
        {"Ctrl+Z, Ctrl+Y", "undo, redo"},
        {"[  ]", "exposure down, up"}}},
      {"Review",
       {{"L", "keep this look"},
        {"Page Up, Down", "previous, next look"},
        {"C", "compare with the one before"},
        {"X", "swap A and B"},
        {"P", "settled picture as .exr"},
        {"K", "camera to the path"},
        {"Space", "play, stop"},
        {"Ctrl+S", "save"}}},
      {"Files",
       {{"O", "open by path"},
        {"Drop .glb .gltf", "another scene"},
        {"Drop .hdr .exr", "another environment"},
        {"Drop .binary", "the material there"}}},
      {"Window", {{"Tab", "sides away and back"}, {"F1", "this list"}, {"Ctrl+Q", "close"}}},
  };
  return kGroups;
}

}  // namespace

void draw_help_panel(Ui&) {
  for (const Group& group : groups()) {
    if (!section(group.title)) continue;
    for (const Shortcut& shortcut : group.shortcuts) {
      ImGui::TextUnformatted(shortcut.keys);
      ImGui::SameLine(scaled(116.0f));
      ImGui::TextColored(kDim, "%s", shortcut.what);
    }
    ImGui::Spacing();
  }
}

}  // namespace maquette::panels
