#include "render/octree/octree_brick.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "render/octree/octree_shared.h"

namespace maquette {

namespace {

/// A sum of normals shorter than this share of the area belongs to a thin sheet seen from both sides: the normals
/// cancel.
constexpr double kCancelled = 0.25;
/// A cell with less opaque surface than this counts as a hole.
constexpr double kMinOpacity = 0.25;

glm::dvec3 unit_or(const glm::dvec3& v, const glm::dvec3& fallback) {
  const double length = glm::length(v);
  return length > 1e-12 ? v / length : fallback;
}

/// Extent of the fragments along the unit normal `n`, below and above `point`.
struct Extent {
  double low = 0.0, high = 0.0;
  double deviation() const { return std::max(-low, high); }
};
Extent extent_along(std::span<const OctreeFragment> fragments, std::span<const glm::vec3> corners, const glm::dvec3& n,
                    const glm::dvec3& point) {
  Extent all;
  for (const OctreeFragment& f : fragments) {
    for (const glm::vec3& corner : corners.subspan(f.first_corner, f.corner_count)) {
      const double height = glm::dot(n, glm::dvec3(corner) - point);
      all.low = std::min(all.low, height);
      all.high = std::max(all.high, height);
    }
  }
  return all;
}

/// Sums the materials by the area that is visible along the normal: surfaces behind others (a screen's housing) are
/// reduced by the share of the cell that those cover.
void add_materials(std::span<const OctreeFragment> fragments, const glm::dvec3& normal, double cell, OctreeSums* sums) {
  struct Share {
    std::uint32_t material;
    double area = 0.0;
    glm::dvec3 color{0.0};
    double largest = 0.0;
    std::uint32_t triangle = 0;
  };
  std::vector<Share> shares;
  const auto add = [&](const OctreeFragment& f, double area) {
    auto found = std::find_if(shares.begin(), shares.end(), [&](const Share& s) { return s.material == f.material; });
    if (found == shares.end()) found = shares.insert(shares.end(), Share{f.material});
    found->area += area;
    found->color += area * glm::dvec3(f.color);
    if (area > found->largest) found->largest = area, found->triangle = f.triangle;
  };
  const bool one = std::all_of(fragments.begin(), fragments.end(),
                               [&](const OctreeFragment& f) { return f.material == fragments[0].material; });
  std::vector<std::pair<double, const OctreeFragment*>> front_to_back;
  for (const OctreeFragment& f : fragments)
    front_to_back.emplace_back(one ? 0.0 : -glm::dot(normal, glm::dvec3(f.centroid)), &f);
  if (!one)
    std::stable_sort(front_to_back.begin(), front_to_back.end(), [](auto& a, auto& b) { return a.first < b.first; });
  double covered = 0.0;
  for (const auto& [height, f] : front_to_back) {
    const double area = static_cast<double>(f->area) * static_cast<double>(f->opacity);
    const double facing = one ? 1.0 : glm::dot(normal, glm::dvec3(f->geometric));
    // A minimum weight, so that every cell has a material.
    add(*f, one ? area : area * std::max(std::abs(facing) * (1.0 - covered), 1e-6));
    covered += std::max(facing, 0.0) * area / (cell * cell);
  }
  for (const Share& share : shares) sums->add_material(share.material, share.area, share.color, share.triangle);
}

OctreeSums sum_leaf(std::span<const OctreeFragment> fragments, std::span<const glm::vec3> corners, double cell) {
  OctreeSums sums;
  glm::dvec3 geometric(0.0);
  double all = 0.0;
  const OctreeFragment* largest = fragments.data();
  for (const OctreeFragment& f : fragments) {
    const double area = static_cast<double>(f.area) * static_cast<double>(f.opacity);
    all += static_cast<double>(f.area);
    sums.area += area;
    sums.normal += area * glm::dvec3(f.normal);
    geometric += area * glm::dvec3(f.geometric);
    sums.centroid += area * glm::dvec3(f.centroid);
    if (f.area > largest->area) largest = &f;
  }
  if (sums.area < kMinOpacity * all || sums.area <= 0.0) return {};
  if (glm::length(sums.normal) < kCancelled * sums.area) {
    // A thin sheet: the larger piece defines the orientation, and the side that the viewer sees is determined at the
    // hit.
    sums.normal = geometric = glm::dvec3(0.0);
    for (const OctreeFragment& f : fragments) {
      const double area = static_cast<double>(f.area) * static_cast<double>(f.opacity);
      sums.normal += (glm::dot(f.normal, largest->normal) < 0.0f ? -area : area) * glm::dvec3(f.normal);
      geometric += (glm::dot(f.geometric, largest->geometric) < 0.0f ? -area : area) * glm::dvec3(f.geometric);
    }
  }
  const glm::dvec3 point = sums.centroid / sums.area;
  Extent extent = extent_along(fragments, corners, unit_or(sums.normal, glm::dvec3(largest->normal)), point);
  sums.deviation = extent.deviation() / cell;
  if (sums.deviation > shared::kOctreePlanar) {
    const glm::dvec3 n = unit_or(geometric, glm::dvec3(largest->geometric));
    const Extent other = extent_along(fragments, corners, n, point);
    if (other.deviation() / cell <= shared::kOctreePlanar) {
      extent = other;
      sums.deviation = other.deviation() / cell;
      sums.normal = n * sums.area;
    }
  }
  sums.low = extent.low / cell;
  sums.high = extent.high / cell;
  add_materials(fragments, unit_or(sums.normal, glm::dvec3(largest->normal)), cell, &sums);
  return sums;
}

struct BrickNode {
  std::uint32_t code = 0;  ///< Morton code at the node's own level
  std::uint8_t mask = 0;
  OctreeSums sums;
};

glm::dvec3 decode_morton(std::uint32_t code) {
  glm::ivec3 p(0);
  for (int bit = 0; bit < 10; ++bit)
    for (int axis = 0; axis < 3; ++axis) p[axis] |= static_cast<int>(code >> (3 * bit + axis) & 1u) << bit;
  return glm::dvec3(p);
}

/// Joins the nodes of the next level to those of one level, both in Morton order, and merges in the `leaves` of this
/// level.
std::vector<BrickNode> join_level(const std::vector<BrickNode>& children, std::vector<BrickNode> leaves,
                                  double child_cell) {
  std::vector<BrickNode> nodes;
  std::size_t leaf = 0;
  for (std::size_t first = 0; first < children.size();) {
    const std::uint32_t code = children[first].code >> 3;
    while (leaf < leaves.size() && leaves[leaf].code < code) nodes.push_back(std::move(leaves[leaf++]));
    std::array<const OctreeSums*, 8> parts{};
    BrickNode node;
    node.code = code;
    std::size_t end = first;
    for (; end < children.size() && children[end].code >> 3 == code; ++end) {
      parts[children[end].code & 7u] = &children[end].sums;
      node.mask = static_cast<std::uint8_t>(node.mask | 1u << (children[end].code & 7u));
    }
    node.sums = join_children(parts, child_cell);
    nodes.push_back(std::move(node));
    first = end;
  }
  while (leaf < leaves.size()) nodes.push_back(std::move(leaves[leaf++]));
  return nodes;
}

}  // namespace

void OctreeSums::add_material(std::uint32_t id, double amount, const glm::dvec3& color, std::uint32_t of_triangle) {
  std::size_t smallest = 0;
  for (std::size_t k = 0; k < kMaterials; ++k) {
    if (material_area[k] > 0.0 && material[k] == id) {
      if (amount > material_area[k]) triangle[k] = of_triangle;
      material_area[k] += amount;
      material_color[k] += color;
      return;
    }
    if (material_area[k] < material_area[smallest]) smallest = k;
  }
  if (amount <= material_area[smallest]) return;
  material_area[smallest] = amount;
  material[smallest] = id;
  material_color[smallest] = color;
  triangle[smallest] = of_triangle;
}

OctreeSums join_children(const std::array<const OctreeSums*, 8>& children, double child_cell) {
  OctreeSums sums;
  const OctreeSums* largest = nullptr;
  for (const OctreeSums* child : children) {
    if (!child) continue;
    sums.area += child->area;
    sums.normal += child->normal;
    sums.centroid += child->centroid;
    for (std::size_t k = 0; k < OctreeSums::kMaterials; ++k)
      if (child->material_area[k] > 0.0)
        sums.add_material(child->material[k], child->material_area[k], child->material_color[k], child->triangle[k]);
    if (!largest || child->area > largest->area) largest = child;
  }
  if (!largest) return sums;
  if (glm::length(sums.normal) < kCancelled * sums.area) {
    sums.normal = glm::dvec3(0.0);
    for (const OctreeSums* child : children)
      if (child) sums.normal += glm::dot(child->normal, largest->normal) < 0.0 ? -child->normal : child->normal;
  }
  const glm::dvec3 n = unit_or(sums.normal, glm::dvec3(0.0, 1.0, 0.0)), point = sums.centroid / sums.area;
  for (const OctreeSums* child : children) {
    if (!child) continue;
    const double c = glm::dot(n, unit_or(child->normal, n));
    // Half the diagonal of a cell bounds the extent of its surface along a tilted plane.
    const double extent = (0.87 * std::sqrt(std::max(1.0 - c * c, 0.0)) + child->deviation) * child_cell;
    const double middle = glm::dot(n, child->centroid / child->area - point);
    sums.deviation = std::max(sums.deviation, std::abs(middle) + extent);
    sums.low = std::min(sums.low, (middle - extent) / (2.0 * child_cell));
    sums.high = std::max(sums.high, (middle + extent) / (2.0 * child_cell));
  }
  sums.deviation /= 2.0 * child_cell;
  return sums;
}

OctreeWords pack_node(const OctreeSums& sums, const glm::dvec3& lower, double cell) {
  const auto largest = std::max_element(sums.material_area.begin(), sums.material_area.end());
  const auto chosen = static_cast<std::size_t>(largest - sums.material_area.begin());
  const glm::dvec3 n = unit_or(sums.normal, glm::dvec3(0.0, 1.0, 0.0));
  const glm::dvec3 point = (sums.centroid / sums.area - lower) / cell - 0.5;
  OctreeWords words;
  words.plane = sums.deviation <= shared::kOctreePlanar
                    ? shared::octree_pack_plane(glm::vec3(n), glm::vec3(point))
                    : shared::octree_pack_solid(glm::vec3(n), glm::vec3(point), static_cast<float>(sums.low),
                                                static_cast<float>(sums.high));
  const double coverage = std::min(sums.material_area[chosen] / (cell * cell), 1.0);
  words.color = shared::octree_pack_color(static_cast<int>(sums.material[chosen]), static_cast<float>(coverage),
                                          glm::vec3(sums.material_color[chosen] / *largest));
  words.triangle = sums.triangle[chosen];
  return words;
}

OctreeBrick build_brick(OctreeFragments* fragments, int levels) {
  OctreeBrick brick;
  std::vector<OctreeFragment>& all = fragments->pieces;
  std::sort(all.begin(), all.end(), [](const OctreeFragment& a, const OctreeFragment& b) { return a.code < b.code; });
  std::vector<std::vector<BrickNode>> leaves(static_cast<std::size_t>(levels) + 1);
  for (std::size_t first = 0; first < all.size();) {
    std::size_t end = first + 1;
    while (end < all.size() && all[end].code == all[first].code) ++end;
    const int level = all[first].level;
    BrickNode node;
    node.code = all[first].code >> (3 * (levels - level));
    node.sums = sum_leaf(std::span(all).subspan(first, end - first), fragments->corners, std::exp2(levels - level));
    if (node.sums.area > 0.0) leaves[static_cast<std::size_t>(level)].push_back(std::move(node));
    first = end;
  }
  std::vector<std::vector<BrickNode>> nodes(leaves.size());
  nodes.back() = std::move(leaves.back());
  for (int level = levels - 1; level >= 0; --level) {
    const auto l = static_cast<std::size_t>(level);
    nodes[l] = join_level(nodes[l + 1], std::move(leaves[l]), std::exp2(levels - level - 1));
  }
  if (nodes[0].empty()) return brick;
  for (int level = 0; level <= levels; ++level) {
    const double cell = std::exp2(levels - level);
    const auto& of_level = nodes[static_cast<std::size_t>(level)];
    brick.counts.push_back(static_cast<std::uint32_t>(of_level.size()));
    for (const BrickNode& node : of_level) {
      brick.masks.push_back(node.mask);
      brick.words.push_back(pack_node(node.sums, decode_morton(node.code) * cell, cell));
    }
  }
  brick.sums = nodes[0][0].sums;
  return brick;
}

}  // namespace maquette
