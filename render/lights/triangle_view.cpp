#include "render/lights/triangle_view.h"

#include <algorithm>
#include <cmath>

namespace maquette {

namespace {

/// Rounding error of each coordinate of a triangle's point, relative to the corners' largest: seven half units for the
/// sum over them (Pharr et al. 2023, "Physically Based Rendering", 4th ed., Sec. 6.8.5), two for the edges.
constexpr double kPointError = 9.0 * 0x1p-24;

}  // namespace

/// Source of the solid angle: van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle", Eq. 8. The triple
/// product uses the edges, because the vectors to the corners of a small triangle agree in most digits.
TriangleView::TriangleView(const LightRecord& light, const glm::vec3& point) {
  const glm::dvec3 edge_b(light.direction), edge_c(light.edge2);
  const glm::dvec3 to_a = glm::dvec3(light.position) - glm::dvec3(point);
  const glm::dvec3 to_b = to_a + edge_b, to_c = to_a + edge_c;
  distances_m_ = {glm::length(to_a), glm::length(to_b), glm::length(to_c)};
  const double product = distances_m_.x * distances_m_.y * distances_m_.z;
  const glm::dvec3 doubled = glm::cross(edge_b, edge_c);
  const double away = glm::dot(doubled, to_a);  // negative in front
  const bool both_sides = light.range_m > 0.0f;
  if (!(product > 0.0) || !(both_sides ? std::abs(away) > 0.0 : away < 0.0)) return;
  // The lamp's own points lie in its plane except for rounding, and do not see it; nor do points of a face on its back.
  const glm::dvec3 corner(light.position);
  const glm::dvec3 largest = glm::max(glm::abs(corner), glm::max(glm::abs(corner + edge_b), glm::abs(corner + edge_c)));
  if (std::abs(away) <= kPointError * glm::dot(glm::abs(doubled), largest)) return;
  a_ = to_a / distances_m_.x;
  b_ = to_b / distances_m_.y;
  c_ = to_c / distances_m_.z;
  volume_ = std::abs(away) / product;
  half_sr_ = std::atan2(volume_, 1.0 + glm::dot(a_, b_) + glm::dot(b_, c_) + glm::dot(c_, a_));
}

/// u.x moves a corner along the edge from a to c, so that the triangle between a, b and the moved corner has that share
/// of the solid angle; u.y is a height along the arc from b to the moved corner. Directions are computed as weights of
/// the directions to the corners, none of them negative.
TriangleView::Sample TriangleView::sample(const glm::vec2& u) const {
  const double ab = glm::dot(a_, b_), bc = glm::dot(b_, c_), ca = glm::dot(c_, a_);
  // The direction half way from a to the moved corner is p a + q c, not normalised.
  const double part = static_cast<double>(u.x) * half_sr_, sine = std::sin(part);
  const double p = std::max(volume_ * std::cos(part) - (bc + ca) * sine, 0.0), q = (1.0 + ab) * sine;
  const double square = p * p + q * q + 2.0 * p * q * ca;
  double of_a = 1.0, of_c = 0.0;
  if (square > 0.0) {
    of_a = std::max((p - q) * (p + q) / square, 0.0);
    of_c = std::max(2.0 * q * (p + q * ca) / square, 0.0);
  }
  const double cosine = std::clamp(of_a * ab + of_c * bc, -1.0, 1.0);
  const double height = 1.0 - static_cast<double>(u.y) * (1.0 - cosine);
  const double along = std::sqrt(static_cast<double>(u.y) * (1.0 + height) / std::max(1.0 + cosine, 1e-15));
  const glm::dvec3 weights(along * of_a, std::max(height - along * cosine, 0.0), along * of_c);
  const glm::dvec3 wi = a_ * weights.x + b_ * weights.y + c_ * weights.z;
  // A corner's weight over its distance is its barycentric share (not normalised) of the hit point.
  const glm::dvec3 shares = weights / distances_m_;
  const double sum = shares.x + shares.y + shares.z, length = glm::length(wi);
  return {glm::vec3(wi / length), static_cast<float>(length / sum), glm::vec2(shares.y / sum, shares.z / sum)};
}

}  // namespace maquette
