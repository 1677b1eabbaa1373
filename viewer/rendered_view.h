#pragma once

#include <string>

#include "scenes/scene.h"
#include "ui/editor_state.h"

namespace maquette {

/// The command of the shell that renders what a window shows. Dents and hidden nodes are not in it: commands have no
/// words for what was hidden, and for dents only those of presses.
std::string render_command(const Scene& scene, const EditorState& state);

}  // namespace maquette
