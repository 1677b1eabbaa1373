#pragma once

#include "render/prt/transfer_bake.h"

namespace maquette {

/// Of what casts shadows, evenly spaced in the order of the geometry.
std::vector<glm::vec3> occluder_points(const TransferJob& job);
std::vector<glm::vec3> positions_of(const TransferMesh& mesh);

/// What a bake was made with instead of what is wanted, as words; empty: they are the same but for rigid motions.
std::string option_difference(const TransferProvenance& found, const TransferProvenance& wanted);

/// Whether a bake of the same shape is that of the parts as they stand now: turned along with what casts shadows.
struct Placement {
  std::optional<RigidMotion> motion;  ///< none: the vertices have moved against each other
  bool shadows_fit = true;
  std::string why;  ///< they do not
};
Placement place(const TransferProvenance& found, const std::vector<glm::vec3>& positions,
                const std::vector<glm::vec3>& occluders, const TransferProvenance& wanted, const TransferMesh& mesh,
                const std::vector<glm::vec3>& occluders_now);

}  // namespace maquette
