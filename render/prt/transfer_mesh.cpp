#include "render/prt/transfer_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "render/math/shared_formulas.h"
#include "render/math/surface_formulas.h"

namespace maquette {

namespace {

std::size_t grid_index(int n, int i, int j) { return static_cast<std::size_t>(j * (n + 1) - j * (j - 1) / 2 + i); }

bool usable(const FlatGeometry& g, const std::uint32_t* c) {
  for (int k = 0; k < 3; ++k)
    for (int a = 0; a < 3; ++a)
      if (!std::isfinite(g.positions[c[k]][a])) return false;
  const glm::dvec3 p(g.positions[c[0]]);
  return glm::length(glm::cross(glm::dvec3(g.positions[c[1]]) - p, glm::dvec3(g.positions[c[2]]) - p)) > 0.0;
}

struct ItemSize {
  std::size_t triangles = 0;
  double edge = 0.0;  ///< mean length, m
};

ItemSize measure_item(const FlatGeometry& g, const DrawItem& item) {
  ItemSize size;
  for (std::uint32_t i = item.first_index; i + 2 < item.first_index + item.index_count; i += 3) {
    if (!usable(g, &g.indices[i])) continue;
    ++size.triangles;
    for (std::uint32_t k = 0; k < 3; ++k)
      size.edge +=
          static_cast<double>(glm::length(g.positions[g.indices[i + k]] - g.positions[g.indices[i + (k + 1) % 3]])) /
          3.0;
  }
  if (size.triangles > 0) size.edge /= static_cast<double>(size.triangles);
  return size;
}

/// A closed surface has half as many vertices as triangles.
std::size_t expected_vertices(const ItemSize& size, int level) { return (size.triangles << (2 * level)) / 2; }

std::vector<int> choose_levels(const FlatGeometry& g, const std::vector<TransferPart>& parts, std::size_t wanted) {
  std::vector<ItemSize> sizes;
  for (const TransferPart& part : parts) sizes.push_back(measure_item(g, g.items[part.item]));
  std::vector<int> levels;
  for (const TransferPart& part : parts) levels.push_back(part.level);
  while (true) {
    std::size_t sum = 0, longest = parts.size();
    double edge = 0.0;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      sum += expected_vertices(sizes[p], levels[p]);
      const double own = std::ldexp(sizes[p].edge, -levels[p]);
      if (levels[p] < kMostTransferLevels && own > edge) edge = own, longest = p;
    }
    if (sum >= wanted || longest == parts.size()) return levels;
    ++levels[longest];
  }
}

/// Divides the triangles of one item.
class Divider {
 public:
  Divider(const FlatGeometry& geometry, std::uint32_t part, int level, TransferMesh* mesh)
      : g_(geometry), part_(part), level_(level), n_(1 << level), mesh_(*mesh) {}

  void add(std::uint32_t triangle) {
    const std::uint32_t* c = &g_.indices[3 * static_cast<std::size_t>(triangle)];
    mesh_.triangles.push_back({triangle, part_, static_cast<std::uint32_t>(mesh_.grid.size()), level_});
    const glm::vec3 middle = (g_.positions[c[0]] + g_.positions[c[1]] + g_.positions[c[2]]) / 3.0f;
    for (int j = 0; j <= n_; ++j)
      for (int i = 0; i + j <= n_; ++i) {
        const std::uint32_t vertex = find(c, {n_ - i - j, i, j});
        TransferVertex& v = mesh_.vertices[vertex];
        if (v.inside == glm::vec3(0.0f)) v.inside = (middle - v.position) / static_cast<float>(n_);
        mesh_.grid.push_back(vertex);
      }
  }

 private:
  /// Weights in n-ths of up to three vertices, in the order of their numbers: the same of both sides of an edge.
  using Place = std::array<std::pair<std::uint32_t, int>, 3>;

  std::uint32_t find(const std::uint32_t* corner, const std::array<int, 3>& weights) {
    Place place{};
    for (std::size_t k = 0; k < 3; ++k)
      place[k] = weights[k] > 0 ? std::pair(corner[k] + 1, weights[k]) : std::pair(0u, 0);
    std::sort(place.begin(), place.end());
    const auto [found, fresh] = known_.emplace(place, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (fresh) mesh_.vertices.push_back(make(corner, place));
    return found->second;
  }

  TransferVertex make(const std::uint32_t* corner, const Place& place) const {
    TransferVertex v;
    glm::vec3 normal(0.0f);
    glm::vec4 tangent(0.0f);
    for (const auto& [index, weight] : place) {
      if (weight == 0) continue;
      const float share = static_cast<float>(weight) / static_cast<float>(n_);
      v.position += share * g_.positions[index - 1];
      normal += share * g_.normals[index - 1];
      tangent += share * g_.tangents[index - 1];
    }
    const glm::vec3 p = g_.positions[corner[0]];
    v.n = shared::interpolated_normal(normal, glm::cross(g_.positions[corner[1]] - p, g_.positions[corner[2]] - p));
    v.t = glm::normalize(shared::tangent_direction(v.n, tangent, glm::vec2(1.0f, 0.0f)));
    v.b = glm::cross(v.n, v.t);
    if (glm::dot(v.b, shared::tangent_direction(v.n, tangent, glm::vec2(0.0f, 1.0f))) < 0.0f) v.b = -v.b;
    v.group = mesh_.parts[part_].group;
    return v;
  }

  const FlatGeometry& g_;
  std::uint32_t part_;
  int level_, n_;
  TransferMesh& mesh_;
  std::map<Place, std::uint32_t> known_;
};

}  // namespace

TransferMesh make_transfer_mesh(const FlatGeometry& geometry, const std::vector<TransferPart>& parts,
                                std::size_t wanted) {
  TransferMesh mesh;
  mesh.parts = parts;
  const std::vector<int> levels = choose_levels(geometry, parts, wanted);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const DrawItem& item = geometry.items[parts[p].item];
    Divider divider(geometry, static_cast<std::uint32_t>(p), levels[p], &mesh);
    for (std::uint32_t i = item.first_index; i + 2 < item.first_index + item.index_count; i += 3)
      if (usable(geometry, &geometry.indices[i])) divider.add(i / 3);
  }
  return mesh;
}

TransferCorners find_transfer_corners(const TransferMesh& mesh, const TransferMesh::Triangle& triangle,
                                      const glm::vec2& b) {
  const int n = 1 << triangle.level;
  const float x = glm::clamp(b.x, 0.0f, 1.0f) * static_cast<float>(n),
              y = glm::clamp(b.y, 0.0f, 1.0f) * static_cast<float>(n);
  int i = std::min(static_cast<int>(x), n - 1), j = std::min(static_cast<int>(y), n - 1);
  if (i + j > n - 1) (i > 0 ? i : j) = std::max(n - 1 - (i > 0 ? j : i), 0);
  const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
  const auto at = [&](int a, int c) { return mesh.grid[triangle.first + grid_index(n, a, c)]; };
  TransferCorners corners;
  if (fx + fy <= 1.0f || i + j >= n - 1) {
    const float sum = std::max(fx + fy, 1.0f);
    corners = {{at(i, j), at(i + 1, j), at(i, j + 1)}, {1.0f - (fx + fy) / sum, fx / sum, fy / sum}};
  } else {
    corners = {{at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)}, {fx + fy - 1.0f, 1.0f - fx, 1.0f - fy}};
  }
  return corners;
}

double metres_per_uv(const FlatGeometry& g, const DrawItem& item) {
  double area = 0.0, of_uvs = 0.0;
  for (std::uint32_t i = item.first_index; i + 2 < item.first_index + item.index_count; i += 3) {
    const std::uint32_t* c = &g.indices[i];
    const glm::dvec3 p(g.positions[c[0]]);
    const glm::dvec2 q(g.uv0[c[0]]), s = glm::dvec2(g.uv0[c[1]]) - q, t = glm::dvec2(g.uv0[c[2]]) - q;
    area += glm::length(glm::cross(glm::dvec3(g.positions[c[1]]) - p, glm::dvec3(g.positions[c[2]]) - p));
    of_uvs += std::abs(s.x * t.y - t.x * s.y);
  }
  const double side = of_uvs > 0.0 ? std::sqrt(area / of_uvs) : 0.0;
  return std::isfinite(side) ? side : 0.0;
}

}  // namespace maquette
