#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>

#include "render/math/low_discrepancy.h"

namespace maquette {

/// A hash grid over positions and the axis that a surface faces; cells are finer near the eye. Guides store what they
/// learn by cell. Two regions of the scene may share a cell.
struct HashGrid {
  static constexpr std::uint32_t kNoCell = 0xffffffffu;
  static constexpr std::uint32_t kCells = 1u << 15;
  static constexpr float kAngle = 0.12f;  ///< side of a cell over its distance from the eye

  glm::vec3 eye{0.0f};
  float finest_m = 1.0f;

  HashGrid(const glm::vec3& eye_at, float scene_radius)
      : eye(eye_at), finest_m(std::max(scene_radius * 1e-3f, 1e-30f)) {}
  /// Cell sides are powers of two of the finest, so that neighbouring positions agree.
  int level(const glm::vec3& position) const {
    const float wanted = std::max(kAngle * glm::length(position - eye) / finest_m, 1.0f);
    return std::min(static_cast<int>(std::bit_cast<std::uint32_t>(wanted) >> 23) - 127, 20);  // exponent of the float
  }
  /// Floor, without a library call.
  static std::int32_t whole_below(float v) {
    const float bounded = v > -2e9f ? v < 2e9f ? v : 2e9f : -2e9f;
    const auto whole = static_cast<std::int32_t>(bounded);
    return whole - (static_cast<float>(whole) > bounded ? 1 : 0);
  }
  float side(const glm::vec3& position) const { return finest_m * static_cast<float>(1 << level(position)); }
  std::uint32_t cell_of(const glm::vec3& position, const glm::vec3& normal) const {
    const int fineness = level(position);
    const glm::vec3 cell = position / (finest_m * static_cast<float>(1 << fineness));
    const glm::vec3 a = glm::abs(normal);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    const int facing = 2 * axis + (normal[axis] < 0.0f ? 1 : 0);
    std::uint32_t key = mix_seed(static_cast<std::uint32_t>(facing), static_cast<std::uint32_t>(fineness));
    for (int c = 0; c < 3; ++c) key = mix_seed(key, static_cast<std::uint32_t>(whole_below(cell[c])));
    return key & (kCells - 1);
  }
};

}  // namespace maquette
