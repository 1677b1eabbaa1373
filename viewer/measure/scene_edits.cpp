#include "viewer/measure/scene_edits.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "render/parts/parts.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

int find_node(const Scene& scene, const std::string& name, const std::string& option) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].name == name || node_path(scene, static_cast<int>(i)) == name) return static_cast<int>(i);
    if (!scene.nodes[i].name.empty()) names.push_back(scene.nodes[i].name);
  }
  throw UsageError(option + " " + name, scene.name + " has no such node", did_you_mean(name, names));
}

void make_lambertian(Scene* scene, int material, double reflectance) {
  Material plain;
  const Material& old = scene->materials[static_cast<std::size_t>(material)];
  plain.name = old.name;
  plain.double_sided = old.double_sided;
  plain.base_color = glm::vec4(glm::vec3(static_cast<float>(reflectance)), 1.0f);
  plain.metallic = 0.0f;
  plain.specular = 0.0f;
  scene->materials[static_cast<std::size_t>(material)] = plain;
}

glm::dmat4 turn_rake(Scene* scene, int node, const glm::dvec3& hinge, const glm::dvec3& normal, double degrees) {
  const glm::dvec3 up(0.0, 1.0, 0.0), axis = glm::cross(normal, up);
  if (glm::dot(axis, axis) < 1e-12) throw Error("--sweep rake", "the pane is horizontal", "sweep another quantity");
  const glm::dmat4 turn = glm::translate(glm::dmat4(1.0), hinge) *
                          glm::rotate(glm::dmat4(1.0), glm::radians(degrees), glm::normalize(axis)) *
                          glm::translate(glm::dmat4(1.0), -hinge);
  const std::vector<glm::mat4> world = compute_world_transforms(*scene);
  Node& moved = scene->nodes[static_cast<std::size_t>(node)];
  const glm::dmat4 parent =
      moved.parent < 0 ? glm::dmat4(1.0) : glm::dmat4(world[static_cast<std::size_t>(moved.parent)]);
  moved.local = glm::mat4(glm::inverse(parent) * turn * glm::dmat4(world[static_cast<std::size_t>(node)]));
  return turn;
}

}  // namespace maquette
