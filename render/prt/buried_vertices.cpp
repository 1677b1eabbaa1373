#include "render/prt/buried_vertices.h"

#include <limits>

#include "scenes/parallel.h"

namespace maquette {

namespace {

bool is_lit(const ArrivingLight& light, std::size_t vertex) { return light.first[vertex] < light.first[vertex + 1]; }

/// Cosine-weighted share of the directions above a vertex's horizon that meet the back of a surface.
double share_of_backs(const TransferVertex& v, const glm::vec3& origin, const FlatGeometry& geometry,
                      const CubeDirections& directions, const RayScene& scene) {
  double all = 0.0, backs = 0.0;
  for (Eigen::Index d = 0; d < directions.count(); ++d) {
    const double weight = glm::dot(glm::dvec3(v.n), directions.direction(d)) * directions.solid_angles()[d];
    if (!(weight > 0.0)) continue;
    all += weight;
    const auto hit = scene.nearest(origin, glm::vec3(directions.direction(d)), 0.0f);
    if (!hit) continue;
    const std::uint32_t* c = &geometry.indices[3 * static_cast<std::size_t>(hit->triangle)];
    const glm::dvec3 p(geometry.positions[c[0]]);
    const glm::dvec3 normal =
        glm::cross(glm::dvec3(geometry.positions[c[1]]) - p, glm::dvec3(geometry.positions[c[2]]) - p);
    if (glm::dot(normal, directions.direction(d)) > 0.0) backs += weight;
  }
  return all > 0.0 ? backs / all : 0.0;
}

/// [vertex] its neighbours in the divided triangles, in a fixed order.
std::vector<std::vector<std::uint32_t>> neighbours_of(const TransferMesh& mesh, const std::vector<bool>& wanted) {
  std::vector<std::vector<std::uint32_t>> of(mesh.vertices.size());
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    if (wanted[a]) of[a].push_back(b);
    if (wanted[b]) of[b].push_back(a);
  };
  for (const TransferMesh::Triangle& t : mesh.triangles) {
    const std::uint32_t* row = mesh.grid.data() + t.first;
    for (std::uint32_t length = (1u << t.level) + 1; length > 1; row += length, --length)
      for (std::uint32_t i = 0; i + 1 < length; ++i) {
        join(row[i], row[i + 1]);
        join(row[i], row[length + i]);
        join(row[i + 1], row[length + i]);
      }
  }
  return of;
}

}  // namespace

std::vector<bool> find_buried_vertices(const TransferMesh& mesh, const FlatGeometry& geometry,
                                       const CubeDirections& directions, const RayScene& scene,
                                       const ArrivingLight& light) {
  std::vector<char> found(mesh.vertices.size(), 0);
  parallel_for(std::size_t{0}, found.size(), [&](std::size_t v) {
    found[v] = !is_lit(light, v) && share_of_backs(mesh.vertices[v], transfer_ray_origin(mesh.vertices[v]), geometry,
                                                   directions, scene) > 0.5;
  });
  return {found.begin(), found.end()};
}

std::vector<std::uint32_t> light_sources(const TransferMesh& mesh, const std::vector<bool>& buried,
                                         const ArrivingLight& light) {
  const std::vector<std::vector<std::uint32_t>> neighbours = neighbours_of(mesh, buried);
  std::vector<std::uint32_t> source(mesh.vertices.size());
  std::vector<std::uint32_t> waiting;
  for (std::uint32_t v = 0; v < source.size(); ++v) {
    source[v] = v;
    if (buried[v]) waiting.push_back(v);
  }
  while (!waiting.empty()) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ring;
    std::vector<std::uint32_t> left;
    for (const std::uint32_t v : waiting) {
      float nearest = std::numeric_limits<float>::max();
      std::uint32_t of = v;
      for (const std::uint32_t n : neighbours[v]) {
        if (!is_lit(light, source[n])) continue;
        const glm::vec3 to = mesh.vertices[n].position - mesh.vertices[v].position;
        if (const float distance = glm::dot(to, to); distance < nearest) nearest = distance, of = source[n];
      }
      if (of == v)
        left.push_back(v);
      else
        ring.emplace_back(v, of);
    }
    if (ring.empty()) break;
    for (const auto& [v, of] : ring) source[v] = of;
    waiting = std::move(left);
  }
  return source;
}

void take_light_of(const std::vector<std::uint32_t>& sources, ArrivingLight* light) {
  ArrivingLight all;
  all.first.push_back(0);
  for (const std::uint32_t s : sources) {
    all.entries.insert(all.entries.end(), light->entries.begin() + static_cast<std::ptrdiff_t>(light->first[s]),
                       light->entries.begin() + static_cast<std::ptrdiff_t>(light->first[s + 1]));
    all.first.push_back(all.entries.size());
  }
  *light = std::move(all);
}

}  // namespace maquette
