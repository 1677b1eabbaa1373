#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "scenes/error.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

glm::dmat4 local_transform(Document* document, std::size_t index) {
  const tinygltf::Node& node = document->model.nodes[index];
  if (node.matrix.size() == 16) return glm::make_mat4(node.matrix.data());
  glm::dmat4 local(1.0);
  if (node.translation.size() == 3) local[3] = glm::dvec4(glm::make_vec3(node.translation.data()), 1.0);
  if (node.rotation.size() == 4) {
    const std::vector<double>& r = node.rotation;
    const glm::dquat rotation(r[3], r[0], r[1], r[2]);
    if (glm::length(rotation) > 0.0) {
      local *= glm::mat4_cast(glm::normalize(rotation));
    } else if (document->tree.reached[index]) {
      document->warnings.add("a rotation of length zero is ignored", element("nodes", index));
    }
  }
  if (node.scale.size() == 3)
    for (int c = 0; c < 3; ++c) local[c] *= node.scale[static_cast<std::size_t>(c)];
  return local;
}

/// Parents of all nodes. Throws for a node that has two parents or is its own ancestor.
std::vector<int> find_parents(const Document& document) {
  const auto& nodes = document.model.nodes;
  std::vector<int> parents(nodes.size(), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const int child : nodes[i].children) {
      int& parent = parents[static_cast<std::size_t>(child)];
      if (parent >= 0)
        throw Error(at(document.path, element("nodes", static_cast<std::size_t>(child))),
                    "has two parents, " + std::to_string(parent) + " and " + std::to_string(i), kDamaged);
      parent = static_cast<int>(i);
    }
  }
  // With at most one parent each, nodes that no root reaches form a cycle.
  std::vector<char> reached(nodes.size(), 0);
  std::vector<int> stack;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (parents[i] < 0) stack.push_back(static_cast<int>(i));
  while (!stack.empty()) {
    const auto i = static_cast<std::size_t>(stack.back());
    stack.pop_back();
    reached[i] = 1;
    stack.insert(stack.end(), nodes[i].children.begin(), nodes[i].children.end());
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (!reached[i]) throw Error(at(document.path, element("nodes", i)), "is its own ancestor", kDamaged);
  return parents;
}

std::vector<int> root_nodes(const Document& document, std::size_t scene, const std::vector<int>& parents) {
  const auto& scenes = document.model.scenes;
  std::vector<int> roots;
  if (scenes.empty()) {
    for (std::size_t i = 0; i < parents.size(); ++i)
      if (parents[i] < 0) roots.push_back(static_cast<int>(i));
    return roots;
  }
  std::vector<char> seen(parents.size(), 0);
  for (const int root : scenes[scene].nodes) {
    const auto i = static_cast<std::size_t>(root);
    if (parents[i] >= 0)
      throw Error(at(document.path, element("scenes", scene)),
                  "its root " + std::to_string(root) + " is a child of node " + std::to_string(parents[i]), kDamaged);
    if (seen[i]++ == 0) roots.push_back(root);
  }
  return roots;
}

std::string scene_name(const Json& scene) {
  const auto found = scene.find("name");
  return found != scene.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// Names of the file's scenes for a message.
std::string list_scenes(const Json& scenes) {
  constexpr std::size_t kListed = 20;
  std::string out;
  for (std::size_t i = 0; i < std::min(scenes.size(), kListed); ++i) {
    const std::string name = scene_name(scenes[i]);
    out += (i > 0 ? ", " : "") + std::to_string(i) + (name.empty() ? "" : " " + name_text(name));
  }
  return out + (scenes.size() > kListed ? ", ..." : "");
}

/// Index of the scene to import; a name goes before a number.
std::size_t choose_scene(const Document& document, const std::string& wanted) {
  const Json& scenes = document.root["scenes"];
  for (std::size_t i = 0; i < scenes.size(); ++i)
    if (scene_name(scenes[i]) == wanted) return i;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    if (std::to_string(i) == wanted) return i;
  throw UsageError("--scene " + wanted, document.path + " has no such scene", "it has " + list_scenes(scenes));
}

}  // namespace

void import_tree(Document* document, const std::string& wanted) {
  NodeTree& tree = document->tree;
  const std::size_t count = document->model.nodes.size();
  tree.parents = find_parents(*document);
  if (!wanted.empty() && document->model.scenes.empty())
    throw UsageError("--scene " + wanted, document->path + " has no scenes", "leave it out");
  const std::size_t scene = wanted.empty() ? static_cast<std::size_t>(std::max(document->model.defaultScene, 0))
                                           : choose_scene(*document, wanted);
  tree.roots = root_nodes(*document, scene, tree.parents);
  tree.reached.assign(count, false);
  std::vector<int> stack = tree.roots;
  while (!stack.empty()) {
    const auto i = static_cast<std::size_t>(stack.back());
    stack.pop_back();
    tree.reached[i] = true;
    const auto& children = document->model.nodes[i].children;
    stack.insert(stack.end(), children.begin(), children.end());
  }
  if (wanted.empty() && document->model.scenes.size() > 1)
    document->warnings.add("only the default of " + std::to_string(document->model.scenes.size()) +
                           " scenes is shown; --scene chooses another: " + list_scenes(document->root["scenes"]));
  tree.local.resize(count);
  for (std::size_t i = 0; i < count; ++i) tree.local[i] = local_transform(document, i);
}

std::vector<glm::dmat4> world_of_nodes(const Document& document) {
  const NodeTree& tree = document.tree;
  std::vector<glm::dmat4> world(tree.local.size(), glm::dmat4(1.0));
  std::vector<int> stack;
  for (std::size_t i = 0; i < world.size(); ++i)
    if (tree.parents[i] < 0) stack.push_back(static_cast<int>(i));
  while (!stack.empty()) {
    const auto i = static_cast<std::size_t>(stack.back());
    stack.pop_back();
    const int parent = tree.parents[i];
    world[i] = parent < 0 ? tree.local[i] : world[static_cast<std::size_t>(parent)] * tree.local[i];
    const auto& children = document.model.nodes[i].children;
    stack.insert(stack.end(), children.begin(), children.end());
  }
  return world;
}

}  // namespace maquette::gltf
