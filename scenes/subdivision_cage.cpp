#include "scenes/subdivision_cage.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <string>

#include "scenes/error.h"
#include "scenes/subdivision.h"

namespace maquette {
namespace {

/// Limit of the quads after refinement: more would take minutes and gigabytes.
constexpr double kMaxLimitQuads = 1 << 21;

[[noreturn]] void fail(const std::string& what) { throw Error("subdivision cage", what, "repair the model"); }

void check_faces(const SubdivisionCage& cage) {
  std::size_t corner = 0;
  std::vector<int> sorted;
  for (std::size_t f = 0; f < cage.face_sizes.size(); ++f) {
    const int size = cage.face_sizes[f];
    if (size < 3 || static_cast<std::size_t>(size) > cage.face_indices.size() - corner)
      fail("face " + std::to_string(f) + " has " + std::to_string(size) + " corners");
    sorted.assign(cage.face_indices.begin() + static_cast<std::ptrdiff_t>(corner),
                  cage.face_indices.begin() + static_cast<std::ptrdiff_t>(corner) + size);
    std::sort(sorted.begin(), sorted.end());
    if (sorted.front() < 0 || static_cast<std::size_t>(sorted.back()) >= cage.positions.size())
      fail("face " + std::to_string(f) + " names a vertex that is not there");
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
      fail("face " + std::to_string(f) + " visits a vertex twice");
    corner += static_cast<std::size_t>(size);
  }
  if (corner != cage.face_indices.size()) fail("face_sizes and face_indices do not match");
}

void check_creases(const SubdivisionCage& cage) {
  if (cage.crease_edges.size() != cage.crease_sharpness.size())
    fail("has " + std::to_string(cage.crease_edges.size()) + " crease edges but " +
         std::to_string(cage.crease_sharpness.size()) + " sharpnesses");
  if (cage.crease_edges.empty()) return;
  std::set<std::array<int, 2>> edges;
  for (std::size_t f = 0, first = 0; f < cage.face_sizes.size(); ++f) {
    const auto size = static_cast<std::size_t>(cage.face_sizes[f]);
    for (std::size_t i = 0; i < size; ++i) {
      const int a = cage.face_indices[first + i], b = cage.face_indices[first + (i + 1) % size];
      edges.insert({std::min(a, b), std::max(a, b)});
    }
    first += size;
  }
  for (std::size_t i = 0; i < cage.crease_edges.size(); ++i) {
    const auto& [a, b] = cage.crease_edges[i];
    if (!edges.contains({std::min(a, b), std::max(a, b)}))
      fail("crease " + std::to_string(a) + "-" + std::to_string(b) + " is not an edge");
    if (!(cage.crease_sharpness[i] >= 0.0f)) fail("crease " + std::to_string(i) + " has no sharpness of 0 or more");
  }
}

}  // namespace

void check_cage(const SubdivisionCage& cage) {
  if (cage.positions.empty() || cage.face_sizes.empty()) fail("is empty");
  if (cage.levels < 1 || cage.levels > kMaxSubdivisionLevels)
    fail("asks for " + std::to_string(cage.levels) + " levels, 1 to " + std::to_string(kMaxSubdivisionLevels) +
         " are possible");
  if (!cage.uvs.empty() && cage.uvs.size() != cage.positions.size())
    fail("has " + std::to_string(cage.uvs.size()) + " UVs for " + std::to_string(cage.positions.size()) + " vertices");
  for (std::size_t i = 0; i < cage.positions.size(); ++i) {
    const glm::vec3& p = cage.positions[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      fail("vertex " + std::to_string(i) + " is not finite");
  }
  check_faces(cage);
  check_creases(cage);
  if (static_cast<double>(cage.face_indices.size()) * std::pow(4.0, cage.levels - 1) > kMaxLimitQuads)
    fail("would become more than " + std::to_string(static_cast<int>(kMaxLimitQuads)) + " quads at " +
         std::to_string(cage.levels) + " levels");
}

std::size_t count_limit_indices(const SubdivisionCage& cage) {
  // The first refinement splits each face into a quad per corner, each further one a quad into four.
  return 6 * cage.face_indices.size() * (std::size_t{1} << 2 * (cage.levels - 1));
}

void tessellate_cage(Mesh* mesh) {
  assert(mesh->cage != nullptr);
  const SubdivisionEvaluator evaluator(*mesh->cage);
  if (mesh->primitives.empty()) mesh->primitives.emplace_back();
  Primitive& out = mesh->primitives[0];
  evaluator.evaluate(mesh->cage->positions, &out.positions, &out.normals);
  out.indices = evaluator.indices();
  out.uvs = {evaluator.uvs(), {}};
  out.tangents.clear();
  out.colors.clear();
}

int dent_cage(SubdivisionCage* cage, const glm::vec3& center, const glm::vec3& direction, float depth_m,
              float radius_m) {
  const float length = glm::length(direction);
  if (!(length > 0.0f) || !(radius_m > 0.0f)) return 0;
  const glm::vec3 step = direction * (depth_m / length);
  int moved = 0;
  for (glm::vec3& point : cage->positions) {
    const float distance = glm::distance(point, center) / radius_m;
    if (!(distance < 1.0f)) continue;
    const float inside = 1.0f - distance * distance;  // (1 - r^2)^3: value, slope and curvature vanish at r = 1
    point += step * (inside * inside * inside);
    ++moved;
  }
  return moved;
}

}  // namespace maquette
