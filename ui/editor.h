#pragma once

#include <map>
#include <string>

#include "ui/editor_state.h"
#include "ui/layout.h"

namespace maquette {

/// Positions of panels and controls in this frame, for the mouse and for tests.
struct EditorFrame {
  Layout layout;
  std::map<std::string, Rect> windows;  ///< rectangles of the ImGui windows themselves
  std::map<std::string, Rect> items;    ///< some controls by name: `material/NAME`, `library/NAME`, `rotation`, ...
  bool editing = false;                 ///< a control is held: the change is still in progress
  bool typing = false;                  ///< a text field has the keyboard in the next frame
  bool awaits_field = false;            ///< one has been opened that does not have it yet
  int hovered_material = -1;            ///< row of the materials list under the mouse
};

/// Font and colours. `scale`: the display's content scale; `pixels_per_unit`: framebuffer pixels a window coordinate.
/// Call once after ImGui::CreateContext, and again (before a frame) when one of them changes.
void apply_theme(float scale, float pixels_per_unit = 1.0f);

/// Draws all panels of one frame between ImGui::NewFrame and ImGui::Render. Needs no OpenGL.
EditorFrame draw_editor(EditorState* state, const EditorFacts& facts, EditorActions* actions);

}  // namespace maquette
