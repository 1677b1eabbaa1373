#include "render/scene_state/enclosure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "scenes/subject_bounds.h"

namespace maquette {

namespace {

constexpr int kSide = 16;
constexpr double kEnclosedShare = 0.5;
/// The eye is inside a solid when fewer than this share of the visible faces are front faces. Models of cars show many
/// back faces to an eye inside them.
constexpr double kFrontShare = 0.1;

/// Nearest hit per direction of a cube around the eye.
struct Coverage {
  std::array<float, 6 * kSide * kSide> distance;
  std::array<bool, 6 * kSide * kSide> front{};
  Coverage() { distance.fill(std::numeric_limits<float>::infinity()); }
};

struct Triangle {
  std::array<glm::vec3, 3> corners{};  ///< relative to the eye
  bool double_sided;
};

/// Direction of the cell (column, row) of `face`: axis face / 2, positive for even faces; scaled so that the largest
/// component is 1.
glm::vec3 cell_direction(int face, float column, float row) {
  const float u = 2.0f * column / static_cast<float>(kSide) - 1.0f;
  const float v = 2.0f * row / static_cast<float>(kSide) - 1.0f;
  glm::vec3 d{};
  d[face / 2] = face % 2 == 0 ? 1.0f : -1.0f;
  d[(face / 2 + 1) % 3] = u;
  d[(face / 2 + 2) % 3] = v;
  return d;
}

struct CellRange {
  int begin[2] = {0, 0};
  int end[2] = {kSide, kSide};
};

/// Cells of `face` whose centre ray may hit the triangle with bounds `low`, `high`; empty when it lies outside the
/// face.
CellRange cell_range(const Triangle& triangle, const glm::vec3& low, const glm::vec3& high, int face) {
  constexpr CellRange kNone{{0, 0}, {0, 0}};
  CellRange range;
  const int axis = face / 2;
  const float sign = face % 2 == 0 ? 1.0f : -1.0f;
  const float nearest = face % 2 == 0 ? low[axis] : -high[axis];
  const float farthest = face % 2 == 0 ? high[axis] : -low[axis];
  if (farthest <= 0.0f) return kNone;
  for (int k = 0; k < 2; ++k) {
    const int side = (axis + 1 + k) % 3;
    if (low[side] > farthest || high[side] < -farthest) return kNone;  // outside the pyramid of the face
  }
  if (nearest <= 0.0f) return range;  // crosses the plane of the eye: every cell may hit it
  for (int k = 0; k < 2; ++k) {
    float first = std::numeric_limits<float>::max(), last = -first;
    for (const glm::vec3& p : triangle.corners) {
      const float t = p[(axis + 1 + k) % 3] / (sign * p[axis]);
      first = std::min(first, t);
      last = std::max(last, t);
    }
    const auto cell = [](float t) {
      return std::clamp(0.5f * (t + 1.0f), -1.0f, 2.0f) * static_cast<float>(kSide) - 0.5f;
    };
    range.begin[k] = std::max(0, static_cast<int>(std::ceil(cell(first) - 1e-3f)));
    range.end[k] = std::min(kSide, static_cast<int>(std::floor(cell(last) + 1e-3f)) + 1);
  }
  return range;
}

/// Updates the nearest hit of every direction that meets the triangle: a direction is inside when it lies on the same
/// side of the three planes through the eye and an edge.
void cover(const Triangle& triangle, Coverage* coverage) {
  const auto& [a, b, c] = triangle.corners;
  const glm::vec3 normal = glm::cross(b - a, c - a);
  const float offset = glm::dot(normal, a);  // < 0: the eye is on the front side
  if (offset == 0.0f || !std::isfinite(offset)) return;
  const bool front = offset < 0.0f || triangle.double_sided;
  const glm::vec3 low = glm::min(a, glm::min(b, c)), high = glm::max(a, glm::max(b, c));
  for (int face = 0; face < 6; ++face) {
    const CellRange range = cell_range(triangle, low, high, face);
    if (range.begin[0] >= range.end[0] || range.begin[1] >= range.end[1]) continue;
    const std::array<glm::vec3, 3> planes = {glm::cross(a, b), glm::cross(b, c), glm::cross(c, a)};
    for (int row = range.begin[1]; row < range.end[1]; ++row) {
      for (int column = range.begin[0]; column < range.end[0]; ++column) {
        const glm::vec3 d = cell_direction(face, static_cast<float>(column) + 0.5f, static_cast<float>(row) + 0.5f);
        const float s0 = glm::dot(d, planes[0]), s1 = glm::dot(d, planes[1]), s2 = glm::dot(d, planes[2]);
        if (!((s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0))) continue;
        const float t = offset / glm::dot(normal, d);
        const auto cell = static_cast<std::size_t>((face * kSide + row) * kSide + column);
        if (!(t > 0.0f) || t >= coverage->distance[cell]) continue;
        coverage->distance[cell] = t;
        coverage->front[cell] = front;
      }
    }
  }
}

const Material& material_at(const Scene& scene, int index) {
  static const Material kDefault;
  return index >= 0 && index < static_cast<int>(scene.materials.size())
             ? scene.materials[static_cast<std::size_t>(index)]
             : kDefault;
}

void cover(const Primitive& primitive, const Material& material, const glm::mat4& world_from_node, const glm::vec3& eye,
           Coverage* coverage) {
  if (material.glass || material.alpha_mode == AlphaMode::blend) return;
  std::vector<glm::vec3> points(primitive.positions.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = glm::vec3(world_from_node * glm::vec4(primitive.positions[i], 1.0f)) - eye;
  const bool mirrored = glm::determinant(glm::mat3(world_from_node)) < 0.0f;
  for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
    Triangle triangle{
        {points[primitive.indices[i]], points[primitive.indices[i + 1]], points[primitive.indices[i + 2]]},
        material.double_sided};
    if (mirrored) std::swap(triangle.corners[1], triangle.corners[2]);
    cover(triangle, coverage);
  }
}

/// The 3 x 3 quads of the patch's control net, accurate enough for coverage.
Primitive control_net(const BezierPatch& patch) {
  Primitive net;
  net.positions.assign(patch.points.begin(), patch.points.end());
  for (std::uint32_t row = 0; row < 3; ++row) {
    for (std::uint32_t column = 0; column < 3; ++column) {
      const std::uint32_t i = 4 * row + column;
      net.indices.insert(net.indices.end(), {i, i + 1, i + 4, i + 4, i + 1, i + 5});
    }
  }
  return net;
}

/// Solid angle of a cube cell up to a factor. Source: the Jacobian of central projection, (1 + u^2 + v^2)^-3/2.
double cell_weight(const glm::vec3& direction) {
  return std::pow(static_cast<double>(glm::dot(direction, direction)), -1.5);
}

}  // namespace

double covered_share(const Scene& scene, int variant, const glm::vec3& eye) {
  Coverage coverage;
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (!node.visible) continue;
    if (node.mesh >= 0) {
      for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives)
        cover(primitive, material_at(scene, material_of(primitive, variant)), world[i], eye, &coverage);
    }
    if (node.patch >= 0) {
      const BezierPatch& patch = scene.patches[static_cast<std::size_t>(node.patch)];
      const Material& material = material_at(scene, patch.material);
      if (!material.glass && material.alpha_mode != AlphaMode::blend)
        cover(control_net(patch), material, world[i], eye, &coverage);
    }
  }
  double above = 0.0, covered_above = 0.0, covered = 0.0, front = 0.0;
  for (std::size_t cell = 0; cell < coverage.distance.size(); ++cell) {
    const int row = static_cast<int>(cell) / kSide % kSide, column = static_cast<int>(cell) % kSide;
    const glm::vec3 d = cell_direction(static_cast<int>(cell) / (kSide * kSide), static_cast<float>(column) + 0.5f,
                                       static_cast<float>(row) + 0.5f);
    const double weight = cell_weight(d);
    const bool hit = std::isfinite(coverage.distance[cell]);
    if (hit) covered += weight;
    if (hit && coverage.front[cell]) front += weight;
    if (d.y <= 0.0f) continue;
    above += weight;
    if (hit) covered_above += weight;
  }
  return front < kFrontShare * covered ? 0.0 : covered_above / above;
}

bool is_enclosed(const Scene& scene, int variant) {
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].camera < 0) continue;
    if (covered_share(scene, variant, glm::vec3(world[i][3])) > kEnclosedShare) return true;
    break;
  }
  const Bounds bounds = subject_bounds(scene);
  return !bounds.empty() && covered_share(scene, variant, bounds.center()) > kEnclosedShare;
}

}  // namespace maquette
