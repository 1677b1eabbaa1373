#include <cmath>
#include <glm/gtc/type_ptr.hpp>

#include "scenes/error.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

constexpr const char* kRemedy = "the file is damaged; export it again";
/// Above this, squares of transformed points exceed float's range.
constexpr float kMaxTransform = 1e12f;

glm::mat4 local_transform(Document* document, std::size_t index) {
  const tinygltf::Node& node = document->model.nodes[index];
  if (node.matrix.size() == 16) return glm::mat4(glm::make_mat4(node.matrix.data()));
  glm::dmat4 local(1.0);
  if (node.translation.size() == 3) local[3] = glm::dvec4(glm::make_vec3(node.translation.data()), 1.0);
  if (node.rotation.size() == 4) {
    const std::vector<double>& r = node.rotation;
    const glm::dquat rotation(r[3], r[0], r[1], r[2]);
    if (glm::length(rotation) > 0.0) {
      local *= glm::mat4_cast(glm::normalize(rotation));
    } else {
      document->warnings.add("a rotation of length zero is ignored", element("nodes", index));
    }
  }
  if (node.scale.size() == 3)
    for (int c = 0; c < 3; ++c) local[c] *= node.scale[static_cast<std::size_t>(c)];
  return glm::mat4(local);
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
                    "has two parents, " + std::to_string(parent) + " and " + std::to_string(i), kRemedy);
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
    if (!reached[i]) throw Error(at(document.path, element("nodes", i)), "is its own ancestor", kRemedy);
  return parents;
}

std::vector<int> root_nodes(const Document& document, const std::vector<int>& parents) {
  const auto& scenes = document.model.scenes;
  std::vector<int> roots;
  if (scenes.empty()) {
    for (std::size_t i = 0; i < parents.size(); ++i)
      if (parents[i] < 0) roots.push_back(static_cast<int>(i));
    return roots;
  }
  const auto scene = static_cast<std::size_t>(std::max(document.model.defaultScene, 0));
  std::vector<char> seen(parents.size(), 0);
  for (const int root : scenes[scene].nodes) {
    const auto i = static_cast<std::size_t>(root);
    if (parents[i] >= 0)
      throw Error(at(document.path, element("scenes", scene)),
                  "its root " + std::to_string(root) + " is a child of node " + std::to_string(parents[i]), kRemedy);
    if (seen[i]++ == 0) roots.push_back(root);
  }
  return roots;
}

Node import_node(Document* document, std::size_t index, const Fixtures& fixtures, const Scene& scene) {
  const tinygltf::Node& source = document->model.nodes[index];
  const Json& json = element_json(*document, "nodes", index);
  Node node;
  node.name = source.name;
  node.local = local_transform(document, index);
  node.mesh = source.mesh;
  node.camera = camera_of_node(document, fixtures, index);
  node.light = light_of_node(document, fixtures, index);
  import_node_extras(json, at(document->path, element("nodes", index)), scene, &node);
  return node;
}

void check_transforms(const Document& document, const Scene& scene) {
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t i = 0; i < world.size(); ++i)
    for (int c = 0; c < 16; ++c)
      if (!(std::abs(glm::value_ptr(world[i])[c]) <= kMaxTransform))
        throw Error(at(document.path, "node \"" + scene.nodes[i].name + "\""),
                    "its transform is not finite or beyond 1e12", "scale the model");
}

}  // namespace

void import_nodes(Document* document, Scene* scene) {
  const Fixtures fixtures = import_fixtures(document, scene);
  const std::vector<int> parents = find_parents(*document);

  // Keeps only the nodes that the default scene reaches, in the order of the file.
  const std::vector<int> roots = root_nodes(*document, parents);
  std::vector<int> new_index(parents.size(), -1);
  std::vector<int> stack = roots;
  while (!stack.empty()) {
    const auto i = static_cast<std::size_t>(stack.back());
    stack.pop_back();
    new_index[i] = 0;
    const auto& children = document->model.nodes[i].children;
    stack.insert(stack.end(), children.begin(), children.end());
  }
  int count = 0;
  for (int& index : new_index)
    if (index == 0) index = count++;

  for (std::size_t i = 0; i < parents.size(); ++i) {
    if (new_index[i] < 0) continue;
    Node node = import_node(document, i, fixtures, *scene);
    node.parent = parents[i] < 0 ? -1 : new_index[static_cast<std::size_t>(parents[i])];
    for (const int child : document->model.nodes[i].children)
      node.children.push_back(new_index[static_cast<std::size_t>(child)]);
    scene->nodes.push_back(std::move(node));
  }
  for (const int root : roots) scene->roots.push_back(new_index[static_cast<std::size_t>(root)]);
  check_transforms(*document, *scene);
  place_cameras(document, scene);
}

}  // namespace maquette::gltf
