#include "render/prt/bounces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "scenes/parallel.h"

namespace maquette {

namespace {

using Eigen::Index;
constexpr Index kColors = 3;
constexpr std::uint32_t kNone = ~0u;

/// The corners of the mesh around a hit, where that is the front of a part.
class HitFinder {
 public:
  HitFinder(const TransferMesh& mesh, const FlatGeometry& geometry) : mesh_(mesh), geometry_(geometry) {
    triangle_of_.assign(geometry.indices.size() / 3, kNone);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      triangle_of_[mesh.triangles[t].source] = static_cast<std::uint32_t>(t);
  }
  bool find(const RayScene::Hit& hit, const glm::vec3& origin, const glm::vec3& direction,
            TransferCorners* corners) const {
    if (triangle_of_[hit.triangle] == kNone) return false;
    const std::uint32_t* c = &geometry_.indices[3 * static_cast<std::size_t>(hit.triangle)];
    const glm::dvec3 p(geometry_.positions[c[0]]), e1 = glm::dvec3(geometry_.positions[c[1]]) - p,
                                                   e2 = glm::dvec3(geometry_.positions[c[2]]) - p;
    const glm::dvec3 normal = glm::cross(e1, e2);
    if (!(glm::dot(normal, glm::dvec3(direction)) < 0.0)) return false;
    const glm::dvec3 at = glm::dvec3(origin) + static_cast<double>(hit.distance) * glm::dvec3(direction) - p;
    const double area = glm::dot(normal, normal);
    const glm::vec2 b(glm::dot(glm::cross(at, e2), normal) / area, glm::dot(glm::cross(e1, at), normal) / area);
    *corners = find_transfer_corners(mesh_, mesh_.triangles[triangle_of_[hit.triangle]], b);
    return true;
  }

 private:
  const TransferMesh& mesh_;
  const FlatGeometry& geometry_;
  std::vector<std::uint32_t> triangle_of_;
};

/// Weighted sum of columns of `sent` into `sum`.
template <typename Share>
void add_sent(const GatheredLight& gathered, std::size_t vertex, const Eigen::MatrixXf& sent, const Share& share,
              float* sum) {
  const Index rows = sent.rows(), directions = rows / kColors;
  for (std::size_t e = gathered.first[vertex]; e < gathered.first[vertex + 1]; ++e) {
    const GatheredLight::Entry& entry = gathered.entries[e];
    const glm::vec3 scale = entry.weight * share(entry);
    const float* source = sent.data() + static_cast<Index>(entry.source) * rows;
    for (Index c = 0; c < kColors; ++c) {
      const float s = scale[static_cast<int>(c)];
      const float* from = source + c * directions;
      float* to = sum + c * directions;
      for (Index i = 0; i < directions; ++i) to[i] += s * from[i];
    }
  }
}

glm::vec3 interpolate(const DirectionMesh& lights, const std::vector<float>& shares, const glm::vec3& local) {
  const DirectionWeights w = lights.find(local);
  glm::vec3 sum(0.0f);
  for (std::size_t k = 0; k < 3; ++k)
    for (int c = 0; c < 3; ++c)
      sum[c] += w.weight[static_cast<int>(k)] * shares[static_cast<std::size_t>(kColors * w.index[k] + c)];
  return sum;
}

/// Of four texels of the finer cube, their coarser one.
Index coarse_texel(Index fine, int side) {
  const Index face = fine / (side * side), y = fine / side % side, x = fine % side, half = side / 2;
  return (face * half + y / 2) * half + x / 2;
}

}  // namespace

GatheredLight gather_light(const TransferMesh& mesh, const FlatGeometry& geometry, const CubeDirections& directions,
                           const RayScene& scene, const std::vector<std::uint32_t>& sources,
                           const std::atomic<bool>& cancel) {
  const HitFinder finder(mesh, geometry);
  std::vector<std::vector<GatheredLight::Entry>> of_vertex(mesh.vertices.size());
  parallel_for(std::size_t{0}, mesh.vertices.size(), [&](std::size_t t) {
    if (cancel || sources[t] != t) return;
    const TransferVertex& v = mesh.vertices[t];
    const glm::vec3 origin = transfer_ray_origin(v);
    std::map<std::uint32_t, std::pair<float, glm::vec3>> sums;
    for (Index d = 0; d < directions.count(); ++d) {
      const glm::vec3 direction(directions.direction(d));
      const float cosine = glm::dot(v.n, direction);
      if (!(cosine > 0.0f)) continue;
      const auto hit = scene.nearest(origin, direction, 0.0f);
      TransferCorners corners;
      if (!hit || !finder.find(*hit, origin, direction, &corners)) continue;
      const float weight = cosine * static_cast<float>(directions.solid_angles()[d]);
      for (int k = 0; k < 3; ++k) {
        if (!(corners.share[k] > 0.0f)) continue;
        auto& [sum, mean] = sums[corners.vertex[k]];
        sum += corners.share[k] * weight;
        mean += corners.share[k] * weight * direction;
      }
    }
    for (const auto& [source, sum] : sums) {
      glm::vec3 local(glm::dot(v.t, sum.second), glm::dot(v.b, sum.second), glm::dot(v.n, sum.second));
      local.z = std::max(local.z, 1e-6f * sum.first);
      of_vertex[t].push_back({source, sum.first, glm::normalize(local)});
    }
  });
  GatheredLight gathered;
  if (cancel) return gathered;
  gathered.first.push_back(0);
  for (std::size_t t = 0; t < of_vertex.size(); ++t) {
    const auto& entries = of_vertex[sources[t]];
    gathered.entries.insert(gathered.entries.end(), entries.begin(), entries.end());
    gathered.first.push_back(gathered.entries.size());
  }
  return gathered;
}

std::vector<float> reflected_shares(const Btf& material) {
  const DirectionMesh& lights = *material.views[0].lights;
  constexpr int kSteps = 12;
  std::vector<float> shares(static_cast<std::size_t>(kColors) * lights.size(), 0.0f);
  parallel_for(std::size_t{0}, lights.size(), [&](std::size_t l) {
    glm::dvec3 sum(0.0);
    for (int i = 0; i < kSteps * 4 * kSteps; ++i) {  // points of equal cosine times solid angle
      const double r2 = (i % kSteps + 0.5) / kSteps, phi = 2.0 * std::numbers::pi * (i / kSteps + 0.5) / (4 * kSteps);
      const double r = std::sqrt(r2);
      sum += glm::dvec3(evaluate_btf(material, {glm::vec2(0.5f), 1.0f}, glm::vec3(lights.directions()[l]),
                                     glm::vec3(r * std::cos(phi), r * std::sin(phi), std::sqrt(1.0 - r2))));
    }
    for (int c = 0; c < kColors; ++c)
      shares[kColors * l + static_cast<std::size_t>(c)] =
          static_cast<float>(std::clamp(std::numbers::pi * sum[c] / (4 * kSteps * kSteps), 0.0, 1.0));
  });
  return shares;
}

Bounces compute_bounces(const BounceInput& input, int count, const std::atomic<bool>& cancel) {
  Bounces bounces;
  bounces.side = std::max(input.directions.side() / 2, 1);
  const CubeDirections coarse(bounces.side);
  bounces.gathered = gather_light(input.mesh, input.geometry, coarse, input.scene, input.sources, cancel);
  if (cancel) return bounces;
  std::vector<std::vector<float>> shares;
  for (const auto& material : input.materials) shares.push_back(reflected_shares(*material));
  const auto lights_of = [&](std::size_t vertex) -> const DirectionMesh& {
    return *input.materials[input.mesh.vertices[vertex].group]->views[0].lights;
  };
  constexpr float kPerPi = std::numbers::inv_pi_v<float>;
  const Index directions = coarse.count(), rows = kColors * directions,
              vertices = static_cast<Index>(input.mesh.vertices.size());
  Eigen::MatrixXf last = Eigen::MatrixXf::Zero(rows, vertices);
  parallel_for(Index{0}, vertices, [&](Index v) {
    const auto t = static_cast<std::size_t>(v);
    const std::vector<float>& own = shares[input.mesh.vertices[t].group];
    float* column = last.data() + v * rows;
    for (std::size_t e = input.arriving.first[t]; e < input.arriving.first[t + 1]; ++e) {
      const ArrivingLight::Entry& entry = input.arriving.entries[e];
      const Index at = coarse_texel(entry.direction, input.directions.side());
      const auto part =
          static_cast<float>(input.directions.solid_angles()[entry.direction] / coarse.solid_angles()[at]);
      const glm::vec3 sent = kPerPi * entry.arriving * part * interpolate(lights_of(t), own, entry.local);
      for (Index c = 0; c < kColors; ++c) column[c * directions + at] += sent[static_cast<int>(c)];
    }
  });
  bounces.sent = last;
  for (int n = 1; n < count && !cancel; ++n) {
    Eigen::MatrixXf next = Eigen::MatrixXf::Zero(rows, vertices);
    parallel_for(Index{0}, vertices, [&](Index v) {
      const auto t = static_cast<std::size_t>(v);
      const std::vector<float>& own = shares[input.mesh.vertices[t].group];
      add_sent(
          bounces.gathered, t, last,
          [&](const GatheredLight::Entry& e) { return kPerPi * interpolate(lights_of(t), own, e.local); },
          next.data() + v * rows);
    });
    bounces.sent += next;
    last = std::move(next);
  }
  return bounces;
}

Eigen::MatrixXf add_bounces(const Eigen::MatrixXf& direct, const Bounces& bounces, const DirectionMesh& lights,
                            const std::vector<std::uint32_t>& vertices, const std::vector<float>& weights, int stride,
                            int component) {
  const Index directions = direct.rows(), coarse = bounces.sent.rows() / kColors;
  const int side = 2 * bounces.side;
  std::vector<Index> texel_of(static_cast<std::size_t>(directions));
  for (Index i = 0; i < directions; ++i) texel_of[static_cast<std::size_t>(i)] = coarse_texel(i, side);
  std::vector<float> own(lights.size(), 1.0f);
  if (!weights.empty())
    for (std::size_t l = 0; l < own.size(); ++l)
      own[l] = weights[l * static_cast<std::size_t>(stride) + static_cast<std::size_t>(component)];
  Eigen::MatrixXf all(kColors * directions, direct.cols());
  parallel_for(Index{0}, direct.cols(), [&](Index i) {
    std::vector<float> sum(static_cast<std::size_t>(kColors * coarse), 0.0f);
    add_sent(
        bounces.gathered, vertices[static_cast<std::size_t>(i)], bounces.sent,
        [&](const GatheredLight::Entry& e) {
          const DirectionWeights w = lights.find(e.local);
          float h = 0.0f;
          for (std::size_t k = 0; k < 3; ++k)
            h += w.weight[static_cast<int>(k)] * own[static_cast<std::size_t>(w.index[k])];
          return glm::vec3(h);
        },
        sum.data());
    for (Index c = 0; c < kColors; ++c)
      for (Index d = 0; d < directions; ++d)
        all(c * directions + d, i) =
            direct(d, i) + sum[static_cast<std::size_t>(c * coarse + texel_of[static_cast<std::size_t>(d)])];
  });
  return all;
}

}  // namespace maquette
