#pragma once

#include <array>

#include "render/frame/camera.h"

namespace maquette {

/// The view at `t` (0 to 1) of the move from views[1] to views[2]; views[0] and views[3] may be null at a path's ends.
CameraView between_views(const std::array<const CameraView*, 4>& views, double t);

/// Angle between the orientations of two views, rad.
double angle_between(const CameraView& a, const CameraView& b);

}  // namespace maquette
