#pragma once

#include <string>
#include <vector>

#include "render/scene_state/geometry.h"

namespace maquette {

class SceneState;
struct FrameRequest;
struct ShadingPlan;

/// [node] whether the layer's mode shades it.
std::vector<bool> nodes_of_layer(const Scene& scene, const FrameRequest& request, const ShadingPlan& layer);

/// [node] whether its name, or one above it, is in `names`, separated by semicolons; empty: all. Throws UsageError for
/// a name that is not there.
std::vector<bool> named_nodes(const Scene& scene, const std::string& names);

/// Index of an item's material, -1 for glTF's default one.
int material_of_item(const Scene& scene, const DrawItem& item, int variant);

}  // namespace maquette
