#include "render/triangle/facets.h"

#include <algorithm>
#include <cmath>

#include "render/bezier/reflector_patch.h"

namespace maquette {

namespace {

struct Corner {
  glm::vec3 position{0.0f}, direction{0.0f};
};

Corner make_corner(const glm::dvec3& position, const glm::dvec3& normal, const glm::dvec3& eye) {
  const double length = glm::length(position - eye), area = glm::length(normal);
  const glm::dvec3 view = length > 0.0 ? (position - eye) / length : glm::dvec3(0.0, 0.0, -1.0);
  const glm::dvec3 n = area > 0.0 ? normal / area : -view;
  return {glm::vec3(position), glm::vec3(view - 2.0 * glm::dot(n, view) * n)};
}

/// Computes `margin_px`: how far points and rays of the true surface at the middles of the edges are from those of the
/// triangle. A displaced ray is off by twice the height; a rotated ray is seen at most as much rotated.
float measure_margin(const Corner (&corners)[3], const Corner (&middles)[3], const FrameConstants& frame) {
  const glm::vec3 eye(frame.eye);
  float largest = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const Corner &a = corners[k], &b = corners[(k + 1) % 3], &m = middles[k];
    const glm::vec3 d = a.direction + b.direction;
    const float deviation_rad = glm::length(m.direction - d / std::max(glm::length(d), 1e-6f));
    const float height = glm::length(m.position - 0.5f * (a.position + b.position));
    largest = std::max(largest, deviation_rad + 3.0f * height / std::max(glm::length(m.position - eye), 1e-6f));
  }
  return 1.0f + largest / frame.forward.w;
}

/// Bounding box on screen, and the margin in barycentrics. False outside the picture.
bool project_to_screen(const Corner (&corners)[3], const FrameConstants& frame, Facet* facet) {
  const glm::vec2 size(frame.size), pixel = 2.0f / size;
  glm::vec2 low(1e30f), high(-1e30f), at[3]{};
  for (int k = 0; k < 3; ++k) {
    const glm::vec4 clip = frame.clip_from_world * glm::vec4(corners[k].position, 1.0f);
    if (clip.w <= 1e-6f) return true;  // surrounds the eye: the whole picture, unknown margin
    at[k] = glm::vec2(clip) / clip.w;
    low = glm::min(low, at[k]);
    high = glm::max(high, at[k]);
  }
  low = glm::max(low - facet->margin_px * pixel, glm::vec2(-1.0f));
  high = glm::min(high + facet->margin_px * pixel, glm::vec2(1.0f));
  facet->box = glm::vec4(low, high);
  if (low.x >= high.x || low.y >= high.y) return false;
  const glm::vec2 e1 = (at[1] - at[0]) / pixel, e2 = (at[2] - at[0]) / pixel;
  const float longest = std::max({glm::length(e1), glm::length(e2), glm::length(e1 - e2)});
  facet->longest_px = longest;
  facet->margin = facet->margin_px * longest / std::max(std::abs(e1.x * e2.y - e1.y * e2.x), 1e-6f);
  return true;
}

/// Rays start in the triangle and stay in the hull of the corners' directions, so the distance from a side grows at
/// most by the largest component along its normal. `offset_m` and `deviation_rad`: difference of the true surface's
/// rays.
void set_sides(const Corner (&corners)[3], float offset_m, float deviation_rad, Facet* facet) {
  float size = 0.0f;
  for (int k = 0; k < 3; ++k) size = std::max(size, glm::length(corners[(k + 1) % 3].position - corners[k].position));
  for (int k = 0; k < 3; ++k) {
    const Corner &a = corners[k], &b = corners[(k + 1) % 3], &c = corners[(k + 2) % 3];
    glm::vec3 n = glm::cross(b.position - a.position, a.direction + b.direction);
    const float length = glm::length(n);
    n = length > 1e-20f ? n / length : glm::vec3(0.0f);
    if (glm::dot(n, c.position - a.position) > 0.0f) n = -n;
    float along = 0.0f, start = 0.0f;
    for (const Corner& corner : corners) {
      along = std::max(along, glm::dot(n, corner.direction));
      start = std::max(start, glm::dot(n, corner.position - a.position));
    }
    // Interpolated directions are at least as long as the cosine of their cone.
    facet->widening[k] =
        (facet->beam.cosine > 0.0f ? std::min(along / facet->beam.cosine, 1.0f) : 1.0f) + deviation_rad;
    facet->sides[k] = glm::vec4(n, -glm::dot(n, a.position) - start - offset_m - 2.0f * size * facet->widening[k]);
  }
}

/// The reflector whose facets are made, and the difference of its ghost rays.
struct FacetSource {
  const FrameConstants& frame;
  std::size_t reflector;
  GhostDeviation ghost;
};

void add_facet(const Corner (&corners)[3], const Corner (&middles)[3], const FacetSource& source,
               std::vector<Facet>* facets) {
  const FrameConstants& frame = source.frame;
  Facet facet;
  facet.reflector = source.reflector;
  facet.ghost = source.ghost;
  facet.margin_px = measure_margin(corners, middles, frame);
  facet.margin = 1e6f;
  if (!project_to_screen(corners, frame, &facet)) return;
  const glm::vec3 positions[3] = {corners[0].position, corners[1].position, corners[2].position};
  const glm::vec3 directions[3] = {corners[0].direction, corners[1].direction, corners[2].direction};
  facet.mirror = make_triangle_mirror(positions, directions);
  facet.beam = make_beam(positions, directions);
  // At the middles of the edges the true surface's rays leave the cone of the corner rays a little.
  const float bow_rad = (facet.margin_px - 1.0f) * frame.forward.w, deviation_rad = bow_rad + source.ghost.turn;
  const float offset_m =
      (bow_rad + frame.forward.w) * glm::length(positions[0] - glm::vec3(frame.eye)) + source.ghost.offset_m;
  facet.beam.base_radius += offset_m;
  facet.beam.cosine = std::max(facet.beam.cosine - deviation_rad * (facet.beam.sine + deviation_rad), 0.0f);
  facet.beam.sine = std::sqrt(1.0f - facet.beam.cosine * facet.beam.cosine);
  set_sides(corners, offset_m, deviation_rad, &facet);
  facets->push_back(facet);
}

void add_patch(const Reflector& reflector, const FacetSource& source, int side, std::vector<Facet>* facets) {
  const ReflectorPatch patch = make_reflector_patch(reflector.points);
  const glm::dvec3 eye(source.frame.eye);
  const int points = 2 * side + 1;  // corners and middles
  std::vector<Corner> grid;
  for (int j = 0; j < points; ++j)
    for (int i = 0; i < points; ++i) {
      const bezier_double::SurfaceJet jet = bezier_jet(
          patch.exact, glm::dvec2(-1.0 + i / static_cast<double>(side), -1.0 + j / static_cast<double>(side)));
      grid.push_back(make_corner(patch.origin + jet.p, glm::cross(jet.dx, jet.dy), eye));
    }
  const auto at = [&](int i, int j) { return grid[static_cast<std::size_t>(j * points + i)]; };
  for (int j = 0; j < 2 * side; j += 2)
    for (int i = 0; i < 2 * side; i += 2) {
      add_facet({at(i, j), at(i + 2, j), at(i + 2, j + 2)}, {at(i + 1, j), at(i + 2, j + 1), at(i + 1, j + 1)}, source,
                facets);
      add_facet({at(i, j), at(i + 2, j + 2), at(i, j + 2)}, {at(i + 1, j + 1), at(i + 1, j + 2), at(i, j + 1)}, source,
                facets);
    }
}

}  // namespace

bool may_meet(const Facet& facet, const glm::vec3& center, float radius) {
  if (!may_meet(facet.beam, center, radius)) return false;
  const float distance = glm::length(center - facet.beam.base);
  for (int k = 0; k < 3; ++k)
    if (glm::dot(facet.sides[k], glm::vec4(center, 1.0f)) - radius > facet.widening[k] * (distance + radius))
      return false;
  return true;
}

std::vector<Facet> make_facets(const Reflector& reflector, std::size_t number, const FlatGeometry& geometry,
                               const FrameConstants& frame, int side, const GhostDeviation& ghost) {
  std::vector<Facet> facets;
  const FacetSource source{frame, number, ghost};
  if (reflector.patch) {
    add_patch(reflector, source, side, &facets);
    return facets;
  }
  const DrawItem& item = geometry.items[reflector.item];
  const glm::dvec3 eye(frame.eye);
  for (std::uint32_t k = 0; k < item.index_count; k += 3) {
    const std::uint32_t* v = &geometry.indices[item.first_index + k];
    Corner corners[3], middles[3];
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = v[i], b = v[(i + 1) % 3];
      corners[i] = make_corner(geometry.positions[a], geometry.normals[a], eye);
      middles[i] = make_corner(0.5 * (glm::dvec3(geometry.positions[a]) + glm::dvec3(geometry.positions[b])),
                               glm::dvec3(geometry.normals[a]) + glm::dvec3(geometry.normals[b]), eye);
    }
    add_facet(corners, middles, source, &facets);
  }
  return facets;
}

}  // namespace maquette
