#include "render/prt/view_table.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace maquette {

namespace {

constexpr int kStartSide = 32;  ///< of shaders/prt/transfer.glsl

glm::mat3 weights_of(const DirectionMesh& mesh, const std::array<int, 3>& t) {
  const auto corner = [&](std::size_t k) { return mesh.directions()[static_cast<std::size_t>(t[k])]; };
  return glm::mat3(glm::inverse(glm::dmat3(corner(0), corner(1), corner(2))));
}

}  // namespace

ViewTableSize append_view_table(const DirectionMesh& mesh, std::vector<glm::vec4>* table) {
  const auto& triangles = mesh.triangles();
  std::vector<glm::mat3> inverses;
  std::map<std::pair<int, int>, int> left_of;
  for (const auto& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) left_of[{t[k], t[(k + 1) % 3]}] = static_cast<int>(inverses.size());
    inverses.push_back(weights_of(mesh, t));
  }
  std::vector<float> starts(kStartSide * kStartSide, 0.0f);
  for (int i = 0; i < kStartSide * kStartSide; ++i) {
    glm::vec2 p = (glm::vec2(i % kStartSide, i / kStartSide) + 0.5f) * (2.0f / kStartSide) - 1.0f;
    if (glm::length(p) > 0.9999f) p *= 0.9999f / glm::length(p);
    const glm::vec3 d(p, std::sqrt(1.0f - glm::dot(p, p)));
    float best = -1e30f;
    for (std::size_t t = 0; t < inverses.size(); ++t) {
      const glm::vec3 w = inverses[t] * d;
      if (const float least = std::min({w.x, w.y, w.z}); least > best)
        best = least, starts[static_cast<std::size_t>(i)] = static_cast<float>(t);
    }
  }
  for (std::size_t i = 0; i < starts.size(); i += 4)
    table->emplace_back(starts[i], starts[i + 1], starts[i + 2], starts[i + 3]);
  for (std::size_t t = 0; t < inverses.size(); ++t) {
    const glm::mat3 rows = glm::transpose(inverses[t]);
    glm::vec4 neighbours(-1.0f);
    for (int k = 0; k < 3; ++k) {
      table->emplace_back(rows[k], static_cast<float>(triangles[t][static_cast<std::size_t>(k)]));
      // Neighbour k lies opposite of corner k.
      const auto found = left_of.find(
          {triangles[t][static_cast<std::size_t>((k + 2) % 3)], triangles[t][static_cast<std::size_t>((k + 1) % 3)]});
      if (found != left_of.end()) neighbours[k] = static_cast<float>(found->second);
    }
    table->push_back(neighbours);
  }
  for (const auto& edge : mesh.border())
    for (const int end : edge)
      table->emplace_back(glm::vec3(mesh.directions()[static_cast<std::size_t>(end)]), static_cast<float>(end));
  return {static_cast<int>(triangles.size()), static_cast<int>(mesh.border().size())};
}

}  // namespace maquette
