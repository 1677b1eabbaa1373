#include "render/octree/cell_brdf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/math/shared_formulas.h"
#include "render/octree/octree_shared.h"
#include "scenes/files.h"

namespace maquette {

namespace {

using shared::kCellDirections;
using shared::kCellPairs;

/// Added to GGX's alpha in quadrature: between directions that are 0.36 rad apart half vectors spread by 0.12 rad on
/// each axis, and alpha is that times the square root of 2.
constexpr float kLobeWidening = 0.16f;
/// Number of half vectors over which a measured table is averaged, with the same spread.
constexpr int kTableSamples = 64;
constexpr double kQuadratureSteps = 64;

const std::array<glm::vec3, kCellDirections>& directions() {
  static const auto table = [] {
    std::array<glm::vec3, kCellDirections> d{};
    for (int i = 0; i < kCellDirections; ++i)
      d[static_cast<std::size_t>(i)] = glm::normalize(shared::cell_direction(i));
    return d;
  }();
  return table;
}

glm::mat3 basis_of(const glm::vec3& n) {
  const glm::vec3 t = shared::cell_tangent(n);
  return {t, glm::cross(n, t), n};
}

float widened(float alpha) { return std::sqrt(alpha * alpha + kLobeWidening * kLobeWidening); }

glm::vec3 average_table(const BrdfTable& table, const glm::vec3& wi, const glm::vec3& wo) {
  // Rotating both directions alike spreads the half vectors and keeps the angle between the two.
  glm::vec3 sum(0.0f);
  int count = 0;
  for (int k = 0; k < kTableSamples; ++k) {
    const float angle = 2.3999632f * static_cast<float>(k);
    const float share = (static_cast<float>(k) + 0.5f) / static_cast<float>(kTableSamples);
    const float radius = kLobeWidening * std::sqrt(-std::log(1.0f - share));
    const glm::vec3 axis(radius * std::cos(angle), radius * std::sin(angle), 0.0f);
    const glm::vec3 a = glm::normalize(wi + glm::cross(axis, wi)), b = glm::normalize(wo + glm::cross(axis, wo));
    if (a.z <= 0.0f || b.z <= 0.0f) continue;
    sum += glm::vec3(evaluate_brdf(table, a, b));
    ++count;
  }
  return count > 0 ? sum / static_cast<float>(count) : glm::vec3(evaluate_brdf(table, wi, wo));
}

constexpr int kGrid = 24;

glm::vec3 grid_direction(int elevation, float phi) {
  const float s = static_cast<float>(elevation) / (kGrid - 1), z = std::max(1.0f - s * s, 1e-3f);
  const float r = std::sqrt(1.0f - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Van der Corput sequence in any base.
double radical_inverse(std::uint32_t i, std::uint32_t base) {
  double result = 0.0, digit = 1.0 / base;
  for (; i > 0; i /= base, digit /= base) result += digit * (i % base);
  return result;
}

glm::dvec3 point_in_polygon(const ClipPolygon& polygon, double share, double u, double v) {
  const glm::dvec3 whole = polygon_area_vector(polygon);
  const glm::dvec3 n = whole / std::max(glm::length(whole), 1e-300);
  double left = share * glm::length(whole);
  int k = 2;
  double area = 0.0;
  for (; k < polygon.count; ++k) {
    area = 0.5 * glm::dot(n, glm::cross(polygon.corners[k - 1] - polygon.corners[0],
                                        polygon.corners[k] - polygon.corners[0]));
    if (left <= area || k == polygon.count - 1) break;
    left -= area;
  }
  const double r = std::sqrt(u);
  return polygon.corners[0] * (1.0 - r) + polygon.corners[k - 1] * (r * (1.0 - v)) + polygon.corners[k] * (r * v);
}

/// Weights of the pairs of directions on one side of one piece.
class PairWeights {
 public:
  void add(double area, const std::array<float, kCellDirections>& cosines,
           const std::array<bool, kCellDirections>& seen, bool front) {
    std::array<int, kCellDirections> list;
    int count = 0;
    for (int i = 0; i < kCellDirections; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (seen[k] && (front ? cosines[k] > 0.0f : cosines[k] < 0.0f)) list[static_cast<std::size_t>(count++)] = i;
    }
    for (int a = 0; a < count; ++a) {
      const int i = list[static_cast<std::size_t>(a)];
      const float scale = static_cast<float>(area) * std::abs(cosines[static_cast<std::size_t>(i)]);
      float* row = weights_.data() + i * (i + 1) / 2;
      for (int b = 0; b <= a; ++b) {
        const int j = list[static_cast<std::size_t>(b)];
        row[j] += scale * std::abs(cosines[static_cast<std::size_t>(j)]);
      }
      used_ = true;
    }
  }
  /// Adds the weights times the BRDF to `out`, and resets them.
  void flush(const glm::vec3& normal, const CellReflectance& f, Eigen::VectorXf* out) {
    if (!used_) return;
    const glm::mat3 to_local = glm::transpose(basis_of(normal));
    std::vector<CellDirection> local;
    local.reserve(kCellDirections);
    for (const glm::vec3& direction : directions()) {
      glm::vec3 d = to_local * direction;
      d.z = std::max(d.z, 1e-3f);
      local.emplace_back(d);
    }
    for (int i = 0, pair = 0; i < kCellDirections; ++i) {
      for (int j = 0; j <= i; ++j, ++pair) {
        float& w = weights_[static_cast<std::size_t>(pair)];
        if (w == 0.0f) continue;
        const glm::vec3 value = w * f(local[static_cast<std::size_t>(i)], local[static_cast<std::size_t>(j)]);
        for (int c = 0; c < 3; ++c) (*out)[3 * pair + c] += value[c];
        w = 0.0f;
      }
    }
    used_ = false;
  }

 private:
  std::array<float, kCellPairs> weights_{};
  bool used_ = false;
};

}  // namespace

CellDirection::CellDirection(const glm::vec3& direction) : d(direction) {
  const float across = std::sqrt(d.x * d.x + d.y * d.y);
  if (across > 1e-6f) azimuth = glm::vec2(d) / across;
  // Indexed by the sine of half the angle from the normal.
  elevation = std::sqrt(std::clamp(1.0f - d.z, 0.0f, 1.0f)) * (kGrid - 1);
}

glm::mat3 cell_frame(const glm::vec3& normal, const CellRotation& turn) {
  const glm::mat3 f = basis_of(glm::normalize(normal));
  const float angle =
      static_cast<float>(2.0 * std::numbers::pi / (1 << CellRotation::kBits)) * static_cast<float>(turn.steps);
  const float c = std::cos(angle), s = std::sin(angle), side = turn.mirrored ? -1.0f : 1.0f;
  return {c * f[0] + s * f[1], side * (c * f[1] - s * f[0]), f[2]};
}

CellRotation find_cell_rotation(std::span<const CellSample> samples, const glm::vec3& normal) {
  const glm::dmat3 f(cell_frame(normal));
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (const CellSample& s : samples) {
    const double x = glm::dot(s.normal, f[0]), y = glm::dot(s.normal, f[1]);
    xx += s.area * x * x;
    xy += s.area * x * y;
    yy += s.area * y * y;
  }
  double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
  const double c = std::cos(angle), sn = std::sin(angle);
  double along = 0.0, across = 0.0;
  for (const CellSample& s : samples) {
    const double x = glm::dot(s.normal, f[0]), y = glm::dot(s.normal, f[1]);
    const double t = c * x + sn * y, b = c * y - sn * x;
    along += s.area * t * std::abs(t);
    across += s.area * b * std::abs(b);
  }
  if (along < 0.0) angle += std::numbers::pi;
  constexpr int kSteps = 1 << CellRotation::kBits;
  const auto steps = static_cast<int>(std::lround(angle / (2.0 * std::numbers::pi) * kSteps));
  return {static_cast<std::uint32_t>(steps & (kSteps - 1)), (along < 0.0) != (across < 0.0)};
}

CellMaterial::CellMaterial(const Material& material, std::shared_ptr<const BrdfTable> table)
    : material_(material), table_(std::move(table)), glows_(material.emissive != glm::vec3(0.0f) || material.unlit) {
  const Material& m = material_;
  const float numbers[] = {m.base_color.r,
                           m.base_color.g,
                           m.base_color.b,
                           m.metallic,
                           m.roughness,
                           m.ior,
                           m.specular,
                           m.specular_color.r,
                           m.specular_color.g,
                           m.specular_color.b,
                           m.clearcoat,
                           m.clearcoat_roughness,
                           m.sheen_color.r,
                           m.sheen_color.g,
                           m.sheen_color.b,
                           m.sheen_roughness,
                           m.iridescence,
                           m.iridescence_ior,
                           m.iridescence_greatest_nm,
                           glows_ ? 1.0f : 0.0f,
                           m.tint_measured ? 1.0f : 0.0f};
  content_ = content_hash(std::as_bytes(std::span(numbers)), table_ ? table_->hash : 0u);
}

void CellMaterial::make_grid() {
  const auto black = brdf(glm::vec3(0.0f)), white = brdf(glm::vec3(1.0f));
  grid_.resize(std::size_t{kGrid} * kGrid * kGrid);
  for (int i = 0; i < kGrid; ++i) {
    for (int o = 0; o < kGrid; ++o) {
      for (int p = 0; p < kGrid; ++p) {
        const float phi = 2.0f * std::acos(static_cast<float>(p) / (kGrid - 1));
        const glm::vec3 wi = grid_direction(i, 0.0f), wo = grid_direction(o, phi);
        const glm::vec3 dark = black(wi, wo), added = white(wi, wo) - dark;
        grid_[static_cast<std::size_t>((i * kGrid + o) * kGrid + p)] = {dark.r,  dark.g,  dark.b,  0.0f,
                                                                        added.r, added.g, added.b, 0.0f};
      }
    }
  }
}

CellReflectance CellMaterial::fast_brdf(const glm::vec3& color) const {
  return [this, color](const CellDirection& wi, const CellDirection& wo) {
    // Azimuth is indexed by the cosine of half the angle between the two, which is 0, and resolved best, where the
    // directions mirror each other.
    const float c = wi.azimuth.x * wo.azimuth.x + wi.azimuth.y * wo.azimuth.y;
    const float phi = std::sqrt(std::clamp(0.5f + 0.5f * c, 0.0f, 1.0f)) * (kGrid - 1);
    const int i = std::min(static_cast<int>(wi.elevation), kGrid - 2),
              o = std::min(static_cast<int>(wo.elevation), kGrid - 2);
    const int p = std::min(static_cast<int>(phi), kGrid - 2);
    const float fi = wi.elevation - static_cast<float>(i), fo = wo.elevation - static_cast<float>(o),
                fp = phi - static_cast<float>(p);
    using Entry = Eigen::Array<float, 8, 1>;
    const auto at = [&](int di, int dz) {
      return Eigen::Map<const Entry>(grid_[static_cast<std::size_t>(((i + di) * kGrid + o + dz) * kGrid + p)].data());
    };
    const auto next = [&](int di, int dz) {
      return Eigen::Map<const Entry>(
          grid_[static_cast<std::size_t>(((i + di) * kGrid + o + dz) * kGrid + p + 1)].data());
    };
    Entry sum = Entry::Zero();
    for (int k = 0; k < 4; ++k) {
      const float w = ((k & 1) ? fo : 1.0f - fo) * ((k & 2) ? fi : 1.0f - fi);
      sum += (w * (1.0f - fp)) * at(k >> 1, k & 1) + (w * fp) * next(k >> 1, k & 1);
    }
    return glm::vec3(sum[0], sum[1], sum[2]) + color * glm::vec3(sum[4], sum[5], sum[6]);
  };
}

CellReflectance CellMaterial::brdf(const glm::vec3& color) const {
  const Material& m = material_;
  const glm::vec3 base = color * glm::vec3(m.base_color);
  if (table_) {
    return [table = table_, tint = m.tint_measured ? base : glm::vec3(1.0f)](const glm::vec3& wi, const glm::vec3& wo) {
      return average_table(*table, wi, wo) * tint;
    };
  }
  shared::AnalyticMaterial a =
      shared::make_analytic(base, m.metallic, m.roughness, m.ior, m.specular, m.specular_color, m.clearcoat,
                            m.clearcoat_roughness, m.sheen_color, m.sheen_roughness);
  a.alpha = a.alpha_y = widened(a.alpha);
  a.film = m.iridescence;
  a.film_ior = m.iridescence_ior;
  a.film_nm = m.iridescence_greatest_nm;
  a.coat_alpha = widened(a.coat_alpha);
  return [a](const glm::vec3& wi, const glm::vec3& wo) { return shared::evaluate_analytic(a, wi, wo).total; };
}

std::vector<CellSample> sample_polygons(std::span<const ClipPolygon* const> polygons, double face, int count,
                                        std::uint32_t seed) {
  std::vector<double> sums;
  double total = 0.0;
  for (const ClipPolygon* p : polygons) sums.push_back(total += glm::length(polygon_area_vector(*p)));
  std::vector<CellSample> samples;
  if (!(total > 0.0)) return samples;
  std::size_t k = 0;
  for (int s = 0; s < count; ++s) {
    const auto index = static_cast<std::uint32_t>(s);
    const double jitter = radical_inverse(index + 1u, 2u);
    const double target = total * (s + jitter) / count;
    while (k + 1 < sums.size() && sums[k] < target) ++k;
    const double before = k > 0 ? sums[k - 1] : 0.0;
    const glm::dvec3 area = polygon_area_vector(*polygons[k]);
    const double own = sums[k] - before;
    CellSample sample;
    sample.piece = static_cast<int>(k);
    sample.area = total / count / face;
    sample.normal = area / std::max(glm::length(area), 1e-300);
    sample.position =
        point_in_polygon(*polygons[k], own > 0.0 ? (target - before) / own : 0.5,
                         radical_inverse(index + seed % 64u, 3u), radical_inverse(index + seed % 64u, 5u));
    samples.push_back(sample);
  }
  return samples;
}

Eigen::VectorXf compute_cell_brdf(std::span<const CellSample> samples, std::span<const CellReflectance> reflectance,
                                  const glm::mat3& frame, const CellVisibility& visible) {
  Eigen::VectorXf out = Eigen::VectorXf::Zero(kCellBrdfDimension);
  PairWeights front, back;
  const glm::mat3 local_from_world = glm::transpose(frame);
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const CellSample& sample = samples[s];
    const glm::vec3 n = local_from_world * glm::vec3(sample.normal);
    std::array<float, kCellDirections> cosines;
    std::array<bool, kCellDirections> seen;
    for (std::size_t i = 0; i < cosines.size(); ++i) {
      cosines[i] = glm::dot(n, directions()[i]);
      seen[i] = !visible || visible(sample, frame * directions()[i]);
      if (seen[i])
        out[3 * kCellPairs + static_cast<Eigen::Index>(i)] += static_cast<float>(sample.area) * std::abs(cosines[i]);
    }
    front.add(sample.area, cosines, seen, true);
    back.add(sample.area, cosines, seen, false);
    if (s + 1 < samples.size() && samples[s + 1].piece == sample.piece) continue;
    const CellReflectance& f = reflectance[static_cast<std::size_t>(sample.piece)];
    front.flush(n, f, &out);
    back.flush(-n, f, &out);
  }
  return out;
}

std::span<const float> cell_solid_angles() {
  static const auto angles = [] {
    std::array<double, kCellDirections> sums{};
    const double step = 1.0 / kQuadratureSteps;
    for (int map = 0; map < 2; ++map) {
      for (double u = -1.0 + 0.5 * step; u < 1.0; u += step) {
        for (double v = -1.0 + 0.5 * step; v < 1.0; v += step) {
          const double r2 = u * u + v * v;
          if (r2 > 1.0) continue;
          const double omega = 4.0 / ((1.0 + r2) * (1.0 + r2)) * step * step;
          const auto at =
              shared::cell_lookup(shared::cell_direction_at(map, static_cast<float>(u), static_cast<float>(v)));
          for (int k = 0; k < 4; ++k) {
            const double w = static_cast<double>(((k & 1) ? at.x : 1.0f - at.x) * ((k >> 1) ? at.y : 1.0f - at.y));
            sums[static_cast<std::size_t>(at.first + (k & 1) + (k >> 1) * shared::kCellSide)] += w * omega;
          }
        }
      }
    }
    double total = 0.0;
    for (double s : sums) total += s;
    std::array<float, kCellDirections> result;
    for (std::size_t i = 0; i < sums.size(); ++i)
      result[i] = static_cast<float>(sums[i] * 4.0 * std::numbers::pi / total);
    return result;
  }();
  return angles;
}

Eigen::VectorXf cell_brdf_measure() {
  const auto omega = cell_solid_angles();
  Eigen::VectorXf measure(kCellBrdfDimension);
  for (int i = 0, pair = 0; i < kCellDirections; ++i) {
    for (int j = 0; j <= i; ++j, ++pair) {
      // A pair represents both orders. Radiance is the integral over l, hence the factor pi between it and E.
      const float both =
          (i == j ? 1.0f : 2.0f) * omega[static_cast<std::size_t>(i)] * omega[static_cast<std::size_t>(j)];
      for (int c = 0; c < 3; ++c) measure[3 * pair + c] = static_cast<float>(std::numbers::pi) * both;
    }
    measure[3 * kCellPairs + i] = omega[static_cast<std::size_t>(i)];
  }
  return measure;
}

}  // namespace maquette
