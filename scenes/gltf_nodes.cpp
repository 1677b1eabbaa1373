#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <limits>

#include "scenes/error.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

constexpr const char* kRemedy = "the file is damaged; export it again";
constexpr const char* kLights = "KHR_lights_punctual";
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

/// Index in the scene of each camera of the file, -1 for unsupported ones.
std::vector<int> import_cameras(Document* document, Scene* scene) {
  std::vector<int> map;
  for (std::size_t i = 0; i < document->model.cameras.size(); ++i) {
    const Json& json = element_json(*document, "cameras", i);
    const std::string where = element("cameras", i);
    const Json& type = json["type"];
    if (!type.is_string() || type.get_ref<const std::string&>() != "perspective" || !json.contains("perspective")) {
      document->warnings.add("only perspective cameras are read", where);
      map.push_back(-1);
      continue;
    }
    const std::string path = at(document->path, where + ".perspective");
    Camera camera;
    camera.name = json.value("name", "");
    camera.fov_y_rad = read_number(json["perspective"], "yfov", camera.fov_y_rad, path);
    camera.aspect = std::max(read_number(json["perspective"], "aspectRatio", 0.0f, path), 0.0f);
    camera.near_m = read_number(json["perspective"], "znear", camera.near_m, path);
    camera.far_m = read_number(json["perspective"], "zfar", camera.far_m, path);
    if (!(camera.fov_y_rad > 0.0f && camera.fov_y_rad < glm::pi<float>()))
      throw Error(path + ".yfov", "is " + std::to_string(camera.fov_y_rad) + ", expected 0 to pi", kRemedy);
    if (!(camera.near_m > 0.0f && camera.far_m > camera.near_m))
      throw Error(path, "znear and zfar are not 0 < znear < zfar", kRemedy);
    map.push_back(static_cast<int>(scene->cameras.size()));
    scene->cameras.push_back(camera);
  }
  return map;
}

PunctualLight import_light(const Json& json, const std::string& where) {
  PunctualLight light;
  const std::string type = read_text(json, "type", where);
  if (type == "directional") {
    light.kind = PunctualLight::Kind::directional;
  } else if (type == "spot") {
    light.kind = PunctualLight::Kind::spot;
  } else if (type != "point") {
    throw Error(where + ".type", "\"" + type + "\" is not directional, point or spot", kRemedy);
  }
  light.name = read_text(json, "name", where);
  light.color = glm::max(read_vector<3>(json, "color", glm::vec3(1.0f), where), glm::vec3(0.0f));
  light.intensity = std::max(read_number(json, "intensity", 1.0f, where), 0.0f);
  light.range_m = std::max(read_number(json, "range", 0.0f, where), 0.0f);
  if (light.kind == PunctualLight::Kind::spot && json.contains("spot")) {
    light.inner_cone_rad = read_number(json["spot"], "innerConeAngle", light.inner_cone_rad, where + ".spot");
    light.outer_cone_rad = read_number(json["spot"], "outerConeAngle", light.outer_cone_rad, where + ".spot");
    const bool valid = light.inner_cone_rad >= 0.0f && light.inner_cone_rad < light.outer_cone_rad &&
                       light.outer_cone_rad <= glm::half_pi<float>() + 1e-6f;
    if (!valid) throw Error(where + ".spot", "cone angles are not 0 <= inner < outer <= pi/2", kRemedy);
  }
  return light;
}

void import_lights(const Document& document, Scene* scene) {
  const Json* extension = find_extension(document.root, kLights);
  if (extension == nullptr) return;
  const Json& lights = (*extension)["lights"];
  for (std::size_t i = 0; i < lights.size(); ++i)
    scene->lights.push_back(
        import_light(lights[i], at(document.path, std::string(kLights) + "." + element("lights", i))));
}

int light_of(const Document& document, const Json& json, const std::string& where, const Scene& scene) {
  const Json* extension = find_extension(json, kLights);
  if (extension == nullptr) return -1;
  const auto light = (*extension)["light"].get<std::size_t>();
  if (light >= scene.lights.size())
    throw Error(at(document.path, where),
                "names light " + std::to_string(light) + " of " + std::to_string(scene.lights.size()), kRemedy);
  return static_cast<int>(light);
}

Node import_node(Document* document, std::size_t index, const std::vector<int>& cameras, const Scene& scene) {
  const tinygltf::Node& source = document->model.nodes[index];
  Node node;
  node.name = source.name;
  node.local = local_transform(document, index);
  node.mesh = source.mesh;
  node.camera = source.camera < 0 ? -1 : cameras[static_cast<std::size_t>(source.camera)];
  node.light = light_of(*document, element_json(*document, "nodes", index), element("nodes", index), scene);
  import_node_extras(element_json(*document, "nodes", index), at(document->path, element("nodes", index)), scene,
                     &node);
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

void name_cameras(Scene* scene) {
  for (const Node& node : scene->nodes)
    if (node.camera >= 0 && scene->cameras[static_cast<std::size_t>(node.camera)].name.empty())
      scene->cameras[static_cast<std::size_t>(node.camera)].name = node.name;
  for (std::size_t i = 0; i < scene->cameras.size(); ++i)
    if (scene->cameras[i].name.empty()) scene->cameras[i].name = "camera-" + std::to_string(i);
}

}  // namespace

void import_nodes(Document* document, Scene* scene) {
  const std::vector<int> cameras = import_cameras(document, scene);
  import_lights(*document, scene);
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
    Node node = import_node(document, i, cameras, *scene);
    node.parent = parents[i] < 0 ? -1 : new_index[static_cast<std::size_t>(parents[i])];
    for (const int child : document->model.nodes[i].children)
      node.children.push_back(new_index[static_cast<std::size_t>(child)]);
    scene->nodes.push_back(std::move(node));
  }
  for (const int root : roots) scene->roots.push_back(new_index[static_cast<std::size_t>(root)]);
  check_transforms(*document, *scene);
  name_cameras(scene);
}

}  // namespace maquette::gltf
