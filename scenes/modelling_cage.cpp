#include <utility>

#include "scenes/modelling.h"
#include "scenes/subdivision.h"

namespace maquette::modelling {

int SceneBuilder::add_cage(const std::string& name, const SubdivisionCage& cage, int material,
                           const glm::dmat4& place) {
  Mesh mesh;
  mesh.name = name;
  mesh.cage = std::make_shared<const SubdivisionCage>(cage);
  mesh.primitives.emplace_back();
  mesh.primitives[0].material = material;
  tessellate_cage(&mesh);
  scene_.meshes.push_back(std::move(mesh));
  Node node;
  node.name = name;
  node.mesh = static_cast<int>(scene_.meshes.size()) - 1;
  node.local = glm::mat4(place);
  return add_node(std::move(node));
}

}  // namespace maquette::modelling
