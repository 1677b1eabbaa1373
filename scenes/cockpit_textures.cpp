#include "scenes/cockpit_textures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "scenes/modelling.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

/// Coverage of a shape with signed distance d in pixels.
double cover(double d) { return std::clamp(0.5 - d, 0.0, 1.0); }

double box_distance(const Vec2& p, const Vec2& centre, const Vec2& half, double round_px) {
  const Vec2 q = glm::abs(p - centre) - half + round_px;
  return glm::length(glm::max(q, Vec2(0.0))) + std::min(std::max(q.x, q.y), 0.0) - round_px;
}

double segment_distance(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  return glm::length(p - a - d * std::clamp(glm::dot(p - a, d) / glm::dot(d, d), 0.0, 1.0));
}

/// Seven-segment digit, `size` its height.
double digit_distance(const Vec2& p, const Vec2& centre, double size, int digit) {
  static constexpr unsigned kSegments[10] = {0x3f, 0x06, 0x5b, 0x4f, 0x66, 0x6d, 0x7d, 0x07, 0x7f, 0x6f};
  const double w = 0.25 * size, h = 0.5 * size;
  if (std::abs(p.x - centre.x) > size || std::abs(p.y - centre.y) > size) return size;
  const Vec2 c[6] = {{-w, -h}, {w, -h}, {w, 0}, {w, h}, {-w, h}, {-w, 0}};
  const int ends[7][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 0}, {5, 2}};
  double d = 1e9;
  for (unsigned i = 0; i < 7; ++i)
    if ((kSegments[digit] >> i & 1u) != 0u)
      d = std::min(d, segment_distance(p, centre + c[ends[i][0]], centre + c[ends[i][1]]));
  return d - 0.07 * size;
}

TextureImage paint_image(const char* name, int width, int height, const std::function<Vec3(const Vec2&)>& shade) {
  TextureImage image{name, width, height, {}, {}};
  image.rgba.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Vec3 c = glm::clamp(shade({x + 0.5, y + 0.5}), 0.0, 1.0);
      for (int k = 0; k < 3; ++k) image.rgba.push_back(static_cast<std::uint8_t>(std::lround(255.0 * c[k])));
      image.rgba.push_back(255);
    }
  }
  return image;
}

void blend(Vec3* under, const Vec3& colour, double amount) { *under = glm::mix(*under, colour, amount); }

/// Round gauge: scale of 240 degrees, ticks, arc up to `value` in [0, 1], pointer.
void draw_gauge(Vec3* c, const Vec2& p, const Vec2& centre, double radius, double value, const Vec3& accent) {
  const Vec2 d = p - centre;
  const double r = glm::length(d);
  if (r > radius + 4.0) return;
  double turn = (std::atan2(d.x, -d.y) + 2.0 * std::numbers::pi / 3.0) / (4.0 * std::numbers::pi / 3.0);
  blend(c, {0.035, 0.045, 0.06}, cover(r - radius));
  blend(c, {0.35, 0.4, 0.45}, cover(std::abs(r - radius) - 1.0));
  if (turn >= 0.0 && turn <= 1.0) {
    blend(c, {0.14, 0.16, 0.19}, cover(std::abs(r - 0.88 * radius) - 4.0));
    if (turn < value) blend(c, accent, (0.35 + 0.65 * turn / value) * cover(std::abs(r - 0.88 * radius) - 4.0));
    const double tick = std::abs(turn * 16.0 - std::round(turn * 16.0)) / 16.0 * r * 4.0 * std::numbers::pi / 3.0;
    const bool major = static_cast<int>(std::lround(turn * 16.0)) % 2 == 0;
    blend(c, Vec3(0.9), cover(std::max(tick - (major ? 1.2 : 0.7), std::abs(r - 0.75 * radius) - (major ? 6.0 : 3.0))));
  }
  const double angle = value * 4.0 * std::numbers::pi / 3.0 - 2.0 * std::numbers::pi / 3.0;
  const Vec2 pointer(std::sin(angle), -std::cos(angle));
  blend(c, {1.0, 0.25, 0.15},
        cover(segment_distance(p, centre + 0.5 * radius * pointer, centre + 0.92 * radius * pointer) - 1.6));
}

}  // namespace

TextureImage make_cluster_image() {
  return paint_image("cluster", 640, 240, [](const Vec2& p) {
    Vec3 c = glm::mix(Vec3(0.03, 0.045, 0.075), Vec3(0.01, 0.012, 0.02), p.y / 240.0);
    draw_gauge(&c, p, {125, 122}, 102, 0.46, {0.2, 0.75, 1.0});
    draw_gauge(&c, p, {515, 122}, 102, 0.34, {0.3, 0.95, 0.6});
    blend(&c, Vec3(1.0), cover(digit_distance(p, {100, 122}, 42, 8)) + cover(digit_distance(p, {142, 122}, 42, 7)));
    blend(&c, Vec3(0.95), cover(digit_distance(p, {515, 122}, 42, 4)));
    // The road ahead, in perspective, with the lane that is driven.
    const double depth = (p.y - 70.0) / 150.0;
    if (depth > 0.02 && depth < 1.0) {
      const double across = (p.x - 320.0 - 22.0 * (1.0 - depth) * (1.0 - depth)) / (12.0 + 68.0 * depth);
      blend(&c, {0.10, 0.12, 0.16}, std::abs(across) < 1.0 ? 1.0 : 0.0);
      blend(&c, {0.25, 0.75, 1.0}, std::abs(std::abs(across) - 0.95) < 0.05 ? 0.9 : 0.0);
      blend(&c, {0.25, 0.75, 1.0}, std::abs(across) < 0.30 * (1.0 - 0.6 * depth) && depth > 0.25 ? 0.5 : 0.0);
    }
    blend(&c, {0.8, 0.82, 0.86}, cover(box_distance(p, {320, 172}, {17, 12}, 6)));
    blend(&c, {0.85, 0.2, 0.15},
          cover(box_distance(p, {307, 176}, {4, 3}, 2)) + cover(box_distance(p, {333, 176}, {4, 3}, 2)));
    blend(&c, Vec3(0.9),
          cover(digit_distance(p, {296, 34}, 22, 1)) + cover(digit_distance(p, {312, 34}, 22, 2)) +
              cover(digit_distance(p, {334, 34}, 22, 4)) + cover(digit_distance(p, {350, 34}, 22, 0)));
    blend(&c, {0.3, 0.9, 0.4}, cover(box_distance(p, {230, 34}, {12, 7}, 4)));
    blend(&c, {1.0, 0.7, 0.2}, cover(box_distance(p, {410, 34}, {12, 7}, 4)));
    return c;
  });
}

TextureImage make_center_image() {
  return paint_image("center", 512, 320, [](const Vec2& p) {
    Vec3 c(0.08, 0.10, 0.14);
    // Map: blocks between streets, a park, a river and the route.
    const Vec2 q(0.94 * p.x + 0.34 * p.y, -0.34 * p.x + 0.94 * p.y);
    const auto street = [&](double x, double spacing, double half) {
      return cover(std::abs(x - spacing * std::round(x / spacing)) - half);
    };
    blend(&c, {0.10, 0.22, 0.15}, cover(box_distance(q, {380, 60}, {60, 44}, 10)));
    blend(&c, {0.10, 0.25, 0.42}, cover(std::abs(p.y - 250.0 - 26.0 * std::sin(p.x / 70.0)) - 20.0));
    blend(&c, {0.24, 0.27, 0.33}, std::max(street(q.x, 46, 1.6), street(q.y, 38, 1.6)));
    blend(&c, {0.42, 0.44, 0.48}, std::max(street(q.x, 184, 3.5), street(q.y, 152, 3.5)));
    const double route =
        std::min({segment_distance(p, {300, 330}, {332, 205}), segment_distance(p, {332, 205}, {262, 178}),
                  segment_distance(p, {262, 178}, {300, 60}), segment_distance(p, {300, 60}, {420, 100})});
    blend(&c, {0.15, 0.65, 1.0}, cover(route - 5.0));
    blend(&c, Vec3(1.0), cover(glm::length(p - Vec2(300, 60)) - 9.0));
    blend(&c, {0.95, 0.25, 0.2}, cover(glm::length(p - Vec2(420, 100)) - 10.0));
    // Side bar with four keys, top card with the next turn.
    blend(&c, {0.03, 0.035, 0.05}, cover(box_distance(p, {44, 160}, {44, 160}, 0)));
    const Vec3 keys[4] = {{0.2, 0.65, 1.0}, {0.95, 0.45, 0.2}, {0.3, 0.85, 0.45}, {0.75, 0.4, 0.95}};
    for (int i = 0; i < 4; ++i) {
      blend(&c, keys[i], cover(box_distance(p, {44, 52.0 + 72.0 * i}, {24, 24}, 9)));
      blend(&c, Vec3(0.98), cover(glm::length(p - Vec2(44, 52.0 + 72.0 * i)) - 9.0));
    }
    blend(&c, {0.05, 0.07, 0.10}, 0.9 * cover(box_distance(p, {190, 48}, {88, 32}, 12)));
    blend(&c, Vec3(1.0),
          cover(segment_distance(p, {130, 64}, {130, 36}) - 3.0) +
              cover(segment_distance(p, {130, 36}, {150, 36}) - 3.0));
    for (int i = 0; i < 3; ++i)
      blend(&c, Vec3(1.0), cover(digit_distance(p, {182.0 + 24.0 * i, 48}, 26, i == 0 ? 3 : i == 1 ? 5 : 0)));
    return c;
  });
}

TextureImage make_asphalt_image() {
  return paint_image("asphalt", 512, 512, [](const Vec2& p) {
    // Grains of 6 mm on a tile of 1.5 m, and stains so faint that the tiling is invisible. The mean is the albedo of
    // the ground of the clear sky, so that the border of the ground is invisible too.
    const double grain = tileable_noise(p.x / 2.0, p.y / 2.0, 256, 3u),
                 stain = tileable_fbm(p.x / 128.0, p.y / 128.0, 4, 3, 9u);
    const double shade = 0.40 + 0.035 * grain + 0.008 * stain;
    return Vec3(shade, shade * 0.988, shade * 0.96);
  });
}

}  // namespace maquette::builtin
