#include "render/prt/transfer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Rays start this share of the way to the middle of a triangle of the vertex: at a joint of two surfaces they stand on
/// their own side of it. In a fold that is on the triangle, on a ridge in the plane of the vertex's normal: never
/// behind the surface.
constexpr float kInset = 0.02f;
/// And this far above it, relative to the largest coordinate: above the rounding of positions and of the ray tracer.
constexpr float kLift = 1.0f / 65536.0f;

struct TexelPoints {
  std::vector<glm::vec3> directions;  ///< [direction][point]
  std::size_t count = 0;
};
TexelPoints points_of(const CubeDirections& directions, int rays) {
  TexelPoints points;
  points.count = static_cast<std::size_t>(rays * rays);
  for (Eigen::Index d = 0; d < directions.count(); ++d)
    for (int j = 0; j < rays; ++j)
      for (int i = 0; i < rays; ++i)
        points.directions.emplace_back(directions.direction_within(d, {(i + 0.5) / rays, (j + 0.5) / rays}));
  return points;
}

}  // namespace

glm::vec3 transfer_ray_origin(const TransferVertex& v) {
  const glm::vec3 inset = v.inside - v.n * std::min(glm::dot(v.inside, v.n), 0.0f);
  const glm::vec3 p = v.position + kInset * inset;
  const float largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z), glm::length(v.inside)});
  return p + v.n * (kLift * largest);
}

ArrivingLight trace_arriving_light(const TransferMesh& mesh, const CubeDirections& directions, const RayScene& scene,
                                   const ArrivingOptions& options, const std::atomic<bool>& cancel) {
  const TexelPoints points = points_of(directions, options.rays);
  std::vector<std::vector<ArrivingLight::Entry>> of_vertex(mesh.vertices.size());
  parallel_for(std::size_t{0}, mesh.vertices.size(), [&](std::size_t t) {
    if (cancel) return;
    const TransferVertex& v = mesh.vertices[t];
    const glm::vec3 origin = transfer_ray_origin(v);
    for (std::size_t d = 0; d < static_cast<std::size_t>(directions.count()); ++d) {
      glm::vec3 sum(0.0f);
      float arriving = 0.0f;
      for (std::size_t p = 0; p < points.count; ++p) {
        const glm::vec3& direction = points.directions[d * points.count + p];
        const float cosine = glm::dot(v.n, direction);
        if (!(cosine > 0.0f) || scene.is_blocked(origin, direction, 0.0f)) continue;
        arriving += cosine;
        sum += cosine * direction;
      }
      if (!(arriving > 0.0f)) continue;
      glm::vec3 local(glm::dot(v.t, sum), glm::dot(v.b, sum), glm::dot(v.n, sum));
      local.z = std::max(local.z, 1e-6f);
      of_vertex[t].push_back(
          {static_cast<std::uint16_t>(d), arriving / static_cast<float>(points.count), glm::normalize(local)});
    }
  });
  ArrivingLight light;
  if (cancel) return light;
  light.first.push_back(0);
  for (const auto& entries : of_vertex) {
    light.entries.insert(light.entries.end(), entries.begin(), entries.end());
    light.first.push_back(light.entries.size());
  }
  return light;
}

LightTable::LightTable(const ArrivingLight& arriving, const std::vector<std::uint32_t>& vertices,
                       std::shared_ptr<const DirectionMesh> lights)
    : lights_(std::move(lights)) {
  first_.push_back(0);
  for (const std::uint32_t v : vertices) first_.push_back(first_.back() + arriving.first[v + 1] - arriving.first[v]);
  entries_.resize(first_.back());
  parallel_for(std::size_t{0}, vertices.size(), [&](std::size_t i) {
    const std::size_t from = arriving.first[vertices[i]];
    for (std::size_t e = first_[i]; e < first_[i + 1]; ++e) {
      const ArrivingLight::Entry& light = arriving.entries[from + e - first_[i]];
      const DirectionWeights found = lights_->find(light.local);
      Entry& entry = entries_[e];
      entry.direction = light.direction;
      for (std::size_t k = 0; k < 3; ++k) {
        entry.light[k] = static_cast<std::uint16_t>(found.index[k]);
        entry.share[k] = light.arriving * found.weight[static_cast<int>(k)];
      }
    }
  });
}

Eigen::MatrixXf LightTable::transfer(Eigen::Index directions, const std::vector<float>& weights, int stride,
                                     int component) const {
  const auto vertices = static_cast<Eigen::Index>(first_.size()) - 1;
  std::vector<float> own(lights_->size(), 1.0f);
  if (!weights.empty())
    for (std::size_t l = 0; l < own.size(); ++l)
      own[l] = weights[l * static_cast<std::size_t>(stride) + static_cast<std::size_t>(component)];
  Eigen::MatrixXf transfer = Eigen::MatrixXf::Zero(directions, vertices);
  parallel_for(Eigen::Index{0}, vertices, [&](Eigen::Index i) {
    float* column = transfer.data() + i * directions;
    for (std::size_t e = first_[static_cast<std::size_t>(i)]; e < first_[static_cast<std::size_t>(i) + 1]; ++e) {
      const Entry& entry = entries_[e];
      column[entry.direction] = entry.share[0] * own[entry.light[0]] + entry.share[1] * own[entry.light[1]] +
                                entry.share[2] * own[entry.light[2]];
    }
  });
  return transfer;
}

std::vector<std::vector<std::uint32_t>> vertices_of_groups(const TransferMesh& mesh, std::size_t groups) {
  std::vector<std::vector<std::uint32_t>> of_group(groups);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    of_group[mesh.vertices[v].group].push_back(static_cast<std::uint32_t>(v));
  return of_group;
}

}  // namespace maquette
