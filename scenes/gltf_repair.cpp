#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "scenes/gltf_primitive.h"

namespace maquette::gltf {
namespace {

/// Above this, squares of lengths exceed float's range.
constexpr float kMaxCoordinate_m = 1e12f;

bool is_usable(const glm::vec3& p) {
  return std::abs(p.x) <= kMaxCoordinate_m && std::abs(p.y) <= kMaxCoordinate_m && std::abs(p.z) <= kMaxCoordinate_m;
}

template <typename Vector>
bool all_finite(const Vector& v) {
  for (int c = 0; c < v.length(); ++c)
    if (!std::isfinite(v[c])) return false;
  return true;
}

template <typename Vector>
std::size_t replace_non_finite(std::vector<Vector>* values, const Vector& by) {
  std::size_t count = 0;
  for (Vector& value : *values) {
    if (all_finite(value)) continue;
    value = by;
    ++count;
  }
  return count;
}

/// Removes triangles at vertices that are NaN, infinite or out of range, and moves those vertices to a valid one.
void repair_positions(PrimitiveTask* task) {
  Primitive& primitive = task->out;
  std::vector<char> bad(primitive.positions.size(), 0);
  std::size_t bad_count = 0;
  for (std::size_t i = 0; i < bad.size(); ++i)
    bad_count += static_cast<std::size_t>(bad[i] = !is_usable(primitive.positions[i]));
  if (bad_count == 0) return;
  task->warnings.add("positions are not finite or beyond 1e12 m: their triangles are dropped", task->name());
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
    const std::uint32_t* t = &primitive.indices[i];
    if (!bad[t[0]] && !bad[t[1]] && !bad[t[2]]) kept.insert(kept.end(), t, t + 3);
  }
  primitive.indices = std::move(kept);
  const auto first_valid = std::find(bad.begin(), bad.end(), 0);
  if (first_valid == bad.end()) {
    task->drawable = false;
    return;
  }
  const glm::vec3 replacement = primitive.positions[static_cast<std::size_t>(first_valid - bad.begin())];
  for (std::size_t i = 0; i < bad.size(); ++i)
    if (bad[i]) primitive.positions[i] = replacement;
}

/// Splits vertices by the normals of their triangles.
class FlatNormals {
 public:
  explicit FlatNormals(Primitive* primitive)
      : primitive_(*primitive),
        newest_(primitive->positions.size(), kNone),
        older_(primitive->positions.size(), kNone) {
    primitive_.tangents.clear();
    primitive_.normals.assign(primitive_.positions.size(), glm::vec3(0.0f));
  }

  void run() {
    for (std::size_t i = 0; i + 2 < primitive_.indices.size(); i += 3) {
      std::uint32_t* t = &primitive_.indices[i];
      const glm::dvec3 a(primitive_.positions[t[0]]), b(primitive_.positions[t[1]]), c(primitive_.positions[t[2]]);
      const glm::dvec3 cross = glm::cross(b - a, c - a);
      const double length = glm::length(cross);
      if (!(length > 0.0)) continue;
      const glm::vec3 normal(cross / length);
      for (int corner = 0; corner < 3; ++corner) t[corner] = vertex_with(t[corner], normal);
    }
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  /// Copies of a vertex that are compared: neighbouring triangles come close to each other, and the tip of a cone has
  /// thousands.
  static constexpr int kCompared = 8;
  static constexpr float kSame = 1e-6f;

  std::uint32_t vertex_with(std::uint32_t vertex, const glm::vec3& normal) {
    if (newest_[vertex] == kNone) {
      primitive_.normals[vertex] = normal;
      return newest_[vertex] = vertex;
    }
    std::uint32_t copy = newest_[vertex];
    for (int i = 0; i < kCompared && copy != kNone; ++i, copy = older_[copy])
      if (glm::distance(primitive_.normals[copy], normal) <= kSame) return copy;
    copy = add_copy(vertex, normal);
    older_[copy] = newest_[vertex];
    return newest_[vertex] = copy;
  }

  std::uint32_t add_copy(std::uint32_t vertex, const glm::vec3& normal) {
    const std::size_t index = primitive_.positions.size();
    if (index >= kNone) throw std::length_error("too many vertices");
    primitive_.positions.push_back(primitive_.positions[vertex]);
    primitive_.normals.push_back(normal);
    for (auto& uvs : primitive_.uvs)
      if (!uvs.empty()) uvs.push_back(uvs[vertex]);
    if (!primitive_.colors.empty()) primitive_.colors.push_back(primitive_.colors[vertex]);
    older_.push_back(kNone);
    return static_cast<std::uint32_t>(index);
  }

  Primitive& primitive_;
  std::vector<std::uint32_t> newest_;  ///< of each vertex of the file: its newest copy
  std::vector<std::uint32_t> older_;   ///< of each copy: the one before
};

}  // namespace

void repair_primitive(PrimitiveTask* task) {
  repair_positions(task);
  Primitive& primitive = task->out;
  std::size_t replaced = replace_non_finite(&primitive.normals, glm::vec3(0.0f));
  replaced += replace_non_finite(&primitive.tangents, glm::vec4(0.0f));
  for (auto& uvs : primitive.uvs) replaced += replace_non_finite(&uvs, glm::vec2(0.0f));
  replaced += replace_non_finite(&primitive.colors, glm::vec4(1.0f));
  if (replaced > 0) task->warnings.add("attributes that are not finite are replaced", task->name());

  std::size_t degenerate = 0;
  for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
    const std::uint32_t* t = &primitive.indices[i];
    const glm::dvec3 a(primitive.positions[t[0]]), b(primitive.positions[t[1]]), c(primitive.positions[t[2]]);
    if (glm::cross(b - a, c - a) == glm::dvec3(0.0)) ++degenerate;
  }
  if (degenerate > 0) task->warnings.add("triangles of zero area are never seen", task->name());
}

void add_flat_normals(Primitive* primitive) { FlatNormals(primitive).run(); }

}  // namespace maquette::gltf
