#include "viewer/dents.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "scenes/error.h"
#include "scenes/node_paths.h"

namespace maquette {

namespace {

/// The vertex of a limit surface nearest to the dent: its distance and unit normal, in the world.
struct Nearest {
  float distance_m = std::numeric_limits<float>::max();
  glm::vec3 normal{0.0f, 1.0f, 0.0f};
};

std::string place_of(const Dent& dent) {
  char text[96];
  std::snprintf(text, sizeof text, "--dent %g,%g,%g", static_cast<double>(dent.center.x),
                static_cast<double>(dent.center.y), static_cast<double>(dent.center.z));
  return text;
}

/// Nodes with a subdivision surface that the dent may move.
std::vector<std::size_t> dented_nodes(const Scene& scene, const Dent& dent) {
  std::vector<std::size_t> nodes;
  std::set<int> parts;
  if (!dent.part.empty()) {
    parts = called_nodes(scene, std::set<std::string>{dent.part});
    if (parts.empty()) throw Error(place_of(dent), scene.name + " has no part " + dent.part, "press it again");
  }
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (!node.visible || node.mesh < 0 || !scene.meshes[static_cast<std::size_t>(node.mesh)].cage) continue;
    if (dent.part.empty() || parts.contains(static_cast<int>(i))) nodes.push_back(i);
  }
  return nodes;
}

[[noreturn]] void refuse(const Scene& scene, const Dent& dent, const Nearest& nearest) {
  char distance[32];
  std::snprintf(distance, sizeof distance, "%g", std::round(static_cast<double>(nearest.distance_m) * 1e3) / 1e3);
  const bool any = nearest.distance_m < std::numeric_limits<float>::max();
  throw Error(place_of(dent), "no control point of a subdivision surface is that near",
              any ? std::string("the nearest surface is ") + distance + " m away; move it or widen the radius"
                  : scene.name + " has no subdivision surface");
}

}  // namespace

const SubdivisionEvaluator& DentedSurfaces::evaluator(int mesh) {
  auto found = evaluators_.find(mesh);
  if (found == evaluators_.end())
    found = evaluators_.emplace(mesh, SubdivisionEvaluator(*scene_->meshes[static_cast<std::size_t>(mesh)].cage)).first;
  return found->second;
}

const DentedSurfaces::Surface* DentedSurfaces::surface(int mesh) const {
  if (steps_.empty()) return nullptr;
  const auto found = steps_.back().after.find(mesh);
  return found == steps_.back().after.end() ? nullptr : found->second.get();
}

std::set<int> DentedSurfaces::meshes() const {
  std::set<int> all;
  if (!steps_.empty())
    for (const auto& [mesh, surface] : steps_.back().after) all.insert(mesh);
  return all;
}

DentedSurfaces::Surfaces DentedSurfaces::pressed(const Surfaces& before, const Dent& dent) {
  const std::vector<glm::mat4> world = compute_world_transforms(*scene_);
  const std::vector<std::size_t> nodes = dented_nodes(*scene_, dent);
  Nearest nearest;
  for (const std::size_t i : nodes) {
    const int mesh = scene_->nodes[i].mesh;
    const Primitive& primitive = scene_->meshes[static_cast<std::size_t>(mesh)].primitives.front();
    const auto moved = before.find(mesh);
    const std::vector<glm::vec3>& positions = moved == before.end() ? primitive.positions : moved->second->positions;
    const std::vector<glm::vec3>& normals = moved == before.end() ? primitive.normals : moved->second->normals;
    const glm::mat3 normal_matrix = glm::transpose(glm::inverse(glm::mat3(world[i])));
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const float distance = glm::length(glm::vec3(world[i] * glm::vec4(positions[v], 1.0f)) - dent.center);
      if (distance < nearest.distance_m) nearest = {distance, glm::normalize(normal_matrix * normals[v])};
    }
  }
  Surfaces after = before;
  std::set<int> done;  // a mesh with several instances is dented once
  for (const std::size_t i : nodes) {
    const int mesh = scene_->nodes[i].mesh;
    if (done.contains(mesh)) continue;
    const glm::mat4 node_from_world = glm::inverse(world[i]);
    const glm::vec3 push = glm::mat3(node_from_world) * (-nearest.normal * dent.depth_m);
    const float depth = glm::length(push);
    if (!(depth > 0.0f)) continue;
    const float scale = std::cbrt(std::abs(glm::determinant(glm::mat3(node_from_world))));
    SubdivisionCage cage = *scene_->meshes[static_cast<std::size_t>(mesh)].cage;
    if (const auto moved = before.find(mesh); moved != before.end()) cage.positions = moved->second->points;
    if (dent_cage(&cage, glm::vec3(node_from_world * glm::vec4(dent.center, 1.0f)), push / depth, depth,
                  dent.radius_m * scale) == 0)
      continue;
    done.insert(mesh);
    auto surface = std::make_shared<Surface>();
    surface->points = std::move(cage.positions);
    evaluator(mesh).evaluate(surface->points, &surface->positions, &surface->normals);
    after[mesh] = std::move(surface);
  }
  if (done.empty() && dent.depth_m != 0.0f) refuse(*scene_, dent, nearest);
  return after;
}

std::set<int> DentedSurfaces::press(const std::vector<Dent>& dents) {
  std::size_t same = 0;
  while (same < steps_.size() && same < dents.size() && steps_[same].dent == dents[same]) ++same;
  std::vector<Step> steps(steps_.begin(), steps_.begin() + static_cast<std::ptrdiff_t>(same));
  for (std::size_t k = same; k < dents.size(); ++k)
    steps.push_back({dents[k], pressed(steps.empty() ? Surfaces() : steps.back().after, dents[k])});
  const Surfaces before = steps_.empty() ? Surfaces() : steps_.back().after;
  const Surfaces after = steps.empty() ? Surfaces() : steps.back().after;
  steps_ = std::move(steps);
  std::set<int> changed;
  for (const auto& [mesh, surface] : before)
    if (const auto now = after.find(mesh); now == after.end() || now->second != surface) changed.insert(mesh);
  for (const auto& [mesh, surface] : after)
    if (!before.contains(mesh)) changed.insert(mesh);
  return changed;
}

void press_dents(Scene* scene, const std::vector<Dent>& dents) {
  DentedSurfaces surfaces(scene);
  for (const int index : surfaces.press(dents)) {
    const DentedSurfaces::Surface& surface = *surfaces.surface(index);
    Mesh& mesh = scene->meshes[static_cast<std::size_t>(index)];
    SubdivisionCage cage = *mesh.cage;
    cage.positions = surface.points;
    mesh.cage = std::make_shared<const SubdivisionCage>(std::move(cage));
    mesh.primitives[0].positions = surface.positions;
    mesh.primitives[0].normals = surface.normals;
  }
}

}  // namespace maquette
