#include "tests/support/small_sun.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "render/reference/path_scene.h"
#include "render/slf/incident.h"
#include "render/slf/parabolic.h"
#include "tests/support/test_scenes.h"

namespace maquette::test {

namespace {

constexpr int kWidth = 1024, kHeight = 512;
constexpr double kRadius = 0.27 * std::numbers::pi / 180.0;
constexpr float kSky = 0.1f, kSun = 3e5f;

/// In the frame of the sheet's texels.
glm::vec3 local_direction(int trial) {
  std::mt19937 random(static_cast<std::uint32_t>(trial) + 11u);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  float z = unit(random);
  const float phi = 2.0f * std::numbers::pi_v<float> * unit(random);
  if (trial % 3 == 1) {
    const auto edge = static_cast<float>(random() % 15);
    const glm::vec2 p(-0.875f + 0.125f * edge, 0.9f * (2.0f * unit(random) - 1.0f));
    if (glm::dot(p, p) < 0.99f) return glm::normalize(shared::direction_from_parabolic(p));
  }
  if (trial % 3 == 2) z *= 0.02f;
  const float s = std::sqrt(1.0f - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

std::shared_ptr<Environment> sky_with_sun(const glm::dvec3& sun) {
  auto sky = std::make_shared<Environment>();
  sky->width = kWidth;
  sky->height = kHeight;
  sky->rgb.assign(static_cast<std::size_t>(kWidth) * kHeight, glm::vec3(kSky));
  std::size_t best = 0;
  double nearest = -1.0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double c = glm::dot(direction_from_latlong(x + 0.5, y + 0.5, kWidth, kHeight), sun);
      const auto i = static_cast<std::size_t>(y * kWidth + x);
      if (c > std::cos(kRadius)) sky->rgb[i] = glm::vec3(kSun);
      if (c > nearest) nearest = c, best = i;
    }
  sky->rgb[best] = glm::vec3(kSun);
  return sky;
}

/// Of the sky and its sun, which texels blend into their neighbours, on the plane y = 0.
double exact_irradiance(const Environment& sky) {
  constexpr int kFine = 8;
  double sum = std::numbers::pi * static_cast<double>(kSky);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      bool shines = false;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const int row = std::clamp(y + dy, 0, kHeight - 1), column = (x + dx + kWidth) % kWidth;
          shines |= sky.rgb[static_cast<std::size_t>(row * kWidth + column)].x > kSky;
        }
      if (!shines) continue;
      for (int k = 0; k < kFine * kFine; ++k) {
        const double px = x + (k % kFine + 0.5) / kFine, py = y + (k / kFine + 0.5) / kFine;
        const glm::dvec3 d = direction_from_latlong(px, py, kWidth, kHeight);
        const double area = 2.0 * std::numbers::pi / kWidth * (std::numbers::pi / kHeight) *
                            std::sqrt(std::max(1.0 - d.y * d.y, 0.0)) / (kFine * kFine);
        sum += (static_cast<double>(evaluate_environment(sky, d).x) - static_cast<double>(kSky)) * std::max(d.y, 0.0) *
               area;
      }
    }
  return sum;
}

}  // namespace

double sun_irradiance_error(int trial) {
  Scene scene;
  scene.materials.push_back(matte(glm::vec3(0.0f)));
  add(&scene, make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 1, 0), "sheet");
  const auto plain = build_path_scene({.scene = scene, .environment = constant_sky(1.0f)});
  const auto atlas = std::make_shared<LightFieldAtlas>(make_atlas(plain->geometry, {{0, false}}, {.side = 4}));
  constexpr std::size_t kTexel = 3;
  const TexelFrame frame = frame_of_texel(plain->geometry, *atlas, kTexel);
  const auto sky = sky_with_sun(glm::dvec3(frame.to_world(local_direction(trial))));
  const auto lit = build_path_scene({.scene = scene, .environment = sky});
  const IncidentTracer tracer(lit, atlas, {.paths = 1, .seed = static_cast<std::uint32_t>(trial)});
  const Lumisphere& sphere = tracer.lumisphere();
  std::vector<float> bins(static_cast<std::size_t>(3 * sphere.count()));
  tracer.trace(kTexel, bins);
  double found = 0.0;
  for (int b = 0; b < sphere.count(); ++b)
    found += static_cast<double>(bins[3 * static_cast<std::size_t>(b)]) * sphere.projected(b);
  return found / exact_irradiance(*sky) - 1.0;
}

}  // namespace maquette::test
