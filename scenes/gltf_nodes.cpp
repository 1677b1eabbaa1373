#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <optional>

#include "scenes/error.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

/// Above this, squares of transformed points exceed float's range.
constexpr float kMaxTransform = 1e12f;

/// [node of the file] hidden by KHR_node_visibility, its own or that of a node above it.
std::vector<bool> find_hidden(const Document& document) {
  std::vector<bool> hidden(document.model.nodes.size(), false);
  std::vector<int> open(document.tree.roots.begin(), document.tree.roots.end());
  while (!open.empty()) {
    const auto node = static_cast<std::size_t>(open.back());
    open.pop_back();
    const Json* extension = find_extension(element_json(document, "nodes", node), "KHR_node_visibility");
    if (extension != nullptr && !extension->value("visible", true)) hidden[node] = true;
    for (const int child : document.model.nodes[node].children) {
      hidden[static_cast<std::size_t>(child)] = hidden[node];
      open.push_back(child);
    }
  }
  return hidden;
}

Node import_node(Document* document, std::size_t index, const Fixtures& fixtures, const Scene& scene) {
  const tinygltf::Node& source = document->model.nodes[index];
  const Json& json = element_json(*document, "nodes", index);
  Node node;
  node.name = source.name;
  node.local = glm::mat4(document->tree.local[index]);
  node.mesh = document->node_uses[index];
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
        throw Error(at(document.path, name_node(scene.nodes[i].name, i)), "its transform is not finite or beyond 1e12",
                    "scale the model");
}

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
/// Limit of the instances of a file, so that a small file of zeros cannot ask for any number of nodes.
constexpr std::size_t kMaxInstances = 500'000;
/// An instance keeps so many bytes of its node's name: names may be as long as their file.
constexpr std::size_t kMaxInstanceName = 200;

/// One of the instances' attributes, or empty.
template <int N>
std::vector<glm::vec<N, float>> read_instances(const Document& document, const Json& attributes, const char* name,
                                               const std::string& where, std::optional<std::size_t>* count) {
  if (!attributes.contains(name)) return {};
  std::vector<glm::vec<N, float>> out = read_vectors<N>(document, attributes[name].get<std::size_t>());
  if (count->value_or(out.size()) != out.size() || out.size() > kMaxInstances)
    throw Error(where + "." + name,
                "has " + std::to_string(out.size()) + " instances, expected " +
                    (*count ? std::to_string(**count) : std::to_string(kMaxInstances) + " at most"),
                kDamaged);
  *count = out.size();
  return out;
}

/// Transforms of the instances of a node (parent_from_node of its children), or nothing without the extension.
std::optional<std::vector<glm::mat4>> instances_of(Document* document, std::size_t index) {
  const Json* extension = find_extension(element_json(*document, "nodes", index), kInstancing);
  if (extension == nullptr) return std::nullopt;
  const Json& attributes = (*extension)["attributes"];
  for (auto it = attributes.begin(); it != attributes.end(); ++it)
    if (it.key() != "TRANSLATION" && it.key() != "ROTATION" && it.key() != "SCALE")
      document->warnings.add("the attribute " + it.key() + " of instances is ignored", element("nodes", index));
  const std::string where = at(document->path, element("nodes", index) + "." + kInstancing);
  std::optional<std::size_t> count;
  const auto translations = read_instances<3>(*document, attributes, "TRANSLATION", where, &count);
  const auto rotations = read_instances<4>(*document, attributes, "ROTATION", where, &count);
  const auto scales = read_instances<3>(*document, attributes, "SCALE", where, &count);
  if (!count) return std::nullopt;
  document->instance_count += *count;
  if (document->instance_count > kMaxInstances)
    throw Error(where, "brings the file to more than " + std::to_string(kMaxInstances) + " instances", kDamaged);
  std::vector<glm::mat4> out(*count, glm::mat4(1.0f));
  for (std::size_t i = 0; i < *count; ++i) {
    if (!translations.empty()) out[i][3] = glm::vec4(translations[i], 1.0f);
    if (!rotations.empty()) {
      const glm::quat q(rotations[i].w, rotations[i].x, rotations[i].y, rotations[i].z);
      if (glm::length(q) > 0.0f) out[i] *= glm::mat4_cast(glm::normalize(q));
    }
    if (!scales.empty())
      for (int c = 0; c < 3; ++c) out[i][c] *= scales[i][c];
  }
  return out;
}

/// Moves the mesh of a node to nodes of its own where it has several instances, or where its skin leaves the node's
/// space.
void place_mesh(Document* document, std::size_t index, std::size_t node, Scene* scene) {
  const int mesh = scene->nodes[node].mesh;
  if (mesh < 0) return;
  const auto add_node = [&](const glm::mat4& local, int parent, const std::string& suffix) {
    Node copy;
    const Node& source = scene->nodes[node];
    copy.name = source.name.empty() ? std::string() : source.name.substr(0, kMaxInstanceName) + suffix;
    copy.parent = parent;
    copy.local = local;
    copy.mesh = mesh;
    copy.reflector = source.reflector;
    copy.visible = source.visible;
    scene->nodes.push_back(std::move(copy));
    return static_cast<int>(scene->nodes.size()) - 1;
  };
  if (document->mesh_uses[static_cast<std::size_t>(mesh)].detached) {
    scene->roots.push_back(add_node(glm::mat4(1.0f), -1, ""));
    scene->nodes[node].mesh = -1;
    return;
  }
  const std::optional<std::vector<glm::mat4>> instances = instances_of(document, index);
  if (!instances) return;
  scene->nodes[node].mesh = -1;
  for (std::size_t i = 0; i < instances->size(); ++i) {
    const int child = add_node((*instances)[i], static_cast<int>(node), "-" + std::to_string(i));
    scene->nodes[node].children.push_back(child);
  }
}

}  // namespace

void import_nodes(Document* document, Scene* scene) {
  const Fixtures fixtures = import_fixtures(document, scene);
  const NodeTree& tree = document->tree;
  const std::vector<bool> hidden = find_hidden(*document);
  // Keeps only the nodes that the scene reaches, in the order of the file.
  std::vector<int> new_index(tree.parents.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < new_index.size(); ++i)
    if (tree.reached[i]) new_index[i] = count++;
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    if (new_index[i] < 0) continue;
    Node node = import_node(document, i, fixtures, *scene);
    if (hidden[i]) {
      node.visible = false;
      node.light = -1;
    }
    node.parent = tree.parents[i] < 0 ? -1 : new_index[static_cast<std::size_t>(tree.parents[i])];
    for (const int child : document->model.nodes[i].children)
      node.children.push_back(new_index[static_cast<std::size_t>(child)]);
    scene->nodes.push_back(std::move(node));
  }
  for (const int root : tree.roots) scene->roots.push_back(new_index[static_cast<std::size_t>(root)]);
  for (std::size_t i = 0; i < new_index.size(); ++i)
    if (new_index[i] >= 0) place_mesh(document, i, static_cast<std::size_t>(new_index[i]), scene);
  check_transforms(*document, *scene);
  place_cameras(document, scene);
  import_animations(document, new_index, scene);
}

}  // namespace maquette::gltf
