#include <utility>

#include "scenes/modelling.h"
#include "scenes/subdivision.h"

namespace maquette::modelling {

SubdivisionCage make_grid_cage(const std::vector<Vec3>& points, int columns, bool wrap_rows, bool wrap_columns,
                               int levels) {
  SubdivisionCage cage;
  cage.levels = levels;
  const int rows = static_cast<int>(points.size()) / columns;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      cage.positions.emplace_back(points[static_cast<std::size_t>(i * columns + j)]);
      cage.uvs.emplace_back(static_cast<float>(i) / static_cast<float>(rows - 1),
                            static_cast<float>(j) / static_cast<float>(columns - 1));
    }
  for (int i = 0; i < rows - (wrap_rows ? 0 : 1); ++i)
    for (int j = 0; j < columns - (wrap_columns ? 0 : 1); ++j) {
      const int i1 = (i + 1) % rows, j1 = (j + 1) % columns;
      cage.face_sizes.push_back(4);
      for (const int k : {i * columns + j, i1 * columns + j, i1 * columns + j1, i * columns + j1})
        cage.face_indices.push_back(k);
    }
  return cage;
}

SubdivisionCage make_ring_cage(const std::vector<Vec3>& points, int columns, int levels) {
  SubdivisionCage cage = make_grid_cage(points, columns, false, true, levels);
  const int last = static_cast<int>(points.size()) - columns;
  for (int j = 0; j + 1 < columns / 2; ++j) {
    const int a = j, b = j + 1, c = columns - 2 - j, d = columns - 1 - j;
    cage.face_sizes.insert(cage.face_sizes.end(), {4, 4});
    cage.face_indices.insert(cage.face_indices.end(), {a, b, c, d, last + d, last + c, last + b, last + a});
  }
  return cage;
}

int SceneBuilder::add_cage(const std::string& name, const SubdivisionCage& cage, int material, const glm::dmat4& pose) {
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
  node.local = glm::mat4(pose);
  return add_node(std::move(node));
}

}  // namespace maquette::modelling
