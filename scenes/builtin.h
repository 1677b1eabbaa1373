#pragma once

#include "scenes/scene.h"

/// The makers behind build_builtin_scene, one a scene. Internal to scenes/.
namespace maquette::builtin {

Scene build_sphere();
Scene build_plate();
Scene build_cornell();
Scene build_cockpit();
Scene build_seat();

}  // namespace maquette::builtin
