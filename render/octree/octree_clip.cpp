#include "render/octree/octree_clip.h"

#include <cassert>

namespace maquette {

namespace {

/// Pieces below this area (of a finest cell's face) are rounding errors.
constexpr double kMinArea = 1e-10;

void append(ClipPolygon* polygon, const glm::dvec3& corner) {
  assert(polygon->count < ClipPolygon::kMaxCorners);
  if (polygon->count < ClipPolygon::kMaxCorners) polygon->corners[polygon->count++] = corner;
}

}  // namespace

void split_polygon(const ClipPolygon& polygon, int axis, double value, ClipPolygon* below, ClipPolygon* above) {
  below->count = above->count = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const glm::dvec3& a = polygon.corners[i];
    const glm::dvec3& b = polygon.corners[i + 1 < polygon.count ? i + 1 : 0];
    const bool a_above = a[axis] >= value;
    const bool b_above = b[axis] >= value;
    append(a_above ? above : below, a);
    if (a_above == b_above) continue;
    // Always interpolates from the same end, so that neighbours get exactly the same point on their common edge.
    const glm::dvec3& from = a_above ? b : a;
    const glm::dvec3& to = a_above ? a : b;
    glm::dvec3 cut = from + (to - from) * ((value - from[axis]) / (to[axis] - from[axis]));
    cut[axis] = value;
    append(below, cut);
    if (!(a_above && a == cut) && !(b_above && b == cut)) append(above, cut);
  }
  if (below->count < 3) below->count = 0;
  if (above->count < 3) above->count = 0;
}

glm::dvec3 polygon_area_vector(const ClipPolygon& polygon) {
  glm::dvec3 sum(0.0);
  for (int i = 2; i < polygon.count; ++i)
    sum += glm::cross(polygon.corners[i - 1] - polygon.corners[0], polygon.corners[i] - polygon.corners[0]);
  return 0.5 * sum;
}

glm::dvec3 polygon_centroid(const ClipPolygon& polygon) {
  const glm::dvec3 whole = polygon_area_vector(polygon);
  const double square = glm::dot(whole, whole);
  glm::dvec3 sum(0.0), mean(0.0);
  double weight = 0.0;
  for (int i = 0; i < polygon.count; ++i) mean += polygon.corners[i];
  mean /= static_cast<double>(polygon.count);
  if (!(square > 0.0)) return mean;
  for (int i = 2; i < polygon.count; ++i) {
    const double w = glm::dot(
        glm::cross(polygon.corners[i - 1] - polygon.corners[0], polygon.corners[i] - polygon.corners[0]), whole);
    sum += w * (polygon.corners[0] + polygon.corners[i - 1] + polygon.corners[i]);
    weight += w;
  }
  return weight > 0.0 ? sum / (3.0 * weight) : mean;
}

double plane_section_area(const glm::dvec3& normal, const glm::dvec3& point, const glm::dvec3& lower, double size) {
  const glm::dvec3 steep = glm::abs(normal);
  const int axis = steep.x > steep.y ? (steep.x > steep.z ? 0 : 2) : (steep.y > steep.z ? 1 : 2);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  // The plane's polygon over the face that it is most parallel to, clipped at both ends of the cube.
  ClipPolygon section, above, inside, scratch;
  section.count = 4;
  for (int k = 0; k < 4; ++k) {
    glm::dvec3& corner = section.corners[k];
    corner[u] = lower[u] + (k == 1 || k == 2 ? size : 0.0);
    corner[v] = lower[v] + (k >= 2 ? size : 0.0);
    corner[axis] =
        point[axis] - (normal[u] * (corner[u] - point[u]) + normal[v] * (corner[v] - point[v])) / normal[axis];
  }
  split_polygon(section, axis, lower[axis], &scratch, &above);
  split_polygon(above, axis, lower[axis] + size, &inside, &scratch);
  return glm::length(polygon_area_vector(inside));
}

void CellClipper::clip(const ClipPolygon& polygon, const glm::ivec3& lower, int level) const {
  ClipPolygon inside = polygon, scratch;
  const int size = 1 << (depth_ - level);
  for (int axis = 0; axis < 3; ++axis) {
    ClipPolygon rest;
    split_polygon(inside, axis, lower[axis], &scratch, &rest);
    split_polygon(rest, axis, lower[axis] + size, &inside, &scratch);
    if (inside.count == 0) return;
  }
  descend(inside, lower, level);
}

void CellClipper::descend(const ClipPolygon& polygon, const glm::ivec3& lower, int level) const {
  if (is_leaf_(lower, level)) {
    const glm::dvec3 area = polygon_area_vector(polygon);
    if (glm::dot(area, area) > kMinArea * kMinArea) emit_({lower, level, &polygon});
    return;
  }
  descend_axis(polygon, lower, level, 0);
}

void CellClipper::descend_axis(const ClipPolygon& polygon, const glm::ivec3& lower, int level, int axis) const {
  if (axis == 3) return descend(polygon, lower, level + 1);
  const int half = 1 << (depth_ - level - 1);
  const double middle = lower[axis] + half;
  double low = polygon.corners[0][axis], high = low;
  for (int i = 1; i < polygon.count; ++i) {
    low = glm::min(low, polygon.corners[i][axis]);
    high = glm::max(high, polygon.corners[i][axis]);
  }
  glm::ivec3 upper = lower;
  upper[axis] += half;
  // Corners on the upper bound of the cell belong to the neighbour, which has its own piece.
  if (low >= middle) return descend_axis(polygon, upper, level, axis + 1);
  if (high <= middle) return descend_axis(polygon, lower, level, axis + 1);
  ClipPolygon below, above;
  split_polygon(polygon, axis, middle, &below, &above);
  if (below.count > 0) descend_axis(below, lower, level, axis + 1);
  if (above.count > 0) descend_axis(above, upper, level, axis + 1);
}

}  // namespace maquette
