#pragma once

#include <string>
#include <vector>

#include "render/scene_state/geometry.h"

namespace maquette {

/// The boxes of setting `octree.interest`: names of nodes (their surfaces including descendants) and boxes of six
/// numbers (m), separated by semicolons. Empty for an empty text. Throws UsageError for an unknown name, for numbers
/// that are not a box and for a node without surfaces.
std::vector<Bounds> find_interest(const std::string& text, const Scene& scene, const FlatGeometry& geometry);

}  // namespace maquette
