#pragma once

#include <glm/glm.hpp>
#include <string>

#include "scenes/scene.h"

namespace maquette {

/// Index of a node by name, else by path. Throws UsageError with the nearest names.
int find_node(const Scene& scene, const std::string& name, const std::string& option);

/// Gives a material a Lambertian reflectance, the same in all channels and without gloss, textures or tables.
void make_lambertian(Scene* scene, int material, double reflectance);

/// Turns a node about a horizontal axis through `hinge` (m, world), by which its outward normal `normal` (unit) gets
/// `degrees` steeper: the rake of its plane, from the vertical, becomes larger. Returns the turn, of world points.
glm::dmat4 turn_rake(Scene* scene, int node, const glm::dvec3& hinge, const glm::dvec3& normal, double degrees);

}  // namespace maquette
