#include "render/btf/builtin_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "render/math/low_discrepancy.h"

namespace maquette {

namespace {

float unit_hash(int x, int y, std::uint32_t seed) {
  const std::uint32_t h = mix_seed(mix_seed(seed, static_cast<std::uint32_t>(x)), static_cast<std::uint32_t>(y));
  return static_cast<float>(h >> 8) * 0x1p-24f;
}
int wrapped(int i, int period) { return ((i % period) + period) % period; }
float smooth(float edge0, float edge1, float x) {
  const float t = std::clamp((x - edge0) / (edge1 - edge0), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

/// Value noise in [-1, 1] that repeats after the tile; `period` cells of it along each side.
float noise(const glm::vec2& p, int period, std::uint32_t seed) {
  const glm::vec2 q = p * static_cast<float>(period);
  const glm::vec2 cell = glm::floor(q), f = q - cell, s = f * f * (3.0f - 2.0f * f);
  const int x = static_cast<int>(cell.x), y = static_cast<int>(cell.y);
  const auto at = [&](int dx, int dy) { return unit_hash(wrapped(x + dx, period), wrapped(y + dy, period), seed); };
  return 2.0f * glm::mix(glm::mix(at(0, 0), at(1, 0), s.x), glm::mix(at(0, 1), at(1, 1), s.x), s.y) - 1.0f;
}

/// Distances to the nearest and second nearest of points jittered in `period` x `period` squares, in squares; and a
/// number of the nearest. Source: Worley 1996, "A Cellular Texture Basis Function".
struct Pebble {
  float nearest = 9.0f, second = 9.0f, number = 0.0f;
};
Pebble pebble_at(const glm::vec2& p, int period, std::uint32_t seed) {
  const glm::vec2 q = p * static_cast<float>(period);
  const int x = static_cast<int>(std::floor(q.x)), y = static_cast<int>(std::floor(q.y));
  Pebble found;
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      const int cx = wrapped(x + dx, period), cy = wrapped(y + dy, period);
      const glm::vec2 jitter(unit_hash(cx, cy, seed), unit_hash(cx, cy, seed + 1));
      const float d = glm::length(glm::vec2(x + dx, y + dy) + 0.1f + 0.8f * jitter - q);
      if (d < found.nearest) {
        found = {d, found.nearest, unit_hash(cx, cy, seed + 2)};
      } else {
        found.second = std::min(found.second, d);
      }
    }
  return found;
}

/// Fills heights at the corners and colours at the middles of the cells.
template <typename Height, typename Colour>
void fill(SmallGeometry* g, const Height& height, const Colour& colour) {
  const float scale = 1.0f / static_cast<float>(g->side);
  for (int y = 0; y < g->side; ++y)
    for (int x = 0; x < g->side; ++x) {
      g->heights[g->index(x, y)] = height(glm::vec2(x, y) * scale);
      g->diffuse[g->index(x, y)] = colour((glm::vec2(x, y) + 0.5f) * scale);
    }
}

/// Pebbles between creases, each with its own height, and pores; in sides of the tile.
float grain_height(const glm::vec2& p, int pebbles, float depth) {
  const glm::vec2 bent =
      p + 0.35f / static_cast<float>(pebbles) * glm::vec2(noise(p, 2 * pebbles, 11), noise(p, 2 * pebbles, 12));
  const Pebble pebble = pebble_at(bent, pebbles, 21);
  const float crease = smooth(0.0f, 0.42f, pebble.second - pebble.nearest);
  const float pore =
      1.0f - smooth(0.1f, 0.45f, pebble_at(p, pebbles, 31).nearest * (pebble.number > 0.4f ? 1.0f : 9.0f));
  const float fine = noise(p, 6 * pebbles, 41);
  return depth * (crease * (0.75f + 0.35f * pebble.number) - 0.35f * pore * crease + 0.05f * fine - 0.62f);
}

SmallGeometry make_leather(int side) {
  constexpr int kPebbles = 18;  // 1.4 mm
  SmallGeometry g = flat_geometry(side, glm::vec3(0.0f), 0.04f, 0.33f);
  const auto height = [](const glm::vec2& p) { return grain_height(p, kPebbles, 0.011f); };
  fill(&g, height, [&](const glm::vec2& p) {
    const float deep = smooth(-0.006f, 0.001f, height(p));
    const float stain = 1.0f + 0.12f * noise(p, 5, 51) + 0.06f * noise(p, 23, 52);
    return glm::vec3(0.30f, 0.135f, 0.058f) * (stain * glm::mix(0.55f, 1.0f, deep));
  });
  return g;
}

/// Half cylinder of a yarn of radius `radius` whose axis is `across` away; below its middle it falls to -radius.
float yarn_profile(float across, float radius) {
  const float d2 = radius * radius - across * across;
  return d2 > 0.0f ? std::sqrt(d2) : -radius;
}

/// A 2/2 twill of dark warp and light weft yarns, with their twist.
struct Twill {
  static constexpr int kYarns = 32;  // 0.8 mm apart, both ways
  static constexpr float kPitch = 1.0f / kYarns, kRadius = 0.47f * kPitch, kRise = 0.32f * kPitch;
  struct Point {
    float height = -1.0f;
    bool warp = false;
    float along = 0.0f, across = 0.0f;
  };
  /// Height of the axis of a yarn at `along` (in yarns): up over two, down over two.
  static float axis(float along, int yarn, bool warp) {
    const float phase = along + static_cast<float>(warp ? yarn : -yarn) + (warp ? 0.0f : 2.0f);
    return kRise * std::clamp(1.6f * std::cos(0.5f * std::numbers::pi_v<float> * (phase - 1.0f)), -1.0f, 1.0f);
  }
  static Point at(const glm::vec2& p) {
    Point top;
    for (const bool warp : {true, false}) {
      const float across = (warp ? p.x : p.y) * kYarns, along = (warp ? p.y : p.x) * kYarns;
      const int nearest = static_cast<int>(std::floor(across));
      for (int yarn = nearest - 1; yarn <= nearest + 1; ++yarn) {
        const int number = wrapped(yarn, kYarns);
        const float bend =
            0.06f * noise({along / kYarns, (static_cast<float>(number) + 0.5f) / kYarns}, kYarns, warp ? 61 : 62);
        const float away = (across - static_cast<float>(yarn) - 0.5f - bend) * kPitch;
        // The twist of the plies, as ridges that run obliquely over the yarn.
        const float twist =
            0.06f * kRadius * std::cos(2.0f * std::numbers::pi_v<float> * (2.0f * along + 1.1f * away / kRadius));
        const float h = axis(along, number, warp) + yarn_profile(away, kRadius) + twist;
        if (h > top.height) top = {h, warp, along, away / kRadius};
      }
    }
    top.height = std::max(top.height, -0.7f * kPitch);
    return top;
  }
};

SmallGeometry make_fabric(int side) {
  SmallGeometry g = flat_geometry(side, glm::vec3(0.0f), 0.03f, 0.5f);
  fill(
      &g, [](const glm::vec2& p) { return Twill::at(p).height - 0.5f * Twill::kPitch; },
      [](const glm::vec2& p) {
        const Twill::Point top = Twill::at(p);
        const glm::vec3 colour = top.warp ? glm::vec3(0.055f, 0.062f, 0.078f) : glm::vec3(0.33f, 0.335f, 0.34f);
        return colour * (1.0f + 0.15f * noise(p, 128, top.warp ? 71 : 72));
      });
  return g;
}

/// Stitches of a plain knit: the axis of a yarn through one course, and the heights of its tube drawn into a map.
/// Differs from a knitted fabric: only what is seen from above is there.
class Knit {
 public:
  static constexpr int kWales = 14, kCourses = 18;
  explicit Knit(int side) : side_(side), heights_(static_cast<std::size_t>(side * side), -1.0f) {
    for (int course = 0; course < kCourses; ++course) draw_course(course);
  }
  float height(int x, int y) const { return heights_[index(x, y)]; }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(wrapped(y, side_)) * static_cast<std::size_t>(side_) +
           static_cast<std::size_t>(wrapped(x, side_));
  }
  /// Lengths in wales; t in stitches. The loop leans out at its head, which lies behind the feet of the next course.
  static glm::vec3 axis(float t) {
    const float a = 2.0f * std::numbers::pi_v<float> * t;
    return {t + 0.24f * std::sin(2.0f * a), -0.62f * std::cos(a), -0.16f * std::cos(2.0f * a)};
  }
  void draw_course(int course) {
    constexpr int kSteps = 96;
    const float wale = static_cast<float>(side_) / kWales, step = static_cast<float>(side_) / kCourses;
    const float radius = 0.2f * wale;
    for (int i = 0; i < kWales * kSteps; ++i) {
      const float t = static_cast<float>(i) / kSteps;
      const glm::vec3 p = axis(t), q = axis(t + 0.5f / kSteps);
      const glm::vec2 tangent = glm::normalize(glm::vec2(q - p) + 1e-9f);
      const glm::vec2 centre(p.x * wale, (static_cast<float>(course) + 0.5f) * step + p.y * wale);
      const int reach = static_cast<int>(radius) + 1;
      const int cx = static_cast<int>(std::floor(centre.x)), cy = static_cast<int>(std::floor(centre.y));
      for (int y = cy - reach; y <= cy + reach + 1; ++y)
        for (int x = cx - reach; x <= cx + reach + 1; ++x) {
          const glm::vec2 d = glm::vec2(x, y) - centre;
          const float d2 = glm::dot(d, d);
          if (d2 >= radius * radius) continue;
          const float across = d.x * tangent.y - d.y * tangent.x;
          const float twist =
              0.05f * radius * std::cos(2.0f * std::numbers::pi_v<float> * (5.0f * t + 0.8f * across / radius));
          const float h = (p.z * wale + std::sqrt(radius * radius - d2) + twist) / static_cast<float>(side_);
          float& top = heights_[index(x, y)];
          top = std::max(top, h);
        }
    }
  }
  int side_;
  std::vector<float> heights_;
};

SmallGeometry make_knit(int side) {
  constexpr float kGround = -0.22f / Knit::kWales;
  SmallGeometry g = flat_geometry(side, glm::vec3(0.0f), 0.025f, 0.55f);
  const Knit knit(side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const std::size_t i = g.index(x, y);
      g.heights[i] = std::max(knit.height(x, y), kGround) - 0.2f / Knit::kWales;
      const glm::vec2 p = (glm::vec2(x, y) + 0.5f) / static_cast<float>(side);
      const bool yarn = knit.height(x, y) > kGround;
      g.diffuse[i] =
          yarn ? glm::vec3(0.50f, 0.46f, 0.38f) * (1.0f + 0.12f * noise(p, 96, 81)) : glm::vec3(0.25f, 0.23f, 0.19f);
    }
  return g;
}

SmallGeometry make_perforated(int side) {
  constexpr int kHoles = 6;  // along a side: 4.3 mm apart
  constexpr float kPitch = 1.0f / kHoles, kRadius = 0.135f * kPitch, kRim = 0.05f * kPitch, kDepth = 0.035f;
  SmallGeometry g = flat_geometry(side, glm::vec3(0.0f), 0.04f, 0.3f);
  // Distance to the wall of the nearest hole; rows are staggered.
  const auto to_wall = [](const glm::vec2& p) {
    float nearest = 1.0f;
    for (const float shift : {0.0f, 0.5f}) {
      const glm::vec2 q = p / kPitch - shift;
      nearest = std::min(nearest, glm::length(q - glm::round(q)) * kPitch);
    }
    return nearest - kRadius;
  };
  fill(
      &g,
      [&](const glm::vec2& p) {
        const float wall = to_wall(p);
        const float rounded = 0.4f * kRim * (1.0f - smooth(0.0f, kRim, wall));  // the edge bends into the hole
        const float surface = grain_height(p, 28, 0.004f) - rounded;
        return glm::mix(-kDepth, surface, smooth(-0.35f * kRadius, 0.0f, wall));
      },
      [&](const glm::vec2& p) {
        const float stain = 1.0f + 0.1f * noise(p, 7, 91);
        return glm::mix(glm::vec3(0.03f, 0.028f, 0.026f), glm::vec3(0.42f, 0.39f, 0.34f) * stain,
                        smooth(-0.3f * kRadius, 0.0f, to_wall(p)));
      });
  for (std::size_t i = 0; i < g.specular.size(); ++i)
    if (g.heights[i] < -0.4f * kDepth) g.specular[i] = 0.0f;  // foam
  return g;
}

}  // namespace

const std::vector<BuiltinGeometry>& builtin_geometries() {
  static const std::vector<BuiltinGeometry> kGeometries = {
      {"btf-leather", "Grained leather (BTF)",
       "ray traced height field: pebbles of 1.4 mm between creases (Worley 1996) and pores; Lambert under one GGX lobe",
       make_leather, 0.0256},
      {"btf-fabric", "Twill fabric (BTF)", "ray traced height field: 2/2 twill of yarns 0.8 mm apart, with their twist",
       make_fabric, 0.0256},
      {"btf-knit", "Knit (BTF)", "ray traced height field: plain knit, 14 wales and 18 courses over 25.6 mm", make_knit,
       0.0256},
      {"btf-perforated", "Perforated leather (BTF)",
       "ray traced height field: fine grain, holes of 1.15 mm, staggered 3 mm apart, foam below", make_perforated,
       0.0256},
  };
  return kGeometries;
}

const BuiltinGeometry* find_builtin_geometry(const std::string& name) {
  for (const BuiltinGeometry& geometry : builtin_geometries())
    if (geometry.name == name) return &geometry;
  return nullptr;
}

}  // namespace maquette
