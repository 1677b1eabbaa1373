#pragma once

#include <vector>

#include "scenes/btf/direction_mesh.h"

namespace maquette {

/// Appends what near_views of shaders/prt/transfer.glsl reads of a mesh of directions. Returns triangles and borders.
struct ViewTableSize {
  int triangles = 0, borders = 0;
};
ViewTableSize append_view_table(const DirectionMesh& mesh, std::vector<glm::vec4>* table);

}  // namespace maquette
