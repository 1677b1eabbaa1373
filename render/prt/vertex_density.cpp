#include "render/prt/vertex_density.h"

#include <cmath>

#include "render/prt/buried_vertices.h"

namespace maquette {

namespace {

constexpr int kFaces = 8;

/// A vertex in the middle of an edge, and the ends.
struct MiddleVertex {
  std::uint32_t middle, a, b;
};

/// Of a division, those that the division before it does not have.
std::vector<MiddleVertex> find_middles(const TransferMesh& mesh) {
  std::vector<MiddleVertex> found;
  std::vector<bool> known(mesh.vertices.size(), false);
  for (const TransferMesh::Triangle& t : mesh.triangles) {
    const int n = 1 << t.level;
    const auto at = [&](int i, int j) {
      return mesh.grid[t.first + static_cast<std::size_t>(j * (n + 1) - j * (j - 1) / 2 + i)];
    };
    for (int j = 0; j <= n; ++j)
      for (int i = j % 2 == 0 ? 1 : 0; i + j <= n; i += j % 2 == 0 ? 2 : 1) {
        const std::uint32_t middle = at(i, j);
        if (known[middle]) continue;
        known[middle] = true;
        if (j % 2 == 0)
          found.push_back({middle, at(i - 1, j), at(i + 1, j)});
        else if (i % 2 == 0)
          found.push_back({middle, at(i, j - 1), at(i, j + 1)});
        else
          found.push_back({middle, at(i - 1, j + 1), at(i + 1, j - 1)});
      }
  }
  return found;
}

void add(const ArrivingLight& light, std::uint32_t vertex, float factor, std::vector<float>* sums) {
  for (std::size_t e = light.first[vertex]; e < light.first[vertex + 1]; ++e)
    (*sums)[light.entries[e].direction] += factor * light.entries[e].arriving;
}

std::size_t count_vertices(const FlatGeometry& geometry, const std::vector<TransferPart>& parts) {
  return make_transfer_mesh(geometry, parts, 0).vertices.size();
}

}  // namespace

double vertex_interpolation_error(const FlatGeometry& geometry, const TransferPart& part, const RayScene& scene,
                                  const std::atomic<bool>& cancel) {
  TransferPart finer = part;
  finer.group = 0;
  ++finer.level;
  const TransferMesh mesh = make_transfer_mesh(geometry, {finer}, 0);
  const CubeDirections cube(kFaces);
  ArrivingLight light = trace_arriving_light(mesh, cube, scene, {.rays = 1}, cancel);
  if (cancel) return 0.0;
  take_light_of(light_sources(mesh, find_buried_vertices(mesh, geometry, cube, scene, light), light), &light);
  double squares = 0.0, all = 0.0;
  std::vector<float> missed(static_cast<std::size_t>(cube.count()));
  for (const MiddleVertex& m : find_middles(mesh)) {
    std::fill(missed.begin(), missed.end(), 0.0f);
    add(light, m.middle, 1.0f, &missed);
    for (std::size_t d = 0; d < missed.size(); ++d)
      all += cube.solid_angles()[static_cast<Eigen::Index>(d)] * static_cast<double>(missed[d] * missed[d]);
    add(light, m.a, -0.5f, &missed);
    add(light, m.b, -0.5f, &missed);
    for (std::size_t d = 0; d < missed.size(); ++d)
      squares += cube.solid_angles()[static_cast<Eigen::Index>(d)] * static_cast<double>(missed[d] * missed[d]);
  }
  return all > 0.0 ? std::sqrt(squares / all) : 0.0;
}

std::vector<VertexDensity> choose_vertex_density(const FlatGeometry& geometry, const RayScene& scene, double error,
                                                 std::size_t most, const std::atomic<bool>& cancel,
                                                 std::vector<TransferPart>* parts) {
  std::vector<VertexDensity> chosen;
  for (const TransferPart& part : *parts)
    chosen.push_back({part.level, vertex_interpolation_error(geometry, part, scene, cancel)});
  std::vector<bool> closed(parts->size(), false);
  while (!cancel) {
    std::size_t worst = parts->size();
    for (std::size_t p = 0; p < parts->size(); ++p)
      if (!closed[p] && chosen[p].error > error && (worst == parts->size() || chosen[p].error > chosen[worst].error))
        worst = p;
    if (worst == parts->size()) break;
    TransferPart& part = (*parts)[worst];
    ++part.level;
    if (part.level > kMostTransferLevels || count_vertices(geometry, *parts) > most) {
      --part.level;
      closed[worst] = true;
      continue;
    }
    chosen[worst] = {part.level, vertex_interpolation_error(geometry, part, scene, cancel)};
  }
  return chosen;
}

}  // namespace maquette
