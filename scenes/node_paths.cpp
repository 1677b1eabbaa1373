#include "scenes/node_paths.h"

#include <algorithm>
#include <map>

namespace maquette {

namespace {

std::string escaped(const std::string& name) {
  std::string text;
  for (const char c : name) text += c == '#' ? std::string("##") : std::string(1, c);
  return text;
}

}  // namespace

std::vector<std::string> node_paths(const Scene& scene) {
  const std::size_t count = scene.nodes.size();
  std::vector<std::string> paths(count);
  std::map<std::string, int> seen;
  for (std::size_t i = 0; i < count; ++i) {
    std::string path = "/" + escaped(scene.nodes[i].name);
    int above = scene.nodes[i].parent;
    for (std::size_t steps = 0; above >= 0 && steps < count; ++steps) {
      const Node& node = scene.nodes[static_cast<std::size_t>(above)];
      path.insert(0, "/" + escaped(node.name));
      above = node.parent;
    }
    const int ordinal = ++seen[path];
    // A number of '#' that is odd: an escaped name has an even one there.
    paths[i] = ordinal > 1 ? path + "#" + std::to_string(ordinal) : path;
  }
  return paths;
}

std::vector<int> called_nodes(const Scene& scene, const std::vector<std::string>& paths, const std::string& call) {
  std::vector<int> found;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    if (call.starts_with('/') && paths[i] == call) return {static_cast<int>(i)};
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    if (scene.nodes[i].name == call) found.push_back(static_cast<int>(i));
  return found;
}

std::set<int> called_nodes(const Scene& scene, const std::set<std::string>& calls) {
  std::set<int> all;
  if (calls.empty()) return all;
  const bool any_path = calls.lower_bound("/") != calls.lower_bound("0");  // '0' follows '/'
  const std::vector<std::string> paths = any_path ? node_paths(scene) : std::vector<std::string>(scene.nodes.size());
  for (const std::string& call : calls)
    for (const int node : called_nodes(scene, paths, call)) all.insert(node);
  return all;
}

int variant_index(const Scene& scene, const std::string& name) {
  const auto found = std::find(scene.variants.begin(), scene.variants.end(), name);
  return name.empty() || found == scene.variants.end() ? -1 : static_cast<int>(found - scene.variants.begin());
}

}  // namespace maquette
