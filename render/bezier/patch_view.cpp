#include "render/bezier/patch_view.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace maquette {

namespace {

/// The surface bulges between the corners of a quad, and its rays leave the cone of the corner rays. The cone is
/// widened by a quarter of the quad's size and of its change of direction, which is more than car glass needs when a
/// pane is cut into 16 x 16 quads.
constexpr float kSlack = 0.25f;

using RayNode = bezier_double::BezierNode;

/// Conservative: false only when the quad is certainly outside the picture.
bool may_be_in_picture(const std::array<const RayNode*, 4>& corners, const glm::dvec3& origin,
                       const FrameConstants& frame) {
  glm::vec2 low(1e30f), high(-1e30f);
  for (const RayNode* corner : corners) {
    const glm::vec4 clip = frame.clip_from_world * glm::vec4(glm::vec3(origin + corner->position), 1.0f);
    if (clip.w <= 1e-6f) return true;
    low = glm::min(low, glm::vec2(clip) / clip.w);
    high = glm::max(high, glm::vec2(clip) / clip.w);
  }
  const glm::vec2 slack = kSlack * (high - low);
  return glm::all(glm::lessThanEqual(low - slack, glm::vec2(1.0f))) &&
         glm::all(glm::greaterThanEqual(high + slack, glm::vec2(-1.0f)));
}

Beam make_quad_beam(const std::array<const RayNode*, 4>& corners, const glm::dvec3& origin) {
  std::vector<glm::vec3> origins, directions;
  for (const RayNode* corner : corners) {
    origins.emplace_back(origin + corner->position);
    directions.emplace_back(corner->direction);
  }
  Beam beam = make_beam(origins, directions);
  const float angle = std::acos(std::clamp(beam.cosine, 0.0f, 1.0f)) * (1.0f + kSlack) + 1e-3f;
  beam.cosine = angle < 1.5f ? std::cos(angle) : 0.0f;
  beam.sine = std::sqrt(1.0f - beam.cosine * beam.cosine);
  beam.base_radius *= 1.0f + kSlack;
  return beam;
}

}  // namespace

PatchView view_patch(const ReflectorPatch& patch, const FrameConstants& frame, int side) {
  const glm::dvec3 eye = glm::dvec3(frame.eye) - patch.origin;
  const auto parameter = [&](int i) { return -1.0 + 2.0 * i / side; };
  std::vector<RayNode> nodes;
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) nodes.push_back(bezier_node(patch.exact, eye, {parameter(i), parameter(j)}));
  const auto at = [&](int i, int j) { return &nodes[static_cast<std::size_t>(j * (side + 1) + i)]; };
  PatchView view;
  view.window = glm::vec4(1.0f, 1.0f, -1.0f, -1.0f);
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const std::array<const RayNode*, 4> corners{at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)};
      if (!may_be_in_picture(corners, patch.origin, frame)) continue;
      view.beams.push_back(make_quad_beam(corners, patch.origin));
      const glm::vec2 low(parameter(i), parameter(j)), high(parameter(i + 1), parameter(j + 1));
      view.window =
          glm::vec4(glm::min(glm::vec2(view.window), low), glm::max(glm::vec2(view.window.z, view.window.w), high));
    }
  return view;
}

}  // namespace maquette
