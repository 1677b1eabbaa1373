#include "render/reflections/mirrored_bound.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/frame/camera.h"
#include "render/frame/constants.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr float kCell_rad = std::numbers::pi_v<float> / 36.0f;  // size of the cells of directions
constexpr std::size_t kPartTriangles = 48;
/// Interpolated normals, and those of a patch's true surface, leave the cone of the vertex normals by no more than
/// this.
constexpr float kNormalDeviation_rad = 0.02f;
/// Parts whose rays spread more (half angle of their cone) get no bound: they are always traced.
constexpr float kMaxSpread_rad = 0.7f;
constexpr float kUnbounded = 1e30f;  // cd/m2
constexpr float kFaint = 1.0f;       // cd/m2; fainter highlights of lamps are ignored
constexpr float kNear_m = 1e-4f;
constexpr float kOwnFacet_m = 2e-3f;
constexpr std::uint32_t kShadowTests = 8;  // points of a cluster, at least

float safe_acos(float c) { return std::acos(std::clamp(c, -1.0f, 1.0f)); }

/// Cell of a world direction in rows of latitude.
std::size_t direction_cell(const glm::vec3& d, int columns, int rows) {
  const int row =
      std::clamp(static_cast<int>(safe_acos(d.y) / std::numbers::pi_v<float> * static_cast<float>(rows)), 0, rows - 1);
  const float turn = (std::atan2(d.x, d.z) / std::numbers::pi_v<float> + 1.0f) * 0.5f;
  const int column = std::clamp(static_cast<int>(turn * static_cast<float>(columns)), 0, columns - 1);
  return static_cast<std::size_t>(row * columns + column);
}

glm::vec3 cell_direction(float column, float row, int columns, int rows) {
  const float theta = std::numbers::pi_v<float> * row / static_cast<float>(rows),
              phi = std::numbers::pi_v<float> * (2.0f * column / static_cast<float>(columns) - 1.0f);
  return {std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi)};
}

}  // namespace

void MirroredBound::set_geometry(const FlatGeometry& geometry, const std::vector<bool>& occluding,
                                 const std::vector<Reflector>& reflectors) {
  parts_.clear();
  part_of_triangle_.clear();
  first_of_reflector_.clear();
  clusters_ = make_clusters(geometry);
  positions_ = geometry.positions;
  normals_.resize(geometry.indices.size() / 3);
  parallel_for(std::size_t{0}, normals_.size(), [&](std::size_t t) {
    const auto corner = [&](std::size_t k) { return geometry.normals[geometry.indices[3 * t + k]]; };
    const glm::vec3 sum = corner(0) + corner(1) + corner(2);
    const glm::vec3 mean = glm::length(sum) > 1e-6f ? glm::normalize(sum) : corner(0);
    const float least = std::min({glm::dot(mean, corner(0)), glm::dot(mean, corner(1)), glm::dot(mean, corner(2))});
    normals_[t] = glm::vec4(mean, safe_acos(least) + kNormalDeviation_rad);
  });
  lit_.assign(clusters_.clusters.size(), Lit());
  cluster_of_.assign(geometry.indices.size() / 3, 0u);
  for (std::size_t i = 0; i < clusters_.of_item.size(); ++i) {
    if (!occluding[i]) continue;
    for (std::size_t c = clusters_.of_item[i].begin; c < clusters_.of_item[i].end; ++c) {
      const Cluster& cluster = clusters_.clusters[c];
      lit_[c].item = i;
      lit_[c].center = cluster.center;
      for (std::uint32_t t = 0; t < cluster.triangle_count; ++t)
        cluster_of_[clusters_.triangles[cluster.first_triangle + t].y] = static_cast<std::uint32_t>(c);
    }
  }
  for (const Reflector& reflector : reflectors) add_parts(geometry, reflector);
  rays_ = build_ray_scene(geometry, occluding);
}

void MirroredBound::add_parts(const FlatGeometry& geometry, const Reflector& reflector) {
  const DrawItem& item = geometry.items[reflector.item];
  const std::vector<std::uint32_t> order = order_along_curve(geometry, item);
  first_of_reflector_.push_back(static_cast<std::uint32_t>(part_of_triangle_.size()));
  part_of_triangle_.resize(part_of_triangle_.size() + order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k % kPartTriangles == 0) {
      parts_.emplace_back();
      parts_.back().item = reflector.item;
    }
    Part& part = parts_.back();
    part_of_triangle_[first_of_reflector_.back() + order[k] - item.first_index / 3] =
        static_cast<std::uint32_t>(parts_.size() - 1);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = geometry.indices[3 * static_cast<std::size_t>(order[k]) + corner];
      part.positions.push_back(geometry.positions[v]);
      part.normals.push_back(geometry.normals[v]);
      part.bounds.min = glm::min(part.bounds.min, geometry.positions[v]);
      part.bounds.max = glm::max(part.bounds.max, geometry.positions[v]);
    }
  }
}

MirroredBound::Cell MirroredBound::test_cell(const Part& part, std::size_t number) const {
  Cell cell;
  const auto row = static_cast<float>(number / kColumns), column = static_cast<float>(number % kColumns);
  for (int k = 0; k < kTests; ++k) {
    // Low-discrepancy sequence of dimension 4 (Roberts 2018): two for the origin, two for the direction.
    const auto part_of = [&](double g) {
      return static_cast<float>(std::fmod((static_cast<double>(number) * kTests + k) * g + 0.5, 1.0));
    };
    const auto triangle =
        3 * static_cast<std::size_t>(part_of(0.8566748838545029) * static_cast<float>(part.positions.size() / 3));
    const glm::vec3 d =
        cell_direction(column + part_of(0.7338918566271259), row + part_of(0.6287067210378087), kColumns, kRows);
    const glm::vec3 side =
        glm::mix(part.positions[triangle], part.positions[triangle + 1], part_of(0.5385972572236101));
    const glm::vec3 origin = glm::mix(side, part.positions[triangle + 2], 0.5f);
    const auto met = rays_.nearest(origin, d, kNear_m);
    if (!met) {
      cell.sky = true;
      continue;
    }
    const std::uint32_t triangle_met = met->triangle;
    const glm::vec3 normal(normals_[triangle_met]);
    cell.met.push_back(
        {cluster_of_[triangle_met], glm::dot(normal, d) > 0.0f ? -normal : normal, -d, normals_[triangle_met].w});
  }
  return cell;
}

void MirroredBound::set_light(const BoundLight& light) {
  ++light_version_;
  light_ = light;
  const auto to_world = [&](const glm::vec3& d) {
    return glm::vec3(light.cosine * d.x + light.sine * d.z, d.y, -light.sine * d.x + light.cosine * d.z);
  };
  lamps_ = light.sky->lamps;
  for (SkyBound::Lamp& lamp : lamps_) {
    lamp.direction = to_world(lamp.direction);
    lamp.irradiance *= light.scale;
  }
  sky_out_.assign(static_cast<std::size_t>(kRows * kColumns), 0.0f);
  for (int y = 0; y < SkyBound::kHeight; ++y)
    for (int x = 0; x < SkyBound::kWidth; ++x) {
      const glm::vec3 d(direction_from_latlong(x + 0.5, y + 0.5, SkyBound::kWidth, SkyBound::kHeight));
      float& out = sky_out_[direction_cell(to_world(d), kColumns, kRows)];
      out = std::max(out, light.scale * light.sky->largest[static_cast<std::size_t>(y * SkyBound::kWidth + x)]);
    }
  parallel_for(std::size_t{0}, lit_.size(), [&](std::size_t c) {
    if (!light_.surfaces.empty()) light_cluster(&lit_[c], c);
  });
}

void MirroredBound::light_cluster(Lit* lit, std::size_t number) const {
  const BoundSurface& surface = light_.surfaces[lit->item];
  const LobeBound& lobe = light_.lobes[static_cast<std::size_t>(surface.lobe)];
  const Cluster& cluster = clusters_.clusters[number];
  lit->lamps.clear();
  for (std::uint32_t l = 0; l < lamps_.size(); ++l) {
    const SkyBound::Lamp& lamp = lamps_[l];
    if (lamp.irradiance * lobe.largest() < kFaint) continue;
    bool lit_by = !light_.shadows;
    for (std::uint32_t k = 0; k < cluster.vertex_count && !lit_by; k += 1 + cluster.vertex_count / kShadowTests) {
      const glm::vec3& at = positions_[clusters_.vertices[cluster.first_vertex + k]];
      // Moved towards the cluster's centre, so that triangles next to an edge do not hide the lamp.
      lit_by = !rays_.is_blocked(glm::mix(at, lit->center, 0.05f), lamp.direction, kOwnFacet_m) ||
               !rays_.is_blocked(at, lamp.direction, kOwnFacet_m);
    }
    if (!lit_by) continue;
    lit->lamps.push_back(l);
  }
}

float MirroredBound::radiance_of(const Met& met) const {
  const Lit& lit = lit_[met.cluster];
  const BoundSurface& surface = light_.surfaces[lit.item];
  const LobeBound& lobe = light_.lobes[static_cast<std::size_t>(surface.lobe)];
  const float spread_rad = surface.normal_mapped ? std::numbers::pi_v<float> : met.normal_spread_rad;
  float sum = surface.emission;
  for (const std::uint32_t l : lit.lamps) {
    const SkyBound::Lamp& lamp = lamps_[l];
    if (glm::dot(lamp.direction, met.normal) <
        -std::sin(std::min(spread_rad + lamp.radius_rad, 0.5f * std::numbers::pi_v<float>)))
      continue;
    const glm::vec3 h = lamp.direction + met.wo;
    const float length = glm::length(h), move = 0.5f * (kCell_rad + lamp.radius_rad);
    // The half vector rotates by half the rotation of either direction; across their common plane by 1 / cos(theta_d)
    // more.
    const float theta_d = safe_acos(0.5f * length), cosine_d = std::cos(theta_d + move);
    float theta = 0.0f;
    if (length > 1e-4f && cosine_d > 0.02f)
      theta = std::max(safe_acos(glm::dot(h, met.normal) / length) - spread_rad - move / cosine_d, 0.0f);
    sum +=
        lamp.irradiance * lobe.peak_beyond(theta, std::max(cosine_d, 0.0f), std::cos(std::max(theta_d - move, 0.0f)));
  }
  return sum;
}

float MirroredBound::bound_of_cell(Part* part, std::size_t number) const {
  const auto [found, is_new] = part->seen.try_emplace(number);
  Cell& cell = found->second;
  if (is_new) cell = test_cell(*part, number);
  if (cell.light != light_version_) {
    cell.bound = cell.sky ? sky_out_[number] : 0.0f;
    for (const Met& met : cell.met) cell.bound = std::max(cell.bound, radiance_of(met));
    cell.light = light_version_;
  }
  return cell.bound;
}

float MirroredBound::bound_of(Part* part, const FrameConstants& frame) const {
  std::vector<glm::vec3> directions;
  for (std::size_t k = 0; k < part->positions.size(); ++k) {
    const glm::vec3 v = from_eye(frame, part->positions[k]);
    if (glm::length(v) < 1e-6f) return kUnbounded;
    directions.push_back(glm::reflect(glm::normalize(v), part->normals[k]));
  }
  Beam beam = make_beam(part->positions, directions);
  const float half = safe_acos(beam.cosine) + kNormalDeviation_rad;
  if (half > kMaxSpread_rad) return kUnbounded;
  const float cone_rad = half + 0.7072f * kCell_rad;
  float most = 0.0f;
  const float theta = safe_acos(beam.axis.y);
  const int first = static_cast<int>((theta - cone_rad) / kCell_rad),
            last = static_cast<int>((theta + cone_rad) / kCell_rad);
  for (int row = std::max(first, 0); row <= std::min(last, kRows - 1); ++row)
    for (int column = 0; column < kColumns; ++column) {
      const glm::vec3 d =
          cell_direction(static_cast<float>(column) + 0.5f, static_cast<float>(row) + 0.5f, kColumns, kRows);
      if (glm::dot(d, beam.axis) < std::cos(cone_rad)) continue;
      most = std::max(most, bound_of_cell(part, static_cast<std::size_t>(row * kColumns + column)));
    }
  return most;
}

std::vector<float> MirroredBound::compute(const FrameConstants& frame) {
  std::vector<float> bounds(parts_.size(), 0.0f);
  parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t p) {
    if (may_be_seen(frame.clip_from_world, parts_[p].bounds)) bounds[p] = bound_of(&parts_[p], frame);
  });
  return bounds;
}

}  // namespace maquette
