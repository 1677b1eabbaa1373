#include "review/spline.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace maquette {

namespace {

/// Rotation that takes the axes x, y, -z to the view's right, up and forward.
glm::dquat orientation(const CameraView& view) {
  const glm::dvec3 forward = glm::normalize(glm::dvec3(view.target) - glm::dvec3(view.eye));
  glm::dvec3 right = glm::cross(forward, glm::dvec3(view.up));
  if (glm::dot(right, right) < 1e-16)
    right = glm::cross(forward, std::abs(forward.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1));
  right = glm::normalize(right);
  return glm::normalize(glm::quat_cast(glm::dmat3(right, glm::cross(right, forward), -forward)));
}

/// Along the great arc, also beyond its ends: t may be below 0 and above 1.
glm::dquat arc(const glm::dquat& a, const glm::dquat& b, double t) {
  const double cosine = std::clamp(glm::dot(a, b), -1.0, 1.0), angle = std::acos(cosine);
  if (angle < 1e-7) return glm::normalize(a * (1.0 - t) + b * t);
  return glm::normalize((a * std::sin((1.0 - t) * angle) + b * std::sin(t * angle)) / std::sin(angle));
}

glm::dvec3 line(const glm::dvec3& a, const glm::dvec3& b, double t) { return a + (b - a) * t; }

double distance_of(const glm::dvec3& a, const glm::dvec3& b) { return glm::distance(a, b); }
double distance_of(const glm::dquat& a, const glm::dquat& b) {
  return std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
}
glm::dvec3 mix_of(const glm::dvec3& a, const glm::dvec3& b, double t) { return line(a, b, t); }
glm::dquat mix_of(const glm::dquat& a, const glm::dquat& b, double t) { return arc(a, b, t); }

/// Barry and Goldman 1988: Catmull-Rom as a pyramid of mixtures. Knots are the square roots of the distances; where
/// neighbours coincide the curve rests.
template <typename T>
T catmull_rom(const std::array<T, 4>& p, double t) {
  std::array<double, 4> knots{};
  for (std::size_t i = 1; i < 4; ++i) knots[i] = knots[i - 1] + std::sqrt(distance_of(p[i - 1], p[i]));
  const double whole = knots[2] - knots[1];
  if (!(whole > 1e-9)) return mix_of(p[1], p[2], t);
  const double x = knots[1] + t * whole;
  const auto mix = [&](const T& a, const T& b, std::size_t i, std::size_t j) {
    const double span = knots[j] - knots[i];
    return span > 1e-9 ? mix_of(a, b, (x - knots[i]) / span) : b;
  };
  const bool first = knots[1] - knots[0] > 1e-9, last = knots[3] - knots[2] > 1e-9;
  const T middle = mix(p[1], p[2], 1, 2);
  const T low = first ? mix(mix(p[0], p[1], 0, 1), middle, 0, 2) : middle;
  const T high = last ? mix(middle, mix(p[2], p[3], 2, 3), 1, 3) : middle;
  return mix(low, high, 1, 2);
}

/// Both positive, or one of them.
double geometric(double a, double b, double t) {
  return a > 0.0 && b > 0.0 ? std::exp(std::log(a) + t * (std::log(b) - std::log(a))) : a + t * (b - a);
}

double target_distance(const CameraView& view) { return glm::distance(glm::dvec3(view.eye), glm::dvec3(view.target)); }

}  // namespace

double angle_between(const CameraView& a, const CameraView& b) {
  return 2.0 * std::acos(std::clamp(std::abs(glm::dot(orientation(a), orientation(b))), 0.0, 1.0));
}

CameraView between_views(const std::array<const CameraView*, 4>& views, double t) {
  const CameraView &from = *views[1], &to = *views[2];
  if (t <= 0.0) return from;
  if (t >= 1.0) return to;
  std::array<glm::dvec3, 4> eyes{};
  std::array<glm::dquat, 4> turns{};
  for (std::size_t i = 0; i < 4; ++i) {
    const CameraView& view = views[i] ? *views[i] : i == 0 ? from : to;
    eyes[i] = glm::dvec3(view.eye);
    turns[i] = orientation(view);
  }
  // q and -q are the same orientation: signs for the short way, from the middle outwards.
  if (glm::dot(turns[1], turns[2]) < 0.0) turns[2] = -turns[2];
  if (glm::dot(turns[0], turns[1]) < 0.0) turns[0] = -turns[0];
  if (glm::dot(turns[2], turns[3]) < 0.0) turns[3] = -turns[3];
  CameraView view = from;  // near, far and aspect stay those of the key that is left
  const glm::dvec3 eye = catmull_rom(eyes, t);
  const glm::dquat turn = catmull_rom(turns, t);
  view.eye = glm::vec3(eye);
  view.target =
      glm::vec3(eye + turn * glm::dvec3(0.0, 0.0, -1.0) * geometric(target_distance(from), target_distance(to), t));
  view.up = glm::vec3(turn * glm::dvec3(0.0, 1.0, 0.0));
  view.fov_y_rad =
      static_cast<float>(geometric(static_cast<double>(from.fov_y_rad), static_cast<double>(to.fov_y_rad), t));
  if (from.is_orthographic() == to.is_orthographic())
    view.height_m =
        static_cast<float>(geometric(static_cast<double>(from.height_m), static_cast<double>(to.height_m), t));
  return view;
}

}  // namespace maquette
