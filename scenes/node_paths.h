#pragma once

#include <set>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// [node] A name of each node that a file can keep: names from a root on, each behind a '/', each '#' in them doubled,
/// and `#2`, `#3`, ... at the end where earlier nodes have the same path. No two are equal.
std::vector<std::string> node_paths(const Scene& scene);

/// Nodes that `call` means: those whose name it is, or the one whose path it is. Empty where there is none.
std::vector<int> called_nodes(const Scene& scene, const std::vector<std::string>& paths, const std::string& call);

/// Those of all `calls`; calls without a node add nothing.
std::set<int> called_nodes(const Scene& scene, const std::set<std::string>& calls);

/// Index of a variant by its name; -1 for none, and where the scene has no such variant.
int variant_index(const Scene& scene, const std::string& name);

}  // namespace maquette
