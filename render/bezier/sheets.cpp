#include "render/bezier/sheets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace maquette {

namespace {

/// Groups triangles into smooth sheets: two triangles belong to the same sheet when they share an edge (by position,
/// not by index) and are nearly coplanar there.
class Sheets {
 public:
  Sheets(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices) : parent_(indices.size() / 3) {
    constexpr double kCrease = 0.9;  // cosine
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    std::map<std::array<float, 3>, std::uint32_t> point_numbers;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> edges;
    for (std::size_t t = 0; t < parent_.size(); ++t) {
      std::array<std::uint32_t, 3> v{};
      std::array<glm::dvec3, 3> p{};
      for (std::size_t k = 0; k < 3; ++k) {
        const glm::vec3& at = positions[indices[3 * t + k]];
        v[k] = point_numbers.emplace(std::array{at.x, at.y, at.z}, static_cast<std::uint32_t>(point_numbers.size()))
                   .first->second;
        p[k] = at;
      }
      normals_.push_back(glm::cross(p[1] - p[0], p[2] - p[0]));
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [edge, first] = edges.emplace(std::minmax(v[k], v[(k + 1) % 3]), t);
        if (first) continue;
        const glm::dvec3 &a = normals_[t], &b = normals_[edge->second];
        // A sliver has no reliable plane, so it joins its neighbour.
        const double sizes = glm::length(a) * glm::length(b);
        if (std::abs(glm::dot(a, b)) >= kCrease * sizes) parent_[root(t)] = root(edge->second);
      }
    }
  }
  std::size_t root(std::size_t t) {
    while (parent_[t] != t) t = parent_[t] = parent_[parent_[t]];
    return t;
  }
  double area(std::size_t t) const { return 0.5 * glm::length(normals_[t]); }

 private:
  std::vector<std::size_t> parent_;
  std::vector<glm::dvec3> normals_;
};

}  // namespace

std::vector<std::vector<std::size_t>> find_sheets(std::span<const glm::vec3> positions,
                                                  std::span<const std::uint32_t> indices) {
  Sheets sheets(positions, indices);
  std::map<std::size_t, std::pair<double, std::vector<std::size_t>>> by_root;
  for (std::size_t t = 0; t < indices.size() / 3; ++t) {
    auto& [area, triangles] = by_root[sheets.root(t)];
    area += sheets.area(t);
    triangles.push_back(t);
  }
  std::vector<std::pair<double, std::vector<std::size_t>>> kept;
  for (auto& [root, sheet] : by_root) kept.push_back(std::move(sheet));
  std::stable_sort(kept.begin(), kept.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::vector<std::size_t>> out;
  for (auto& sheet : kept) out.push_back(std::move(sheet.second));
  return out;
}

}  // namespace maquette
