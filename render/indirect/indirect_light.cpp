#include "render/indirect/indirect_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/indirect/sky_rays.h"
#include "render/math/shared_formulas.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr std::size_t kCells = std::size_t{kVisibilitySide} * kVisibilitySide;
constexpr int kMaxBounces = 16;
/// Bounces end when the last one changed every point's light by less than this share of the brightest mean.
constexpr float kConvergedShare = 1e-3f;
constexpr int kSmoothingRounds = 2;

float largest(const glm::vec3& v) { return std::max({v.x, v.y, v.z}); }

glm::vec3 unpack_color(std::uint32_t c) {
  return glm::vec3(static_cast<float>(c & 1023u), static_cast<float>((c >> 10) & 1023u), static_cast<float>(c >> 20)) *
         (1.0f / 1023.0f);
}

struct CellSum {
  glm::dvec3 irradiance{0.0}, direction{0.0};
  double weight = 0.0;
};

/// Angular size up to which texels are merged: a ninth of a cell of the map.
constexpr double kBlock_rad = 0.025;

int block_side(const Environment& e) {
  return std::max(1, static_cast<int>(kBlock_rad * e.width / (2.0 * std::numbers::pi)));
}

/// Light of `side` x `side` texels and the position of its centre in the map.
struct SkyBlock {
  glm::dvec3 irradiance{0.0};
  glm::dvec2 uv{0.0};   ///< weighted by light
  double weight = 0.0;  ///< luminance times solid angle
};

SkyBlock sum_block(const Environment& e, int column, int row, int side) {
  SkyBlock block;
  for (int y = row; y < std::min(row + side, e.height); ++y) {
    const double top = std::cos(std::numbers::pi * y / e.height),
                 bottom = std::cos(std::numbers::pi * (y + 1) / e.height);
    const double solid_angle = 2.0 * std::numbers::pi / e.width * (top - bottom);
    for (int x = column; x < std::min(column + side, e.width); ++x) {
      const glm::vec3& rgb =
          e.rgb[static_cast<std::size_t>(y) * static_cast<std::size_t>(e.width) + static_cast<std::size_t>(x)];
      const double light = solid_angle * static_cast<double>(luminance(rgb));
      if (!(light > 0.0)) continue;
      block.irradiance += solid_angle * glm::dvec3(rgb);
      block.uv += light * glm::dvec2((x + 0.5) / e.width, (y + 0.5) / e.height);
      block.weight += light;
    }
  }
  return block;
}

void splat_block(const SkyBlock& block, const glm::vec3& d, double scale, std::array<CellSum, kCells>* sums) {
  const shared::VisibilityCorner corner = shared::visibility_corner(d);
  for (int k = 0; k < 4; ++k) {
    const glm::ivec2 cell = shared::visibility_wrap(corner.lower + glm::ivec2(k & 1, k >> 1));
    const float w =
        (k & 1 ? corner.fraction.x : 1.0f - corner.fraction.x) * (k & 2 ? corner.fraction.y : 1.0f - corner.fraction.y);
    CellSum& sum = (*sums)[static_cast<std::size_t>(cell.y * kVisibilitySide + cell.x)];
    const double weight = static_cast<double>(w) * scale;
    sum.irradiance += weight * block.irradiance;
    sum.direction += weight * block.weight * glm::dvec3(d);
    sum.weight += weight * block.weight;
  }
}

/// Adds the rows of blocks `first` to `last`.
void splat_rows(const IndirectSky& sky, int first, int last, std::array<CellSum, kCells>* sums) {
  const Environment& e = *sky.environment;
  const float cosine = std::cos(sky.rotation_rad), sine = std::sin(sky.rotation_rad);
  const int side = block_side(e);
  for (int row = first * side; row < last * side; row += side) {
    for (int column = 0; column < e.width; column += side) {
      const SkyBlock block = sum_block(e, column, row, side);
      if (!(block.weight > 0.0)) continue;
      const glm::vec3 d = shared::direction_from_latlong_uv(glm::vec2(block.uv / block.weight));
      splat_block(block, shared::latlong_rotate(d, cosine, sine), static_cast<double>(sky.scale), sums);
    }
  }
}

/// The sky's cells as a structure of arrays, for SIMD sums over eight cells.
struct SkyLanes {
  static constexpr std::size_t kLanes = 8;
  std::array<float, kCells> red, green, blue, x, y, z;
  std::array<std::uint8_t, kCells / kLanes> lit{};  ///< one bit per cell that is not black
  explicit SkyLanes(const SkyCells& sky) {
    for (std::size_t b = 0; b < kCells; ++b) {
      red[b] = sky.irradiance[b].x, green[b] = sky.irradiance[b].y, blue[b] = sky.irradiance[b].z;
      x[b] = sky.direction[b].x, y[b] = sky.direction[b].y, z[b] = sky.direction[b].z;
      if (largest(sky.irradiance[b]) > 0.0f) lit[b / kLanes] |= static_cast<std::uint8_t>(1u << (b % kLanes));
    }
  }
};

/// 1 for each bit of a byte that is set, else 0.
struct BitLanes {
  std::array<std::array<float, SkyLanes::kLanes>, 256> of{};
  constexpr BitLanes() {
    for (std::size_t byte = 0; byte < 256; ++byte)
      for (std::size_t k = 0; k < SkyLanes::kLanes; ++k) of[byte][k] = (byte >> k) & 1u ? 1.0f : 0.0f;
  }
};
constexpr BitLanes kBitLanes;

struct TwoSided {
  glm::vec3 front{0.0f}, back{0.0f};
};

/// Direct irradiance of the sky on the two sides of a point.
TwoSided direct_irradiance(const VisibilityBits& bits, const glm::vec3& normal, const SkyLanes& sky) {
  constexpr std::size_t kLanes = SkyLanes::kLanes;
  std::array<float, kLanes> red{}, green{}, blue{}, red_back{}, green_back{}, blue_back{};
  for (std::size_t byte = 0; byte < kCells / kLanes; ++byte) {
    const std::uint32_t open = (bits[byte / 4] >> (8u * (byte % 4u))) & sky.lit[byte];
    if (open == 0) continue;
    const std::array<float, kLanes>& mask = kBitLanes.of[open];
    const std::size_t b = byte * kLanes;
    for (std::size_t k = 0; k < kLanes; ++k) {
      const float cosine = normal.x * sky.x[b + k] + normal.y * sky.y[b + k] + normal.z * sky.z[b + k];
      const float w = mask[k] * std::max(cosine, 0.0f), w_back = mask[k] * std::max(-cosine, 0.0f);
      red[k] += w * sky.red[b + k];
      green[k] += w * sky.green[b + k];
      blue[k] += w * sky.blue[b + k];
      red_back[k] += w_back * sky.red[b + k];
      green_back[k] += w_back * sky.green[b + k];
      blue_back[k] += w_back * sky.blue[b + k];
    }
  }
  TwoSided sum;
  for (std::size_t k = 0; k < kLanes; ++k) {
    sum.front += glm::vec3(red[k], green[k], blue[k]);
    sum.back += glm::vec3(red_back[k], green_back[k], blue_back[k]);
  }
  return sum;
}

template <typename Body>
void for_slots(std::size_t count, const std::atomic<bool>& cancel, const Body& body) {
  parallel_ranges<std::size_t>(0, count, 256, [&](const auto& range) {
    if (cancel) return;
    for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
  });
}

void add_share(float share, const glm::vec3& value, glm::vec3* sum) { *sum += share * value; }
void add_share(float share, const IndirectRadiance& value, IndirectRadiance* sum) {
  sum->mean += share * value.mean;
  sum->gradient += share * value.gradient;
}

/// Averages [side][point] with the neighbours on the same smooth surface, which have other rays: this reduces the
/// noise.
template <typename Value>
void smooth(const IndirectLinks& links, std::vector<Value>* values, std::vector<Value>* spare,
            const std::atomic<bool>& cancel) {
  const std::size_t count = links.points.points.size();
  spare->resize(values->size());
  for_slots(values->size(), cancel, [&](std::size_t slot) {
    const std::size_t point = slot % count, side = slot - point;
    Value sum{};
    add_share(links.own_weight[point], (*values)[slot], &sum);
    for (std::uint32_t k = links.first_neighbour[point]; k < links.first_neighbour[point + 1]; ++k)
      add_share(links.neighbours[k].weight, (*values)[side + links.neighbours[k].point], &sum);
    (*spare)[slot] = sum;
  });
  values->swap(*spare);
}

/// Radiance that arrives at each slot when the targets of its rays reflect their `irradiance`.
void gather(const IndirectLinks& links, const std::vector<glm::vec3>& irradiance,
            std::vector<IndirectRadiance>* radiance, const std::atomic<bool>& cancel) {
  const std::size_t count = links.points.points.size(), rays = static_cast<std::size_t>(links.rays);
  std::vector<glm::vec3> pattern;
  for (int r = 0; r < links.rays; ++r) pattern.push_back(indirect_ray_direction(r, links.rays));
  for_slots(radiance->size(), cancel, [&](std::size_t slot) {
    const std::size_t index = slot % count;
    glm::vec3 mean(0.0f), along(0.0f), across(0.0f);
    for (std::size_t r = 0; r < rays; ++r) {
      const IndirectLink& link = links.links[slot * rays + r];
      if (link.target == kNoPoint) continue;
      const glm::vec3 l = unpack_color(link.color) * irradiance[link.target];
      mean += l;
      along += l * pattern[r].x;
      across += l * pattern[r].y;
    }
    const IndirectFrame frame = indirect_frame(links.points.points[index], index, slot < count ? 0 : 1);
    // The cosine-weighted mean of x^2 is 1/4.
    const float scale = std::numbers::inv_pi_v<float> / static_cast<float>(links.rays);
    (*radiance)[slot].mean = mean * scale;
    for (int c = 0; c < 3; ++c)
      (*radiance)[slot].gradient[c] = 4.0f * scale * (along[c] * frame.t + across[c] * frame.b);
  });
}

}  // namespace

SkyCells splat_sky(const IndirectSky& sky) {
  std::array<CellSum, kCells> total{};
  const int side = block_side(*sky.environment), rows = (sky.environment->height + side - 1) / side;
  // A fixed number of parts, added in order, so that the sum does not depend on the number of threads.
  constexpr int kParts = 16;
  std::vector<std::array<CellSum, kCells>> parts(kParts);
  parallel_for(0, kParts, [&](int part) {
    splat_rows(sky, rows * part / kParts, rows * (part + 1) / kParts, &parts[static_cast<std::size_t>(part)]);
  });
  SkyCells cells;
  for (std::size_t b = 0; b < kCells; ++b) {
    for (const auto& part : parts) {
      total[b].irradiance += part[b].irradiance;
      total[b].direction += part[b].direction;
      total[b].weight += part[b].weight;
    }
    cells.irradiance.emplace_back(total[b].irradiance);
    cells.direction.emplace_back(total[b].weight > 0.0 ? total[b].direction / total[b].weight : glm::dvec3(0.0));
  }
  return cells;
}

std::vector<glm::vec3> sky_irradiance(const IndirectLinks& links, const VisibilityBake& bits, const IndirectSky& sky,
                                      SkyLight by, const std::atomic<bool>& cancel) {
  const SkyCells cells = splat_sky(sky);
  const SkyLanes lanes(cells);
  const std::size_t count = links.points.points.size(), slots = count * static_cast<std::size_t>(links.sides);
  std::vector<glm::vec3> direct(slots);
  for_slots(count, cancel, [&](std::size_t i) {
    const std::uint32_t vertex = links.vertex_of_point[i];
    if (vertex == kNoPoint) return;
    const TwoSided light = direct_irradiance(bits.vertices[vertex], links.points.points[i].normal, lanes);
    direct[i] = light.front * bits.transmittance[vertex][0];
    if (links.sides == 2) direct[count + i] = light.back * bits.transmittance[vertex][1];
  });
  if (by == SkyLight::rays) {
    std::vector<glm::vec3> error = error_of_maps(links, bits, sky, cells, cancel), spare;
    for (int round = 0; round < kSmoothingRounds && !cancel; ++round) smooth(links, &error, &spare, cancel);
    for (std::size_t i = 0; i < slots; ++i) direct[i] = glm::max(direct[i] + error[i], 0.0f);
  }
  return direct;
}

std::optional<IndirectSolution> solve_indirect(const IndirectLinks& links, const VisibilityBake& bits,
                                               const IndirectSky& sky, IndirectBounces bounces,
                                               const IndirectSolution* before, const std::atomic<bool>& cancel) {
  const std::size_t slots = links.points.points.size() * static_cast<std::size_t>(links.sides);
  std::vector<glm::vec3> direct =
      sky_irradiance(links, bits, sky, bounces == IndirectBounces::all ? SkyLight::rays : SkyLight::maps, cancel);
  for (std::size_t i = 0; i < links.lamps.size(); ++i) direct[i] += links.lamps[i];
  IndirectSolution s;
  s.radiance.resize(slots);
  const bool step = bounces == IndirectBounces::step && before && before->bounced.size() == slots;
  s.bounced = step ? before->bounced : std::vector<glm::vec3>(slots, glm::vec3(0.0f));
  std::vector<glm::vec3> irradiance(slots);
  for (int bounce = 0; bounce < (step ? 1 : kMaxBounces) && !cancel; ++bounce) {
    for_slots(slots, cancel, [&](std::size_t i) { irradiance[i] = direct[i] + s.bounced[i]; });
    gather(links, irradiance, &s.radiance, cancel);
    double change = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < slots; ++i) {
      const glm::vec3 arrives = s.radiance[i].mean * std::numbers::pi_v<float>;
      change += static_cast<double>(largest(glm::abs(arrives - s.bounced[i])));
      sum += static_cast<double>(largest(direct[i] + arrives));
      s.bounced[i] = arrives;
    }
    if (change <= static_cast<double>(kConvergedShare) * sum) break;
  }
  std::vector<IndirectRadiance> spare;
  for (int round = 0; round < kSmoothingRounds && !cancel; ++round) smooth(links, &s.radiance, &spare, cancel);
  if (cancel) return std::nullopt;
  return s;
}

IndirectBake pack_indirect(const IndirectLinks& links, const std::vector<IndirectRadiance>& radiance) {
  IndirectBake bake;
  bake.sides = links.sides;
  float peak = 0.0f;
  for (const IndirectRadiance& r : radiance) peak = std::max(peak, largest(r.mean));
  // Bias for which the largest value is just representable: 31 is the top exponent, of steps of 2^(31 - bias).
  bake.bias = peak > 0.0f ? std::clamp(31 + 8 - std::ilogb(peak), -80, 120) : 0;
  const std::size_t count = links.points.points.size(), vertices = links.points.point_of_vertex.size();
  bake.vertices.assign(vertices * static_cast<std::size_t>(links.sides), glm::uvec4(0u));
  for (std::size_t i = 0; i < bake.vertices.size(); ++i) {
    const std::uint32_t point = links.points.point_of_vertex[i % vertices];
    if (point == kNoPoint) continue;
    const IndirectRadiance& r = radiance[point + (i < vertices ? 0 : count)];
    bake.vertices[i] = shared::pack_indirect(r.mean, r.gradient[0], r.gradient[1], r.gradient[2], bake.bias);
  }
  return bake;
}

}  // namespace maquette
