#pragma once

#include <map>
#include <set>
#include <string>

#include "ui/editor_state.h"
#include "ui/layout.h"

namespace maquette {

/// A control that the keyboard can be at.
struct KeyboardStop {
  unsigned item = 0, window = 0;  ///< ImGui's numbers
  std::string part;               ///< `toolbar`, `left`, `right`, or the name of what has popped up
  Rect rect;
  bool typed = false;  ///< Enter types its value; elsewhere it presses
};

/// Positions of panels and controls in this frame, for the mouse and for tests.
struct EditorFrame {
  Layout layout;
  std::map<std::string, Rect> windows;    ///< rectangles of the ImGui windows themselves
  std::map<std::string, Rect> items;      ///< some controls by name: `material/NAME`, `library/NAME`, `rotation`, ...
  bool editing = false;                   ///< a control is held: the change is still in progress
  bool typing = false;                    ///< a text field has the keyboard in the next frame
  bool awaits_field = false;              ///< one has been opened that does not have it yet
  std::vector<KeyboardStop> stops;        ///< in the order in which the keyboard comes to them
  int hovered_material = -1;              ///< row of the materials list under the mouse
  bool navigating = false;                ///< a control has the keyboard, and a frame around it
  std::string keyboard_part = "picture";  ///< that has the keyboard: `toolbar`, `left`, `right`
};

/// Opens a tab, by its number in kPanelNames, and gives it the keyboard.
void open_panel(EditorState* state, int panel);

/// Gives a material another source; its own one is no change.
void assign_source(EditorState* state, const Material& material, const std::string& source);

/// Hides all that is drawn but a node, what is below it, and the lights.
void isolate(EditorState* state, const EditorFacts& facts, int kept);

/// Font and colours. `scale`: the display's content scale; `pixels_per_unit`: framebuffer pixels a window coordinate.
/// `further`: characters beyond Latin, Greek, Cyrillic and Vietnamese that the font is to have (Glyphs); those that no
/// font here has come back. Call once after ImGui::CreateContext, and again (before a frame) when one of them changes.
std::set<char16_t> apply_theme(float scale, float pixels_per_unit = 1.0f, const std::set<char16_t>& further = {});

/// Draws all panels of one frame between ImGui::NewFrame and ImGui::Render. Needs no OpenGL.
EditorFrame draw_editor(EditorState* state, const EditorFacts& facts, EditorActions* actions);

}  // namespace maquette
