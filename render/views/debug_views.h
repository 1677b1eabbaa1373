#pragma once

#include <string>
#include <vector>

#include "render/gbuffer/surfaces.h"
#include "render/shading/shading_mode.h"
#include "render/technique/registry.h"
#include "scenes/image.h"

namespace maquette {

/// The views that every frame with a G-buffer has, then those that techniques add.
std::vector<DebugViewInfo> debug_views(const Registry& registry);

/// One of the views that every frame has: values at the points of `surfaces`. Nothing when it is none of these.
std::optional<PointValue> view_of_surfaces(const std::string& name, const Surfaces& surfaces);

/// The values of a view at the points of each layer that has it, `sky` where none of these layers has a surface; alpha
/// 0 elsewhere.
struct LayerView {
  const Surfaces& surfaces;
  PointValue value;
  PointValue sky = {};
};
Image image_of_views(const GridSize& size, const std::vector<LayerView>& layers);

/// Display-encoded picture of a view's values.
Image picture_of_view(const Image& values, ViewColors colors);

}  // namespace maquette
