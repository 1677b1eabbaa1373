#pragma once

#include <memory>

#include "scenes/scene.h"

/// Small scenes that no file holds.
namespace maquette::pictures {

enum class MirrorShape { flat_patch, curved_patch, curved_mesh };
/// Two boxes on a floor of two colours, before a mirror 2 m wide and 1.2 m high at z = -1; materials `grey`, `red`,
/// `blue`, `mirror`, nodes `floor`, `box`, `mirror`.
std::shared_ptr<const Scene> mirror_room(MirrorShape shape);
/// The same, seen through a curved pane before the eye that reflects too.
std::shared_ptr<const Scene> pane_room();

/// An open box whose floor, back and sides are of three materials of these names, with a ball of material `ball`.
std::shared_ptr<const Scene> painted_box();
/// The box with a checked texture on its back, a masked one on its floor, a blended pane and a punctual lamp.
std::shared_ptr<const Scene> textured_box();

}  // namespace maquette::pictures
