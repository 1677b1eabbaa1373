#include "scenes/subdivision.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/sdc/catmarkScheme.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <mutex>

#include "scenes/error.h"
#include "scenes/parallel.h"
#include "scenes/subdivision_cage.h"
#include "scenes/subdivision_refiner.h"

namespace maquette {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

constexpr std::size_t kGrain = 512;  // vertices per parallel task: some ten microseconds

}  // namespace

std::unique_ptr<Far::TopologyRefiner> make_refiner(const SubdivisionCage& cage) {
  static std::once_flag silenced;  // our own Error reports faults, not the terminal
  std::call_once(silenced, [] {
    Far::SetErrorCallback([](Far::ErrorType, const char*) {});
    Far::SetWarningCallback([](const char*) {});
  });
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(cage.positions.size());
  descriptor.numFaces = static_cast<int>(cage.face_sizes.size());
  descriptor.numVertsPerFace = cage.face_sizes.data();
  descriptor.vertIndicesPerFace = cage.face_indices.data();
  descriptor.numCreases = static_cast<int>(cage.crease_edges.size());
  descriptor.creaseVertexIndexPairs = cage.crease_edges.empty() ? nullptr : cage.crease_edges[0].data();
  descriptor.creaseWeights = cage.crease_sharpness.data();

  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
  std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_CATMARK, options)));
  if (!refiner) throw Error("subdivision cage", "is no surface: its faces do not fit together", "repair the model");
  const Far::TopologyLevel& base = refiner->GetLevel(0);
  for (int e = 0; e < base.GetNumEdges(); ++e)
    if (base.IsEdgeNonManifold(e))
      throw Error("subdivision cage",
                  "edge " + std::to_string(base.GetEdgeVertices(e)[0]) + "-" +
                      std::to_string(base.GetEdgeVertices(e)[1]) +
                      " has more than two faces or faces that turn opposite ways",
                  "repair the model");
  for (int v = 0; v < base.GetNumVertices(); ++v)
    if (base.IsVertexNonManifold(v) && base.GetVertexFaces(v).size() > 0)
      throw Error("subdivision cage", "vertex " + std::to_string(v) + " joins two separate fans of faces", "split it");
  return refiner;
}

namespace {

std::unique_ptr<Far::TopologyRefiner> refine_uniformly(const SubdivisionCage& cage) {
  std::unique_ptr<Far::TopologyRefiner> refiner = make_refiner(cage);
  Far::TopologyRefiner::UniformOptions refinement(cage.levels);
  refinement.fullTopologyInLastLevel = true;  // includes the one-rings of the vertices
  refiner->RefineUniform(refinement);
  return refiner;
}

/// A smooth span of faces around a refined vertex, counter-clockwise: `edges` are the neighbours along edges, `faces`
/// those across the quads; a closed ring has as many of both, a span between two sharp edges one more edge.
struct Span {
  Sdc::Crease::Rule rule = Sdc::Crease::RULE_SMOOTH;
  std::vector<int> edges, faces;
};

/// The view of a vertex that Sdc::Scheme needs. A span is presented as a boundary vertex of its own.
struct SpanNeighborhood {
  const Span& span;
  int GetNumEdges() const { return static_cast<int>(span.edges.size()); }
  int GetNumFaces() const { return static_cast<int>(span.faces.size()); }
  void GetSharpnessPerEdge(float* sharpness) const {
    std::fill_n(sharpness, span.edges.size(), 0.0f);
    sharpness[0] = sharpness[span.edges.size() - 1] = Sdc::Crease::SHARPNESS_INFINITE;
  }
};

/// Receives the weights of Sdc::Scheme.
class SpanMask {
 public:
  using Weight = float;
  void SetNumVertexWeights(int) {}
  void SetNumEdgeWeights(int count) { edges_.resize(static_cast<std::size_t>(count), 0.0f); }
  void SetNumFaceWeights(int count) { faces_.resize(static_cast<std::size_t>(count), 0.0f); }
  void SetFaceWeightsForFaceCenters(bool) {}
  Weight& VertexWeight(int) { return vertex_; }
  Weight& EdgeWeight(int i) { return edges_[static_cast<std::size_t>(i)]; }
  Weight& FaceWeight(int i) { return faces_[static_cast<std::size_t>(i)]; }
  float vertex() const { return vertex_; }
  float edge(std::size_t i) const { return i < edges_.size() ? edges_[i] : 0.0f; }
  float face(std::size_t i) const { return i < faces_.size() ? faces_[i] : 0.0f; }

 private:
  float vertex_ = 0.0f;
  std::vector<float> edges_, faces_;
};

struct Limit {
  glm::vec3 position{0.0f}, along{0.0f}, across{0.0f};
};

float larger_principal(double e, double f, double g, double l, double m, double n) {
  const double determinant = e * g - f * f;
  if (!(determinant > 0.0)) return 0.0f;
  const double mean = 0.5 * (e * n - 2.0 * f * m + g * l) / determinant;
  const double gauss = (l * n - m * m) / determinant;
  const double root = std::sqrt(std::max(mean * mean - gauss, 0.0));
  return static_cast<float>(std::abs(mean) + root);
}

}  // namespace

struct SubdivisionEvaluator::Impl {
  std::size_t control_count = 0;
  /// Control points -> vertices of the last level: row i has stencil_index/weight[stencil_begin[i] .. stencil_begin[i +
  /// 1]).
  std::vector<std::uint32_t> stencil_begin, stencil_index;
  std::vector<float> stencil_weight;
  /// Vertices of the last level -> limit surface: weights of position and the two tangents.
  std::vector<std::uint32_t> ring_begin, ring_index;
  std::vector<glm::vec3> ring_weight;
  std::vector<char> regular;  ///< closed ring of four quads: its nine points are a piece of a uniform B-spline
  std::vector<std::uint32_t> indices;
  std::vector<glm::vec2> uvs;
  /// Neighbours of each vertex that is not regular, for its curvature.
  std::vector<std::uint32_t> neighbor_begin, neighbors;

  std::size_t vertex_count() const { return ring_begin.size() - 1; }

  void build_stencils(const Far::TopologyRefiner& refiner) {
    Far::StencilTableFactoryReal<float>::Options options;
    options.generateIntermediateLevels = false;
    options.generateOffsets = true;
    // Not by StencilTableFactory, which casts to a type that the table is not of.
    const std::unique_ptr<const Far::StencilTableReal<float>> table(
        Far::StencilTableFactoryReal<float>::Create(refiner, options));
    assert(table->GetNumStencils() == refiner.GetLevel(refiner.GetMaxLevel()).GetNumVertices());
    stencil_begin.assign(1, 0);
    for (const int size : table->GetSizes())
      stencil_begin.push_back(stencil_begin.back() + static_cast<std::uint32_t>(size));
    stencil_index.assign(table->GetControlIndices().begin(), table->GetControlIndices().end());
    stencil_weight.assign(table->GetWeights().begin(), table->GetWeights().end());
  }

  /// Adds the limit vertex of one span; returns its index.
  std::uint32_t add_vertex(int refined, const Span& span) {
    SpanMask position, along, across;
    const SpanNeighborhood neighborhood{span};
    Sdc::Scheme<Sdc::SCHEME_CATMARK> scheme;
    scheme.ComputeVertexLimitMask(neighborhood, position, along, across, span.rule);
    if (span.rule == Sdc::Crease::RULE_CORNER && span.faces.size() > 1) {
      // Sdc computes the plane of a corner from its first two edges; across several faces the tangents of a crease are
      // needed.
      SpanMask unused;
      scheme.ComputeVertexLimitMask(neighborhood, unused, along, across, Sdc::Crease::RULE_CREASE);
    }
    const auto add = [this](int index, float p, float u, float v) {
      if (p == 0.0f && u == 0.0f && v == 0.0f) return;
      ring_index.push_back(static_cast<std::uint32_t>(index));
      ring_weight.emplace_back(p, u, v);
    };
    add(refined, position.vertex(), along.vertex(), across.vertex());
    for (std::size_t i = 0; i < span.edges.size(); ++i)
      add(span.edges[i], position.edge(i), along.edge(i), across.edge(i));
    for (std::size_t i = 0; i < span.faces.size(); ++i)
      add(span.faces[i], position.face(i), along.face(i), across.face(i));
    ring_begin.push_back(static_cast<std::uint32_t>(ring_index.size()));
    regular.push_back(span.rule == Sdc::Crease::RULE_SMOOTH && span.edges.size() == 4 && span.faces.size() == 4);
    return static_cast<std::uint32_t>(ring_begin.size() - 2);
  }

  /// Splits the ring of `v` at its sharp edges, and gives each quad at `v` the limit vertex of its span.
  void add_spans(const Far::TopologyLevel& level, int v, std::vector<std::uint32_t>* corner_vertex) {
    const Far::ConstIndexArray faces = level.GetVertexFaces(v), edges = level.GetVertexEdges(v);
    const Far::ConstLocalIndexArray corners = level.GetVertexFaceLocalIndices(v);
    if (faces.size() == 0) return;
    const int face_count = faces.size(), edge_count = edges.size();
    const Sdc::Crease::Rule rule = level.GetVertexRule(v);
    const bool split = rule == Sdc::Crease::RULE_CREASE || rule == Sdc::Crease::RULE_CORNER;
    const auto is_sharp = [&](int i) {
      return level.IsEdgeBoundary(edges[i % edge_count]) || level.GetEdgeSharpness(edges[i % edge_count]) > 0.0f;
    };
    int first = 0;  // a face at the beginning of a span
    if (split && edge_count == face_count)
      while (first < face_count && !is_sharp(first)) ++first;
    Span span;
    std::vector<int> span_faces;
    const auto close = [&](bool ring) {
      span.rule = ring && split ? Sdc::Crease::RULE_SMOOTH : rule;
      const std::uint32_t vertex = add_vertex(v, span);
      for (const int i : span_faces) (*corner_vertex)[static_cast<std::size_t>(4 * faces[i] + corners[i])] = vertex;
      span = {};
      span_faces.clear();
    };
    for (int step = 0; step < face_count; ++step) {
      const int i = (first + step) % face_count;
      const Far::ConstIndexArray quad = level.GetFaceVertices(faces[i]);
      span.edges.push_back(quad[(corners[i] + 1) % 4]);
      span.faces.push_back(quad[(corners[i] + 2) % 4]);
      span_faces.push_back(i);
      if (split && is_sharp(i + 1)) {
        span.edges.push_back(quad[(corners[i] + 3) % 4]);
        close(false);
      }
    }
    if (!span_faces.empty()) close(true);
  }

  void build_limit(const Far::TopologyLevel& level) {
    ring_begin.assign(1, 0);
    std::vector<std::uint32_t> corner_vertex(static_cast<std::size_t>(4 * level.GetNumFaces()), 0);
    for (int v = 0; v < level.GetNumVertices(); ++v) add_spans(level, v, &corner_vertex);
    indices.reserve(static_cast<std::size_t>(6 * level.GetNumFaces()));
    for (std::size_t f = 0; f < corner_vertex.size(); f += 4) {
      const std::uint32_t* quad = &corner_vertex[f];
      indices.insert(indices.end(), {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]});
    }
    build_neighbors(corner_vertex);
  }

  void build_neighbors(const std::vector<std::uint32_t>& corner_vertex) {
    std::vector<std::vector<std::uint32_t>> lists(vertex_count());
    for (std::size_t corner = 0; corner < corner_vertex.size(); ++corner) {
      const std::uint32_t vertex = corner_vertex[corner];
      if (regular[vertex]) continue;
      for (std::size_t other = 1; other < 4; ++other)
        lists[vertex].push_back(corner_vertex[corner / 4 * 4 + (corner + other) % 4]);
    }
    neighbor_begin.assign(1, 0);
    for (std::vector<std::uint32_t>& list : lists) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
      neighbors.insert(neighbors.end(), list.begin(), list.end());
      neighbor_begin.push_back(static_cast<std::uint32_t>(neighbors.size()));
    }
  }

  std::vector<glm::vec3> refine(const std::vector<glm::vec3>& control) const {
    std::vector<glm::vec3> refined(stencil_begin.size() - 1);
    for_ranges(refined.size(), [&](std::size_t i) {
      glm::vec3 sum(0.0f);
      for (std::uint32_t k = stencil_begin[i]; k < stencil_begin[i + 1]; ++k)
        sum += stencil_weight[k] * control[stencil_index[k]];
      refined[i] = sum;
    });
    return refined;
  }

  Limit limit_at(const std::vector<glm::vec3>& refined, std::size_t i) const {
    Limit out;
    for (std::uint32_t k = ring_begin[i]; k < ring_begin[i + 1]; ++k) {
      const glm::vec3& point = refined[ring_index[k]];
      out.position += ring_weight[k].x * point;
      out.along += ring_weight[k].y * point;
      out.across += ring_weight[k].z * point;
    }
    return out;
  }

  template <typename Work>
  static void for_ranges(std::size_t count, const Work& work) {
    parallel_ranges<std::size_t>(0, count, kGrain, [&](const auto& range) {
      for (std::size_t i = range.begin(); i != range.end(); ++i) work(i);
    });
  }

  /// Where tangents vanish (coincident control points), uses the mean of the triangles around a vertex.
  void repair_normals(const std::vector<glm::vec3>& positions, std::vector<glm::vec3>* normals) const {
    const glm::vec3 none(0.0f);
    if (std::find(normals->begin(), normals->end(), none) == normals->end()) return;
    std::vector<glm::dvec3> sums(positions.size(), glm::dvec3(0.0));
    for (std::size_t i = 0; i < indices.size(); i += 3) {
      const glm::dvec3 a(positions[indices[i]]), b(positions[indices[i + 1]]), c(positions[indices[i + 2]]);
      for (std::size_t corner = 0; corner < 3; ++corner) sums[indices[i + corner]] += glm::cross(b - a, c - a);
    }
    for (std::size_t i = 0; i < normals->size(); ++i) {
      if ((*normals)[i] != none) continue;
      const double length = glm::length(sums[i]);
      (*normals)[i] = length > 0.0 ? glm::vec3(sums[i] / length) : glm::vec3(0.0f, 1.0f, 0.0f);
    }
  }

  /// From the second derivatives of the uniform bicubic B-spline over the ring: exact for the limit surface.
  float regular_curvature(const std::vector<glm::vec3>& refined, std::size_t i, const glm::vec3& normal) const {
    const std::uint32_t* ring = &ring_index[ring_begin[i]];
    const auto at = [&](std::size_t k) { return glm::dvec3(refined[ring[k]]); };
    // Ring order: 0 centre, 1..4 edges counter-clockwise, 5..8 across the quads; edge 1 is +u, edge 2 is +v.
    const glm::dvec3 du = (4.0 * (at(1) - at(3)) + at(5) - at(6) - at(7) + at(8)) / 12.0;
    const glm::dvec3 dv = (4.0 * (at(2) - at(4)) + at(5) + at(6) - at(7) - at(8)) / 12.0;
    const glm::dvec3 duu =
        (4.0 * (at(1) - 2.0 * at(0) + at(3)) + (at(5) - 2.0 * at(2) + at(6)) + (at(8) - 2.0 * at(4) + at(7))) / 6.0;
    const glm::dvec3 dvv =
        (4.0 * (at(2) - 2.0 * at(0) + at(4)) + (at(5) - 2.0 * at(1) + at(8)) + (at(6) - 2.0 * at(3) + at(7))) / 6.0;
    const glm::dvec3 duv = (at(5) - at(6) + at(7) - at(8)) / 4.0;
    const glm::dvec3 n(normal);
    return larger_principal(glm::dot(du, du), glm::dot(du, dv), glm::dot(dv, dv), glm::dot(duu, n), glm::dot(duv, n),
                            glm::dot(dvv, n));
  }

  /// For extraordinary vertices, which have no second derivative, and open rings: the symmetric shape operator that
  /// best maps steps to the neighbours to changes of the normal (least squares). Source: Rusinkiewicz 2004, Estimating
  /// Curvatures and Their Derivatives on Triangle Meshes, Eq. 4 (over a ring).
  float fitted_curvature(const std::vector<glm::vec3>& positions, const std::vector<glm::vec3>& normals,
                         std::size_t i) const {
    const glm::dvec3 n(normals[i]);
    const glm::dvec3 helper = std::abs(n.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 s = glm::normalize(glm::cross(n, helper)), t = glm::cross(n, s);
    glm::dmat3 normal_equations(0.0);
    glm::dvec3 right(0.0);
    for (std::uint32_t k = neighbor_begin[i]; k < neighbor_begin[i + 1]; ++k) {
      const glm::dvec3 step(positions[neighbors[k]] - positions[i]), change(normals[neighbors[k]] - normals[i]);
      const double x = glm::dot(step, s), y = glm::dot(step, t);
      const glm::dvec3 row_s(x, y, 0.0), row_t(0.0, x, y);
      normal_equations += glm::outerProduct(row_s, row_s) + glm::outerProduct(row_t, row_t);
      right += glm::dot(change, s) * row_s + glm::dot(change, t) * row_t;
    }
    const double scale = normal_equations[1][1];
    if (!(glm::determinant(normal_equations) > 1e-12 * scale * scale * scale)) return 0.0f;
    const glm::dvec3 w = glm::inverse(normal_equations) * right;
    return larger_principal(1.0, 0.0, 1.0, w.x, w.y, w.z);
  }
};

SubdivisionEvaluator::SubdivisionEvaluator(const SubdivisionCage& cage) : impl_(std::make_unique<Impl>()) {
  check_cage(cage);
  const std::unique_ptr<Far::TopologyRefiner> refiner = refine_uniformly(cage);
  impl_->control_count = cage.positions.size();
  impl_->build_stencils(*refiner);
  impl_->build_limit(refiner->GetLevel(refiner->GetMaxLevel()));
  if (cage.uvs.empty()) return;
  std::vector<glm::vec3> control;
  for (const glm::vec2& uv : cage.uvs) control.emplace_back(uv, 0.0f);
  const std::vector<glm::vec3> refined = impl_->refine(control);
  for (std::size_t i = 0; i < impl_->vertex_count(); ++i) impl_->uvs.emplace_back(impl_->limit_at(refined, i).position);
}

SubdivisionEvaluator::~SubdivisionEvaluator() = default;
SubdivisionEvaluator::SubdivisionEvaluator(SubdivisionEvaluator&&) noexcept = default;
SubdivisionEvaluator& SubdivisionEvaluator::operator=(SubdivisionEvaluator&&) noexcept = default;

void SubdivisionEvaluator::evaluate(const std::vector<glm::vec3>& control_points, std::vector<glm::vec3>* positions,
                                    std::vector<glm::vec3>* normals, std::vector<float>* curvatures) const {
  assert(control_points.size() == impl_->control_count);
  const std::vector<glm::vec3> refined = impl_->refine(control_points);
  const std::size_t count = impl_->vertex_count();
  positions->resize(count);
  normals->resize(count);
  Impl::for_ranges(count, [&](std::size_t i) {
    const Limit limit = impl_->limit_at(refined, i);
    // In double: the product of the tangents of a millimetre-sized patch at 1e-6 scale still does not underflow.
    const glm::dvec3 cross = glm::cross(glm::dvec3(limit.along), glm::dvec3(limit.across));
    const double length = glm::length(cross);
    (*positions)[i] = limit.position;
    (*normals)[i] = length > 0.0 ? glm::vec3(cross / length) : glm::vec3(0.0f);
  });
  impl_->repair_normals(*positions, normals);
  if (curvatures == nullptr) return;
  curvatures->resize(count);
  Impl::for_ranges(count, [&](std::size_t i) {
    (*curvatures)[i] = impl_->regular[i] ? impl_->regular_curvature(refined, i, (*normals)[i])
                                         : impl_->fitted_curvature(*positions, *normals, i);
  });
}

const std::vector<std::uint32_t>& SubdivisionEvaluator::indices() const { return impl_->indices; }
const std::vector<glm::vec2>& SubdivisionEvaluator::uvs() const { return impl_->uvs; }

}  // namespace maquette
