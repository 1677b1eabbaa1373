#pragma once

#include "scenes/scene.h"

/// Builders of the built-in scenes, one each. Internal to scenes/.
namespace maquette::builtin {

Scene build_sphere();
Scene build_plate();
Scene build_cornell();
Scene build_cockpit();
Scene build_seat();
Scene build_open_seat();

}  // namespace maquette::builtin
