#include "render/octree/octree_interest.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>

#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

constexpr const char* kWhere = "octree.interest";

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string::npos ? std::string() : text.substr(begin, end - begin + 1);
}

/// Parses six numbers; nothing for any other text.
std::optional<std::vector<float>> read_numbers(const std::string& text) {
  std::vector<float> numbers;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) {
    part = trimmed(part);
    char* end = nullptr;
    const float value = std::strtof(part.c_str(), &end);
    if (part.empty() || *end != '\0') return std::nullopt;
    numbers.push_back(value);
  }
  return numbers;
}

bool is_below(const Scene& scene, int node, int ancestor) {
  if (node == ancestor) return true;
  const auto& children = scene.nodes[static_cast<std::size_t>(ancestor)].children;
  return std::any_of(children.begin(), children.end(), [&](int child) { return is_below(scene, node, child); });
}

Bounds bounds_of_nodes(const std::string& name, const Scene& scene, const FlatGeometry& geometry) {
  std::vector<std::string> known;
  std::vector<int> named;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (!scene.nodes[i].name.empty()) known.push_back(scene.nodes[i].name);
    if (scene.nodes[i].name == name) named.push_back(static_cast<int>(i));
  }
  if (named.empty())
    throw UsageError(kWhere, "'" + name + "' is neither a node of the scene nor six numbers",
                     did_you_mean(name, known));
  Bounds bounds;
  for (const DrawItem& item : geometry.items) {
    if (std::none_of(named.begin(), named.end(),
                     [&](int n) { return item.node >= 0 && is_below(scene, item.node, n); }))
      continue;
    for (std::uint32_t v = item.first_vertex; v < item.first_vertex + item.vertex_count; ++v) {
      bounds.min = glm::min(bounds.min, geometry.positions[v]);
      bounds.max = glm::max(bounds.max, geometry.positions[v]);
    }
  }
  if (bounds.empty())
    throw UsageError(kWhere, "node '" + name + "' has no surfaces", "name one that has, or give a box");
  return bounds;
}

}  // namespace

std::vector<Bounds> find_interest(const std::string& text, const Scene& scene, const FlatGeometry& geometry) {
  std::vector<Bounds> boxes;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ';');) {
    part = trimmed(part);
    if (part.empty()) continue;
    const auto numbers = read_numbers(part);
    if (!numbers) {
      boxes.push_back(bounds_of_nodes(part, scene, geometry));
      continue;
    }
    const auto& n = *numbers;
    const bool box = n.size() == 6 && std::all_of(n.begin(), n.end(), [](float v) { return std::isfinite(v); }) &&
                     n[0] <= n[3] && n[1] <= n[4] && n[2] <= n[5];
    if (!box)
      throw UsageError(kWhere, "'" + part + "' is no box", "give x0,y0,z0,x1,y1,z1 in metres, the lower corner first");
    boxes.push_back({{n[0], n[1], n[2]}, {n[3], n[4], n[5]}});
  }
  return boxes;
}

}  // namespace maquette
