#pragma once

#include "ui/editor_state.h"
#include "ui/layout.h"

namespace maquette {

/// The distance between two clicked points, over the picture: between ImGui::NewFrame and Render.
void draw_distance(const EditorState& state, const Bounds& bounds, const Rect& picture);
/// A line in the corner of the picture.
void draw_note(const char* text, const Rect& picture);

}  // namespace maquette
