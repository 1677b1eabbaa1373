#pragma once

#include <array>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <vector>

namespace maquette {

struct Scene;

/// One property of a node over time.
struct AnimationTrack {
  enum class Interpolation { step, linear, cubic };
  Interpolation interpolation = Interpolation::linear;
  std::vector<float> times_s;  ///< increasing; empty: the property rests
  /// One a time; `cubic`: three, the tangent in, the value, the tangent out. Rotations: quaternions x, y, z, w.
  std::vector<glm::vec4> values;
};

/// A node that moves, and where it rests.
struct AnimatedNode {
  enum Property { translation, rotation, scale, kProperties };
  int node = -1;
  std::array<glm::vec4, kProperties> rest{glm::vec4(0.0f), glm::vec4(0.0f, 0.0f, 0.0f, 1.0f), glm::vec4(1.0f)};
  std::array<AnimationTrack, kProperties> tracks;
};

/// Moves nodes of a scene (glTF `animations`); skins and morph targets are not moved.
struct Animation {
  std::string name;
  std::vector<AnimatedNode> nodes;
  double duration_s = 0.0;  ///< of its last key
};

/// Value of a track; before its first key and after its last one it is theirs.
/// Source: glTF 2.0, appendix C (interpolation; Hermite tangents are scaled by the duration of the interval).
glm::vec4 value_at(const AnimationTrack& track, bool is_rotation, double time_s);
/// parent_from_node of an animated node.
glm::mat4 local_at(const AnimatedNode& node, double time_s);
/// Index of an animation by name, -1 when the scene has none of that name.
int animation_index(const Scene& scene, const std::string& name);
/// Moves the nodes of the scene.
void pose(Scene* scene, const Animation& animation, double time_s);

}  // namespace maquette
