#include "viewer/pose.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "render/parts/parts.h"
#include "scenes/error.h"
#include "scenes/node_paths.h"
#include "scenes/suggest.h"
#include "viewer/session.h"

namespace maquette {

namespace {

constexpr double kSampling_s = 1.0 / 50.0;  // of a camera that an animation moves
constexpr std::size_t kMostSamples = 5000;
constexpr double kPoseTolerance = 1e-3;  // of the scene's radius, and rad

void turn_nodes(Scene* scene, const std::vector<int>& nodes, const glm::dmat4& rotation) {
  for (const int index : nodes) {
    Node& node = scene->nodes[static_cast<std::size_t>(index)];
    const glm::dvec4 origin = glm::dmat4(node.local)[3];
    node.local = glm::mat4(rotation * glm::dmat4(node.local));
    node.local[3] = glm::vec4(origin);
  }
}

/// `count`: of the nodes that belong to the file.
void turn(Scene* scene, const NodeTurn& turn, std::size_t count) {
  const glm::dmat4 rotation =
      glm::rotate(glm::dmat4(1.0), glm::radians(static_cast<double>(turn.angle_deg)), glm::dvec3(turn.axis));
  if (turn.node != "*") return turn_nodes(scene, called_nodes(*scene, node_paths(*scene), turn.node), rotation);
  for (const int root : scene->roots) {
    Node& node = scene->nodes[static_cast<std::size_t>(root)];
    const bool of_file = static_cast<std::size_t>(root) < count;
    if (of_file && node.camera < 0 && node.light < 0) node.local = glm::mat4(rotation * glm::dmat4(node.local));
  }
}

bool moves(const Scene& scene, const Animation& animation, int node) {
  for (int at = node; at >= 0; at = scene.nodes[static_cast<std::size_t>(at)].parent)
    if (std::ranges::find(animation.nodes, at, &AnimatedNode::node) != animation.nodes.end()) return true;
  return false;
}

/// Through what the camera sees at times of the animation.
CameraPath path_of_camera(const Scene& scene, const Animation& animation, const std::string& camera) {
  Scene posed;  // its nodes and cameras alone
  posed.name = scene.name;
  posed.nodes = scene.nodes;
  posed.roots = scene.roots;
  posed.cameras = scene.cameras;
  const double radius_m = std::max(static_cast<double>(framed_bounds(scene).radius()), 1e-3);
  const auto steps =
      std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil(animation.duration_s / kSampling_s)), 1, kMostSamples);
  std::vector<RecordedView> views;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double time_s = animation.duration_s * static_cast<double>(i) / static_cast<double>(steps);
    pose(&posed, animation, time_s);
    views.push_back({time_s, camera_by_name(posed, camera)});
  }
  return thinned(views, {kPoseTolerance * radius_m, kPoseTolerance});
}

}  // namespace

RestPose rest_pose(const Scene& scene) {
  RestPose rest;
  for (const Node& node : scene.nodes) rest.push_back(node.local);
  return rest;
}

void turn_node(Scene* scene, const NodeTurn& asked) {
  if (asked.node != "*") find_nodes(*scene, asked.node);
  turn(scene, asked, scene->nodes.size());
}

bool is_posed(const Edits& edits) { return !edits.turns.empty() || !edits.animation.name.empty(); }

void pose_nodes(Scene* scene, const RestPose& rest, const Edits& edits) {
  for (std::size_t i = 0; i < std::min(rest.size(), scene->nodes.size()); ++i) scene->nodes[i].local = rest[i];
  const int index = edits.animation.name.empty() ? -1 : animation_index(*scene, edits.animation.name);
  if (index >= 0) pose(scene, scene->animations[static_cast<std::size_t>(index)], edits.animation.time_s);
  for (const NodeTurn& asked : edits.turns) turn(scene, asked, rest.size());
}

int find_animation(const Scene& scene, const std::string& name) {
  const int index = animation_index(scene, name);
  if (index >= 0) return index;
  std::vector<std::string> names;
  for (const Animation& animation : scene.animations) names.push_back(animation.name);
  throw UsageError("--animation " + name, scene.name + " has no such animation",
                   names.empty() ? "it has none" : did_you_mean(name, names));
}

std::vector<CameraPath> paths_of_animation(const Scene& scene, const Animation& animation, const CameraView& view) {
  std::vector<CameraPath> paths;
  if (!(animation.duration_s > 0.0)) return paths;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (node.camera < 0 || !moves(scene, animation, static_cast<int>(i))) continue;
    const std::string& camera = scene.cameras[static_cast<std::size_t>(node.camera)].name;
    CameraPath path = path_of_camera(scene, animation, camera);
    path.name = animation.name + " (" + camera + ")";
    path.animation = animation.name;
    paths.push_back(std::move(path));
  }
  if (!paths.empty()) return paths;
  PathKey key;
  key.camera = view;
  key.duration_s = animation.duration_s;
  CameraPath rests;
  rests.name = rests.animation = animation.name;
  rests.keys = {key, key};
  return {rests};
}

}  // namespace maquette
