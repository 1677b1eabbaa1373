#include "scenes/animation.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "scenes/scene.h"

namespace maquette {

namespace {

/// The short way round; of nearly equal ones the straight line, where the arc's sine is no divisor.
glm::dvec4 slerp(const glm::dvec4& a, glm::dvec4 b, double t) {
  double cosine = glm::dot(a, b);
  if (cosine < 0.0) {
    b = -b;
    cosine = -cosine;
  }
  constexpr double kStraight = 1.0 - 1e-9;
  if (cosine > kStraight) return glm::normalize(a + t * (b - a));
  const double angle = std::acos(cosine);
  return (std::sin((1.0 - t) * angle) * a + std::sin(t * angle) * b) / std::sin(angle);
}

glm::dvec4 unit(const glm::dvec4& q) {
  const double length = glm::length(q);
  return length > 0.0 ? q / length : glm::dvec4(0.0, 0.0, 0.0, 1.0);
}

}  // namespace

glm::vec4 value_at(const AnimationTrack& track, bool is_rotation, double time_s) {
  using Interpolation = AnimationTrack::Interpolation;
  const bool cubic = track.interpolation == Interpolation::cubic;
  const std::size_t stride = cubic ? 3 : 1, last = track.times_s.size() - 1;
  const auto key = [&](std::size_t i) { return glm::dvec4(track.values[stride * i + (cubic ? 1 : 0)]); };
  const auto finished = [&](const glm::dvec4& v) { return glm::vec4(is_rotation ? unit(v) : v); };
  const auto after =
      std::ranges::upper_bound(track.times_s, time_s, {}, [](float t) { return static_cast<double>(t); });
  if (after == track.times_s.begin()) return finished(key(0));
  if (after == track.times_s.end()) return finished(key(last));
  const auto right = static_cast<std::size_t>(after - track.times_s.begin()), left = right - 1;
  if (track.interpolation == Interpolation::step) return finished(key(left));
  const double begin_s = static_cast<double>(track.times_s[left]),
               interval_s = static_cast<double>(track.times_s[right]) - begin_s, t = (time_s - begin_s) / interval_s;
  if (!cubic) {
    if (is_rotation) return glm::vec4(slerp(unit(key(left)), unit(key(right)), t));
    return glm::vec4(key(left) + t * (key(right) - key(left)));
  }
  const glm::dvec4 leaving = interval_s * glm::dvec4(track.values[3 * left + 2]),
                   arriving = interval_s * glm::dvec4(track.values[3 * right]);
  const double t2 = t * t, t3 = t2 * t;
  return finished((2.0 * t3 - 3.0 * t2 + 1.0) * key(left) + (t3 - 2.0 * t2 + t) * leaving +
                  (3.0 * t2 - 2.0 * t3) * key(right) + (t3 - t2) * arriving);
}

glm::mat4 local_at(const AnimatedNode& node, double time_s) {
  std::array<glm::vec4, AnimatedNode::kProperties> now = node.rest;
  for (std::size_t i = 0; i < now.size(); ++i)
    if (!node.tracks[i].times_s.empty()) now[i] = value_at(node.tracks[i], i == AnimatedNode::rotation, time_s);
  const glm::vec4& q = now[AnimatedNode::rotation];
  glm::mat4 local = glm::mat4_cast(glm::quat(q.w, q.x, q.y, q.z));
  for (int c = 0; c < 3; ++c) local[c] *= now[AnimatedNode::scale][c];
  local[3] = glm::vec4(glm::vec3(now[AnimatedNode::translation]), 1.0f);
  return local;
}

int animation_index(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.animations, name, &Animation::name);
  return found == scene.animations.end() ? -1 : static_cast<int>(found - scene.animations.begin());
}

void pose(Scene* scene, const Animation& animation, double time_s) {
  for (const AnimatedNode& node : animation.nodes)
    scene->nodes[static_cast<std::size_t>(node.node)].local = local_at(node, time_s);
}

}  // namespace maquette
