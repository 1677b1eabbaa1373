#include "scenes/subdivision_patches.h"

#include <opensubdiv/far/patchMap.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/ptexIndices.h>

#include <algorithm>
#include <map>

#include "scenes/subdivision_refiner.h"

namespace maquette {

namespace {

namespace Far = OpenSubdiv::Far;

/// The type that OpenSubdiv interpolates.
struct Point {
  glm::dvec3 p{0.0};
  void Clear() { p = glm::dvec3(0.0); }
  void AddWithWeight(const Point& other, double weight) { p += weight * other.p; }
};

/// Vertices of all levels, followed by the additional points of the caps.
std::vector<Point> all_points(const Far::TopologyRefiner& refiner, const Far::PatchTable& table,
                              const std::vector<glm::vec3>& control) {
  std::vector<Point> points(static_cast<std::size_t>(refiner.GetNumVerticesTotal() + table.GetNumLocalPoints()));
  for (std::size_t k = 0; k < control.size(); ++k) points[k].p = glm::dvec3(control[k]);
  const Far::PrimvarRefinerReal<double> primvars(refiner);
  Point* from = points.data();
  for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
    Point* to = from + refiner.GetLevel(level - 1).GetNumVertices();
    primvars.Interpolate(level, from, to);
    from = to;
  }
  if (table.GetNumLocalPoints() > 0)
    table.GetLocalPointStencilTable<double>()->UpdateValues(points.data(),
                                                            points.data() + refiner.GetNumVerticesTotal());
  return points;
}

/// Position of a face in the domain of PatchMap.
struct Quad {
  int face = 0;
  std::array<glm::dvec2, 4> corners{};
};

/// The uniformly refined faces in their order: those of a face follow its corners (Far::TopologyLevel).
std::vector<Quad> refined_quads(const SubdivisionCage& cage, const Far::PtexIndices& ptex) {
  const std::array<glm::dvec2, 4> unit{glm::dvec2(0.0, 0.0), {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}};
  const auto children = [](const Quad& q, std::vector<Quad>* out) {
    const glm::dvec2 middle = 0.25 * (q.corners[0] + q.corners[1] + q.corners[2] + q.corners[3]);
    for (std::size_t k = 0; k < 4; ++k) {
      Quad child{q.face, {}};
      child.corners[k] = q.corners[k];
      child.corners[(k + 1) % 4] = 0.5 * (q.corners[k] + q.corners[(k + 1) % 4]);
      child.corners[(k + 2) % 4] = middle;
      child.corners[(k + 3) % 4] = 0.5 * (q.corners[k] + q.corners[(k + 3) % 4]);
      out->push_back(child);
    }
  };
  std::vector<Quad> quads;
  for (std::size_t f = 0; f < cage.face_sizes.size(); ++f) {
    const int first = ptex.GetFaceId(static_cast<int>(f));
    if (cage.face_sizes[f] == 4) {
      children({first, unit}, &quads);
    } else {
      for (int k = 0; k < cage.face_sizes[f]; ++k) quads.push_back({first + k, unit});
    }
  }
  for (int level = 1; level < cage.levels; ++level) {
    std::vector<Quad> finer;
    for (const Quad& q : quads) children(q, &finer);
    quads = std::move(finer);
  }
  return quads;
}

/// Bezier control values of the cubic that has these values at 0, 1/3, 2/3 and 1.
std::array<glm::dvec3, 4> through(const std::array<glm::dvec3, 4>& f) {
  return {f[0], (-5.0 * f[0] + 18.0 * f[1] - 9.0 * f[2] + 2.0 * f[3]) / 6.0,
          (2.0 * f[0] - 9.0 * f[1] + 18.0 * f[2] - 5.0 * f[3]) / 6.0, f[3]};
}

}  // namespace

LimitPatches make_limit_patches(const SubdivisionCage& cage, int isolation) {
  const std::unique_ptr<Far::TopologyRefiner> refiner = make_refiner(cage);
  const int level = std::min(isolation, cage.levels);
  refiner->RefineAdaptive(Far::TopologyRefiner::AdaptiveOptions(level));
  Far::PatchTableFactory::Options options(static_cast<unsigned>(level));
  options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_GREGORY_BASIS);
  options.SetPatchPrecision<double>();
  const std::unique_ptr<const Far::PatchTable> table(Far::PatchTableFactory::Create(*refiner, options));
  const std::vector<Point> points = all_points(*refiner, *table, cage.positions);
  const Far::PatchMap map(*table);
  LimitPatches out;
  std::map<Far::Index, int> number;  // of the patches that are needed, by OpenSubdiv's index
  const auto add_patch = [&](const Far::PatchTable::PatchHandle& handle) {
    const Far::PatchParam param = table->GetPatchParam(handle);
    const Far::ConstIndexArray vertices = table->GetPatchVertices(handle);
    // A bicubic polynomial is determined by 4 x 4 of its points.
    const double size = param.GetParamFraction(), u0 = param.GetU() * size, v0 = param.GetV() * size;
    std::array<glm::dvec3, 16> rows{}, patch{};
    for (std::size_t j = 0; j < 4; ++j) {
      std::array<glm::dvec3, 4> row{};
      for (std::size_t i = 0; i < 4; ++i) {
        double weights[20];
        table->EvaluateBasis(handle, u0 + size * static_cast<double>(i) / 3.0, v0 + size * static_cast<double>(j) / 3.0,
                             weights);
        for (int k = 0; k < vertices.size(); ++k)
          row[i] += weights[k] * points[static_cast<std::size_t>(vertices[k])].p;
      }
      const std::array<glm::dvec3, 4> control = through(row);
      std::copy(control.begin(), control.end(), rows.begin() + static_cast<std::ptrdiff_t>(4 * j));
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const std::array<glm::dvec3, 4> control = through({rows[i], rows[4 + i], rows[8 + i], rows[12 + i]});
      for (std::size_t j = 0; j < 4; ++j) patch[4 * j + i] = control[j];
    }
    out.points.push_back(patch);
    out.exact.push_back(param.IsRegular());
  };
  for (const Quad& quad : refined_quads(cage, Far::PtexIndices(*refiner))) {
    const glm::dvec2 middle = 0.25 * (quad.corners[0] + quad.corners[1] + quad.corners[2] + quad.corners[3]);
    const Far::PatchMap::Handle* handle = map.FindPatch(quad.face, middle.x, middle.y);
    int patch = -1;
    std::array<glm::dvec2, 4> x{};
    if (handle != nullptr) {
      const auto [known, is_new] = number.emplace(handle->patchIndex, static_cast<int>(out.points.size()));
      if (is_new) add_patch(*handle);
      patch = known->second;
      const Far::PatchParam param = table->GetPatchParam(*handle);
      const double size = param.GetParamFraction();
      for (std::size_t k = 0; k < 4; ++k)
        x[k] = 2.0 * (quad.corners[k] / size - glm::dvec2(param.GetU(), param.GetV())) - 1.0;
    }
    for (const std::array<std::size_t, 3>& corners : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
      out.patch_of_triangle.push_back(patch);
      out.x.push_back({x[corners[0]], x[corners[1]], x[corners[2]]});
    }
  }
  return out;
}

}  // namespace maquette
