#include "scenes/subject_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maquette {

namespace {

/// Pieces that reach this many times as far as all others are not what a scene is about,
constexpr float kFar = 12.0f;
/// where they are at most this share of the pieces, or one.
constexpr double kFew = 0.1;
/// The same within a piece: a triangle, or this share of its vertices.
constexpr double kFewVertices = 0.01;

void include_point(Bounds* bounds, const glm::vec3& p) {
  bounds->min = glm::min(bounds->min, p);
  bounds->max = glm::max(bounds->max, p);
}

/// The median of each coordinate.
glm::vec3 median(const std::vector<glm::vec3>& points) {
  glm::vec3 middle(0.0f);
  std::vector<float> values(points.size());
  for (int c = 0; c < 3; ++c) {
    std::ranges::transform(points, values.begin(), [c](const glm::vec3& p) { return p[c]; });
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, at);
    middle[c] = *at;
  }
  return middle;
}

/// How far those reach that are not far: the least value after which one follows that is `kFar` times as large, if at
/// most `few` follow; infinity without one.
float usual_reach(std::vector<float> reaches, std::size_t few) {
  // Only the farthest are looked at, and the one before them.
  const std::size_t first = reaches.size() - std::min(few + 1, reaches.size());
  std::ranges::nth_element(reaches, reaches.begin() + static_cast<std::ptrdiff_t>(first));
  std::sort(reaches.begin() + static_cast<std::ptrdiff_t>(first), reaches.end());
  for (std::size_t i = first + 1; i < reaches.size(); ++i)
    if (reaches[i - 1] > 0.0f && reaches[i] > kFar * reaches[i - 1]) return reaches[i - 1];
  return std::numeric_limits<float>::infinity();
}

float reach_of(const Bounds& box, const glm::vec3& from) {
  const glm::vec3 d = glm::max(glm::abs(box.min - from), glm::abs(box.max - from));
  return std::max({d.x, d.y, d.z});
}

struct Piece {
  Bounds box;
  std::size_t vertices = 0;
};

/// Without a few vertices that are far from the others.
Piece piece_of(const std::vector<glm::vec3>& points) {
  const auto few =
      std::max<std::size_t>(3, static_cast<std::size_t>(kFewVertices * static_cast<double>(points.size())));
  Piece piece{{}, points.size()};
  float reach = std::numeric_limits<float>::infinity();
  const glm::vec3 middle = median(points);
  if (points.size() > 2 * few) {
    std::vector<float> reaches;
    for (const glm::vec3& p : points) reaches.push_back(reach_of({p, p}, middle));
    reach = usual_reach(std::move(reaches), few);
  }
  for (const glm::vec3& p : points)
    if (reach_of({p, p}, middle) <= reach) include_point(&piece.box, p);
  return piece;
}

std::vector<Piece> pieces_of(const Scene& scene) {
  std::vector<Piece> pieces;
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  std::vector<glm::vec3> points;
  const auto add = [&](const glm::mat4& world_from_node, const auto& positions) {
    points.clear();
    for (const glm::vec3& p : positions) {
      const glm::vec3 q(world_from_node * glm::vec4(p, 1.0f));
      if (std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z)) points.push_back(q);
    }
    if (!points.empty()) pieces.push_back(piece_of(points));
  };
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (!node.visible) continue;
    if (node.mesh >= 0)
      for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives)
        add(world[i], primitive.positions);
    if (node.patch >= 0) add(world[i], scene.patches[static_cast<std::size_t>(node.patch)].points);
  }
  return pieces;
}

/// The median of the pieces' middles, each counted as often as the root of its number of vertices: neither a stray
/// triangle beside one body decides it, nor a finely divided dome.
glm::vec3 middle_of(const std::vector<Piece>& pieces) {
  std::vector<glm::vec3> middles;
  for (const Piece& piece : pieces) {
    const auto times = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(piece.vertices))));
    middles.insert(middles.end(), std::min<std::size_t>(times, 1000), piece.box.center());
  }
  return median(middles);
}

}  // namespace

Bounds subject_bounds(const Scene& scene) {
  const std::vector<Piece> pieces = pieces_of(scene);
  if (pieces.empty()) return {};
  const glm::vec3 middle = middle_of(pieces);
  std::vector<float> reaches;
  for (const Piece& piece : pieces) reaches.push_back(reach_of(piece.box, middle));
  const auto few = std::max<std::size_t>(1, static_cast<std::size_t>(kFew * static_cast<double>(pieces.size())));
  const float reach = usual_reach(reaches, few);
  Bounds bounds;
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (reaches[i] <= reach) {
      include_point(&bounds, pieces[i].box.min);
      include_point(&bounds, pieces[i].box.max);
    }
  return bounds;
}

}  // namespace maquette
