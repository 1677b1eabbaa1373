#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "review/camera_path.h"
#include "review/look.h"
#include "scenes/scene.h"

namespace maquette {

/// parent_from_node of all nodes, as the file has them.
using RestPose = std::vector<glm::mat4>;
RestPose rest_pose(const Scene& scene);

/// Turns nodes about an axis of their parent's frame, through their own origin; `*`: all roots that are drawn, about
/// the world's origin. Throws UsageError for a node that is not there.
void turn_node(Scene* scene, const NodeTurn& turn);

/// Index of an animation. Throws UsageError with the nearest names.
int find_animation(const Scene& scene, const std::string& name);

/// Puts the first nodes of the scene where the animation and the turns of the edits have them; those beyond `rest` (an
/// added ground) stay. An animation and nodes that the scene does not have are left out.
void pose_nodes(Scene* scene, const RestPose& rest, const Edits& edits);
/// Whether the edits move any node.
bool is_posed(const Edits& edits);

/// The paths that an animation plays along: one for each camera that it moves, through its positions, thinned; where it
/// moves none, one of its duration that rests at `view`. Empty for an animation without duration.
std::vector<CameraPath> paths_of_animation(const Scene& scene, const Animation& animation, const CameraView& view);

}  // namespace maquette
