#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <vector>

#include "scenes/scene.h"

namespace maquette::test {

/// Catmull-Clark in double, directly from the rules of the paper, and slow: the reference for the evaluator.
/// Source: Catmull and Clark 1978; creases of integer sharpness as in DeRose et al. 1998, section 3.
struct ReferenceMesh {
  using Edge = std::array<int, 2>;
  std::vector<glm::dvec3> points;
  std::vector<std::vector<int>> faces;
  std::map<Edge, double> sharpness;

  static Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

  explicit ReferenceMesh(const SubdivisionCage& cage) {
    for (const glm::vec3& p : cage.positions) points.emplace_back(p);
    std::size_t first = 0;
    for (const int size : cage.face_sizes) {
      const auto begin = cage.face_indices.begin() + static_cast<std::ptrdiff_t>(first);
      faces.emplace_back(begin, begin + size);
      first += static_cast<std::size_t>(size);
    }
    for (std::size_t i = 0; i < cage.crease_edges.size(); ++i)
      sharpness[edge_of(cage.crease_edges[i][0], cage.crease_edges[i][1])] = cage.crease_sharpness[i];
  }
  ReferenceMesh() = default;

  /// Faces at each edge and at each vertex.
  struct Topology {
    std::map<Edge, std::vector<int>> edge_faces;
    std::vector<std::vector<int>> vertex_faces;
  };
  Topology topology() const {
    Topology out;
    out.vertex_faces.resize(points.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
      for (std::size_t i = 0; i < faces[f].size(); ++i) {
        out.edge_faces[edge_of(faces[f][i], faces[f][(i + 1) % faces[f].size()])].push_back(static_cast<int>(f));
        out.vertex_faces[static_cast<std::size_t>(faces[f][i])].push_back(static_cast<int>(f));
      }
    }
    return out;
  }
  bool is_sharp(const Topology& t, const Edge& edge) const {
    const auto found = sharpness.find(edge);
    return t.edge_faces.at(edge).size() == 1 || (found != sharpness.end() && found->second > 0.0);
  }
  glm::dvec3 face_point(int f) const {
    glm::dvec3 sum(0.0);
    for (const int v : faces[static_cast<std::size_t>(f)]) sum += point(v);
    return sum / static_cast<double>(faces[static_cast<std::size_t>(f)].size());
  }
  const glm::dvec3& point(int v) const { return points[static_cast<std::size_t>(v)]; }

  ReferenceMesh refined() const {
    const Topology t = topology();
    ReferenceMesh out;
    std::vector<std::vector<Edge>> vertex_edges(points.size());
    for (const auto& [edge, at] : t.edge_faces)
      for (const int v : edge) vertex_edges[static_cast<std::size_t>(v)].push_back(edge);
    for (std::size_t v = 0; v < points.size(); ++v)
      out.points.push_back(moved_vertex(t, static_cast<int>(v), vertex_edges[v]));
    const int first_face = static_cast<int>(out.points.size());
    for (std::size_t f = 0; f < faces.size(); ++f) out.points.push_back(face_point(static_cast<int>(f)));
    std::map<Edge, int> edge_index;
    for (const auto& [edge, at] : t.edge_faces) {
      const int index = edge_index[edge] = static_cast<int>(out.points.size());
      const glm::dvec3 middle = 0.5 * (point(edge[0]) + point(edge[1]));
      out.points.push_back(is_sharp(t, edge) ? middle : 0.5 * middle + 0.25 * (face_point(at[0]) + face_point(at[1])));
      const auto found = sharpness.find(edge);
      if (found == sharpness.end()) continue;
      const double next = found->second >= 10.0 ? found->second : found->second - 1.0;
      for (const int v : edge)
        if (next > 0.0) out.sharpness[edge_of(v, index)] = next;
    }
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const std::vector<int>& face = faces[f];
      for (std::size_t i = 0; i < face.size(); ++i) {
        const int before = face[(i + face.size() - 1) % face.size()], after = face[(i + 1) % face.size()];
        out.faces.push_back({face[i], edge_index[edge_of(face[i], after)], first_face + static_cast<int>(f),
                             edge_index[edge_of(face[i], before)]});
      }
    }
    return out;
  }

  glm::dvec3 moved_vertex(const Topology& t, int v, const std::vector<Edge>& edges) const {
    std::vector<glm::dvec3> sharp_ends;
    glm::dvec3 ends(0.0), face_points(0.0);
    for (const Edge& edge : edges) {
      const glm::dvec3 end = point(edge[0] == v ? edge[1] : edge[0]);
      ends += end;
      if (is_sharp(t, edge)) sharp_ends.push_back(end);
    }
    const std::vector<int>& around = t.vertex_faces[static_cast<std::size_t>(v)];
    for (const int f : around) face_points += face_point(f);
    if (sharp_ends.size() > 2 || around.size() == 1) return point(v);  // a corner; an outer corner is kept too
    if (sharp_ends.size() == 2) return 0.75 * point(v) + 0.125 * (sharp_ends[0] + sharp_ends[1]);
    const double n = static_cast<double>(edges.size());
    return (n - 2.0) / n * point(v) + ends / (n * n) + face_points / (n * n);
  }

  /// Limit of every vertex of a quad mesh.
  /// Source: Halstead et al. 1993, Eq. 5 (smooth); the cubic B-spline's (1 4 1)/6 along creases.
  std::vector<glm::dvec3> limit_points() const {
    const Topology t = topology();
    std::vector<glm::dvec3> sums(points.size(), glm::dvec3(0.0));
    std::vector<glm::dvec3> crease = sums;
    std::vector<int> sharp(points.size(), 0);
    for (const auto& [edge, at] : t.edge_faces) {
      for (int side = 0; side < 2; ++side) {
        const auto v = static_cast<std::size_t>(edge[static_cast<std::size_t>(side)]);
        const glm::dvec3 end = point(edge[static_cast<std::size_t>(1 - side)]);
        sums[v] += 4.0 * end;
        if (!is_sharp(t, edge)) continue;
        crease[v] += end;
        ++sharp[v];
      }
    }
    for (const std::vector<int>& face : faces)
      for (std::size_t i = 0; i < 4; ++i) sums[static_cast<std::size_t>(face[i])] += point(face[(i + 2) % 4]);
    std::vector<glm::dvec3> out;
    for (std::size_t v = 0; v < points.size(); ++v) {
      const double n = static_cast<double>(t.vertex_faces[v].size());
      if (sharp[v] > 2 || n == 1.0) {
        out.push_back(points[v]);
      } else if (sharp[v] == 2) {
        out.push_back((4.0 * points[v] + crease[v]) / 6.0);
      } else {
        out.push_back((n * n * points[v] + sums[v]) / (n * (n + 5.0)));
      }
    }
    return out;
  }
};

}  // namespace maquette::test
