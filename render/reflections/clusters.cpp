#include "render/reflections/clusters.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maquette {

namespace {

void close_cluster(const FlatGeometry& geometry, Cluster cluster, ClusterSet* set) {
  if (cluster.triangle_count == 0) return;
  cluster.vertex_count = static_cast<std::uint32_t>(set->vertices.size()) - cluster.first_vertex;
  glm::vec3 low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
  const auto each = [&](auto&& use) {
    for (std::uint32_t k = 0; k < cluster.vertex_count; ++k)
      use(geometry.positions[set->vertices[cluster.first_vertex + k]]);
  };
  each([&](const glm::vec3& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  });
  cluster.center = 0.5f * (low + high);
  cluster.half_extent = 0.5f * (high - low);
  each([&](const glm::vec3& p) { cluster.radius = std::max(cluster.radius, glm::length(p - cluster.center)); });
  set->clusters.push_back(cluster);
}

}  // namespace

/// Sorts by the Morton codes of the centroids, 10 bits an axis.
std::vector<std::uint32_t> order_along_curve(const FlatGeometry& geometry, const DrawItem& item) {
  const auto middle = [&](std::uint32_t t) {
    const std::uint32_t* v = &geometry.indices[3 * static_cast<std::size_t>(t)];
    return (geometry.positions[v[0]] + geometry.positions[v[1]] + geometry.positions[v[2]]) / 3.0f;
  };
  const std::uint32_t first = item.first_index / 3, end = first + item.index_count / 3;
  glm::vec3 low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
  for (std::uint32_t t = first; t < end; ++t) {
    low = glm::min(low, middle(t));
    high = glm::max(high, middle(t));
  }
  const float scale = 1023.0f / std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-30f});
  std::vector<std::pair<std::uint32_t, std::uint32_t>> coded;
  for (std::uint32_t t = first; t < end; ++t) {
    const glm::uvec3 at(glm::clamp((middle(t) - low) * scale, 0.0f, 1023.0f));
    std::uint32_t code = 0;
    for (int bit = 0; bit < 10; ++bit)
      for (int axis = 0; axis < 3; ++axis) code |= (at[axis] >> bit & 1u) << (3 * bit + axis);
    coded.emplace_back(code, t);
  }
  std::sort(coded.begin(), coded.end());
  std::vector<std::uint32_t> order;
  for (const auto& [code, t] : coded) order.push_back(t);
  return order;
}

ClusterSet make_clusters(const FlatGeometry& geometry) {
  constexpr std::uint32_t kNone = ~0u;
  ClusterSet set;
  std::vector<std::uint32_t> number(geometry.positions.size(), kNone);  // index within the current cluster
  for (const DrawItem& item : geometry.items) {
    const std::vector<std::uint32_t> order = order_along_curve(geometry, item);
    const std::size_t begin = set.clusters.size();
    Cluster open;
    const auto restart = [&] {
      close_cluster(geometry, open, &set);
      for (std::size_t k = open.first_vertex; k < set.vertices.size(); ++k) number[set.vertices[k]] = kNone;
      open = Cluster();
      open.first_vertex = static_cast<std::uint32_t>(set.vertices.size());
      open.first_triangle = static_cast<std::uint32_t>(set.triangles.size());
    };
    restart();
    for (const std::uint32_t t : order) {
      const std::uint32_t* v = &geometry.indices[3 * static_cast<std::size_t>(t)];
      const auto held = static_cast<std::uint32_t>(set.vertices.size()) - open.first_vertex;
      const auto more = static_cast<std::uint32_t>(std::count_if(v, v + 3, [&](auto k) { return number[k] == kNone; }));
      if (held + more > Cluster::kMaxVertices || open.triangle_count == Cluster::kMaxTriangles) restart();
      std::uint32_t corners = 0;
      for (int k = 0; k < 3; ++k) {
        if (number[v[k]] == kNone) {
          number[v[k]] = static_cast<std::uint32_t>(set.vertices.size()) - open.first_vertex;
          set.vertices.push_back(v[k]);
        }
        corners |= number[v[k]] << (8 * k);
      }
      set.triangles.emplace_back(corners, t);
      ++open.triangle_count;
    }
    restart();
    set.of_item.push_back({begin, set.clusters.size()});
  }
  return set;
}

std::vector<std::uint32_t> cluster_of_triangle(const ClusterSet& set) {
  std::vector<std::uint32_t> out(set.triangles.size());
  for (std::size_t c = 0; c < set.clusters.size(); ++c)
    for (std::uint32_t k = 0; k < set.clusters[c].triangle_count; ++k)
      out[set.triangles[set.clusters[c].first_triangle + k].y] = static_cast<std::uint32_t>(c);
  return out;
}

Beam make_beam(std::span<const glm::vec3> origins, std::span<const glm::vec3> directions) {
  Beam beam;
  glm::vec3 sum(0.0f);
  beam.base = glm::vec3(0.0f);
  for (const glm::vec3& p : origins) beam.base += p / static_cast<float>(origins.size());
  for (const glm::vec3& d : directions) sum += d;
  const float length = glm::length(sum);
  beam.axis = length > 1e-6f ? sum / length : directions[0];
  float least = length > 1e-6f ? 1.0f : -1.0f;
  for (const glm::vec3& p : origins) beam.base_radius = std::max(beam.base_radius, glm::length(p - beam.base));
  for (const glm::vec3& d : directions) least = std::min(least, glm::dot(beam.axis, d));
  beam.cosine = std::max(least - 1e-6f, 0.0f);  // near 1 the rounding of a cosine is a large angle
  beam.sine = std::sqrt(std::max(1.0f - beam.cosine * beam.cosine, 0.0f));
  return beam;
}

}  // namespace maquette
