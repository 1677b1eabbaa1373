#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace maquette {

/// Smooth sheets, which end at creases, as lists of triangle indices, largest first.
std::vector<std::vector<std::size_t>> find_sheets(std::span<const glm::vec3> positions,
                                                  std::span<const std::uint32_t> indices);

}  // namespace maquette
