#include "render/parts/baked_parts.h"

#include <algorithm>
#include <sstream>

#include "render/frame/plan.h"
#include "render/frame/request.h"
#include "render/parts/parts.h"

namespace maquette {

std::vector<bool> nodes_of_layer(const Scene& scene, const FrameRequest& request, const ShadingPlan& layer) {
  std::vector<std::string> modes{request.mode};
  for (const PartMode& part : request.part_modes)
    if (std::find(modes.begin(), modes.end(), part.mode) == modes.end()) modes.push_back(part.mode);
  const bool is_default = layer.nodes.empty();
  const auto own = std::find(modes.begin() + 1, modes.end(), layer.mode);
  const int index = is_default ? 0 : static_cast<int>(own - modes.begin());
  std::vector<bool> wanted;
  for (const int mode : layers_of_nodes(scene, request.part_modes, modes)) wanted.push_back(mode == index);
  return wanted;
}

std::vector<bool> named_nodes(const Scene& scene, const std::string& names) {
  std::vector<bool> named(scene.nodes.size(), names.empty());
  std::istringstream in(names);
  for (std::string name; std::getline(in, name, ';');) {
    name.erase(0, name.find_first_not_of(' '));
    name.erase(name.find_last_not_of(' ') + 1);
    if (!name.empty())
      for (const int node : find_nodes(scene, name)) named[static_cast<std::size_t>(node)] = true;
  }
  // Parents come before or after their children: nodes are visited from the roots.
  std::vector<int> open = scene.roots;
  while (!open.empty()) {
    const int node = open.back();
    open.pop_back();
    for (const int child : scene.nodes[static_cast<std::size_t>(node)].children) {
      if (named[static_cast<std::size_t>(node)]) named[static_cast<std::size_t>(child)] = true;
      open.push_back(child);
    }
  }
  return named;
}

int material_of_item(const Scene& scene, const DrawItem& item, int variant) {
  if (item.patch >= 0) return scene.patches[static_cast<std::size_t>(item.patch)].material;
  return material_of(
      scene.meshes[static_cast<std::size_t>(item.mesh)].primitives[static_cast<std::size_t>(item.primitive)], variant);
}

}  // namespace maquette
