#pragma once

#include <string>
#include <vector>

#include "render/geometry.h"

namespace maquette {

/// The boxes that setting `octree.interest` means: names of nodes (their surfaces with all below them) and boxes of six
/// numbers (m), separated by semicolons. Empty for an empty text. Throws UsageError for an unknown name, for numbers
/// that make no box and for a node without surfaces.
std::vector<Bounds> find_interest(const std::string& text, const Scene& scene, const FlatGeometry& geometry);

}  // namespace maquette
