// What mirrors show while nothing moves: shadows by rays, rays that vary over pixels and lobes, and the mean of the
// frames.
#include <numbers>
#include <optional>

#include "tests/gpu/reflections_fixture.h"

namespace maquette::test {
namespace {

constexpr int kRestSide = 96, kFrames = 48;
constexpr double kMirrorZ = -2.2;
/// The sun: one texel.
constexpr int kSunX = 320, kSunY = 68, kSkyWidth = 1024, kSkyHeight = 512;

glm::dvec3 to_sun() {
  const double lon = std::numbers::pi - 2.0 * std::numbers::pi * (kSunX + 0.5) / kSkyWidth,
               lat = std::numbers::pi / 2.0 - std::numbers::pi * (kSunY + 0.5) / kSkyHeight;
  return {std::cos(lat) * std::sin(lon), std::sin(lat), std::cos(lat) * std::cos(lon)};
}

class MirrorsAtRest : public ::testing::Test {
 protected:
  /// A floor below a square of 1 m at 1 m, whose shadow a flat mirror shows.
  void set_shadow_before_mirror(float roughness) {
    Scene scene;
    scene.materials = {matte(glm::vec3(0.5f)), matte(glm::vec3(0.2f)), mirror_metal()};
    scene.materials[0].double_sided = scene.materials[1].double_sided = true;
    scene.materials[2].roughness = roughness;
    add(&scene, make_grid({-20, 0, 20}, {40, 0, 0}, {0, 0, -40}, 1, 0));
    add(&scene, make_grid({-0.5f, 1, 0.5f}, {1, 0, 0}, {0, 0, -1}, 1, 1));
    constexpr auto kZ = static_cast<float>(kMirrorZ);
    add(&scene, make_grid({-3, 0.05f, kZ}, {6, 0, 0}, {0, 3, 0}, 1, 2), "mirror")->reflector = true;
    renderer_.set_scene(std::make_shared<Scene>(scene));
    auto sky = std::make_shared<Environment>();
    sky->name = "sunny";
    sky->width = kSkyWidth;
    sky->height = kSkyHeight;
    sky->rgb.assign(static_cast<std::size_t>(kSkyWidth) * kSkyHeight, glm::vec3(1e-4f));
    sky->rgb[kSunY * kSkyWidth + kSunX] = glm::vec3(50000.0f);
    renderer_.set_environment(sky);
  }
  void set_constant_sky() {
    auto sky = std::make_shared<Environment>();
    sky->name = "constant";
    sky->width = 64;
    sky->height = 32;
    sky->rgb.assign(std::size_t{64} * 32, glm::vec3(1.0f));
    renderer_.set_environment(sky);
  }
  static FrameRequest request() {
    FrameRequest r = request_of("raytraced");
    r.mode = "bandwidth";
    r.width = r.height = kRestSide;
    r.reflectors = {"mirror"};
    r.camera.eye = {2.0f, 1.5f, -0.2f};
    r.camera.target = {0.8f, 0.75f, static_cast<float>(kMirrorZ)};
    r.camera.fov_y_rad = 0.45f;
    r.settings.set_from_text("shading.indirect", "none");
    r.settings.set_from_text("reflections.samples", "64");
    return r;
  }
  Image draw(const FrameRequest& r, int frames) {
    EXPECT_TRUE(renderer_.finish_background_work(r));
    for (int k = 0; k < frames; ++k) renderer_.render(r, frames > 1);
    const auto errors = take_gl_errors();
    EXPECT_TRUE(errors.empty()) << errors.front();
    return renderer_.read_debug_view("reflection");
  }
  /// Where the mirrored ray of a point of the picture (pixels) meets the floor; nothing: it does not, or may meet the
  /// square.
  static std::optional<glm::dvec3> mirrored_floor(const FrameRequest& r, double px, double py) {
    const glm::dvec3 eye(r.camera.eye), forward = glm::normalize(glm::dvec3(r.camera.target) - eye),
                                        right = glm::normalize(glm::cross(forward, glm::dvec3(0, 1, 0))),
                                        up = glm::cross(right, forward);
    const double tan_y = std::tan(0.5 * static_cast<double>(r.camera.fov_y_rad));
    glm::dvec3 d = forward + tan_y * ((2.0 * px / kRestSide - 1.0) * right - (2.0 * py / kRestSide - 1.0) * up);
    const glm::dvec3 on_mirror = eye + d * ((kMirrorZ - eye.z) / d.z);
    if (on_mirror.y < 0.1 || on_mirror.y > 0.95 || d.y >= -1e-6) return std::nullopt;
    d.z = -d.z;
    const glm::dvec3 on_floor = on_mirror - d * (on_mirror.y / d.y);
    if (std::abs(on_floor.x) > 15.0 || std::abs(on_floor.z) > 15.0) return std::nullopt;
    return on_floor;
  }
  /// Share of a pixel's mirrored floor that the sun lights; below 0: not all of it is floor. In double, 12 x 12 points.
  static double lit_share(const FrameRequest& r, int x, int y) {
    const glm::dvec3 sun = to_sun();
    int lit = 0;
    constexpr int kPoints = 12;
    for (int k = 0; k < kPoints * kPoints; ++k) {
      const auto on_floor = mirrored_floor(r, x + (k % kPoints + 0.5) / kPoints, y + (k / kPoints + 0.5) / kPoints);
      if (!on_floor) return -1.0;
      const glm::dvec3 above = *on_floor + sun / sun.y;
      lit += std::abs(above.x) > 0.5 || std::abs(above.z) > 0.5;
    }
    return lit / static_cast<double>(kPoints * kPoints);
  }
  /// Share of a constant sky's light that reaches a point of the floor past the square and the mirror, by quadrature.
  static double open_share(const glm::dvec3& at) {
    constexpr int kSteps = 64;
    int open = 0;
    for (int k = 0; k < kSteps * kSteps; ++k) {
      const double u = (k % kSteps + 0.5) / kSteps, phi = 2.0 * std::numbers::pi * (k / kSteps + 0.5) / kSteps;
      const glm::dvec3 d(std::sqrt(u) * std::cos(phi), std::sqrt(1.0 - u), std::sqrt(u) * std::sin(phi)),
          square = at + d / d.y;
      const double t = (kMirrorZ - at.z) / d.z;
      const glm::dvec3 mirror = at + t * d;
      const bool by_square = std::abs(square.x) < 0.5 && std::abs(square.z)<0.5, by_mirror = t> 0.0 &&
                             std::abs(mirror.x) < 3.0 && mirror.y > 0.05 && mirror.y < 3.05;
      open += !by_square && !by_mirror;
    }
    return open / static_cast<double>(kSteps * kSteps);
  }

  void SetUp() override { install_debug_output(); }
  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
};

/// Mean absolute error of the share of sunlight, over all pixels and over those that the shadow's edge crosses.
struct ShareError {
  double all = 0.0, edge = 0.0;
  int pixels = 0, edges = 0;
};

TEST_F(MirrorsAtRest, ShadowsHaveTheEdgesOfTheGeometry) {
  set_shadow_before_mirror(0.0f);
  const FrameRequest r = request();
  const auto error_of = [&](const Image& image) {
    ShareError e;
    double lit = 0.0;
    int count = 0;
    for (int y = 0; y < kRestSide; ++y)
      for (int x = 0; x < kRestSide; ++x)
        if (lit_share(r, x, y) == 1.0) lit += static_cast<double>(image.at(x, y, 1)), ++count;
    EXPECT_GT(count, 1000);
    lit /= count;
    EXPECT_GT(lit, 0.0);
    for (int y = 0; y < kRestSide; ++y)
      for (int x = 0; x < kRestSide; ++x) {
        const double share = lit_share(r, x, y);
        if (share < 0.0) continue;
        const double d = std::abs(static_cast<double>(image.at(x, y, 1)) / lit - share);
        e.all += d;
        ++e.pixels;
        if (share > 0.0 && share < 1.0) e.edge += d, ++e.edges;
      }
    e.all /= e.pixels;
    e.edge /= e.edges;
    return e;
  };
  const ShareError rest = error_of(draw(r, kFrames)), first = error_of(draw(r, 1));
  EXPECT_GT(rest.edges, 60);
  EXPECT_LT(rest.all, 0.01);
  EXPECT_LT(rest.edge, 0.08);
  EXPECT_GT(first.all, 3.0 * rest.all) << "maps of four vertices";
}

/// The floor has four vertices, far away, which see all of the sky.
TEST_F(MirrorsAtRest, TheSkysShadowsAreInTheMirrorToo) {
  set_shadow_before_mirror(0.0f);
  set_constant_sky();
  const FrameRequest r = request();
  constexpr int kBlock = 12;
  const auto error_of = [&](const Image& image) {
    double seen = 0.0, expected = 0.0;
    std::vector<std::pair<double, double>> blocks;
    for (int by = 0; by < kRestSide; by += kBlock)
      for (int bx = 0; bx < kRestSide; bx += kBlock) {
        double a = 0.0, b = 0.0;
        int count = 0;
        for (int k = 0; k < kBlock * kBlock; ++k) {
          const int x = bx + k % kBlock, y = by + k / kBlock;
          const auto at = mirrored_floor(r, x + 0.5, y + 0.5);
          if (!at) continue;
          a += static_cast<double>(image.at(x, y, 1));
          b += open_share(*at);
          ++count;
        }
        if (count < kBlock * kBlock) continue;
        seen += a;
        expected += b;
        blocks.emplace_back(a, b);
      }
    EXPECT_GT(blocks.size(), 20u);
    double error = 0.0;
    for (const auto& [a, b] : blocks) error = std::max(error, std::abs(a / seen * expected / b - 1.0));
    return error;
  };
  const double rest = error_of(draw(r, kFrames)), first = error_of(draw(r, 1));
  EXPECT_LT(rest, 0.05);
  EXPECT_GT(first, 3.0 * rest) << "maps of four vertices";
}

/// A mirror of roughness 0.09 blurs what lies far behind it; the mean over the picture stays.
TEST_F(MirrorsAtRest, ARoughMirrorBlurs) {
  const FrameRequest r = request();
  const auto steepest = [](const Image& image) {
    float step = 0.0f;
    for (int y = 20; y < 76; ++y)
      for (int x = 20; x < 75; ++x) step = std::max(step, std::abs(image.at(x + 1, y, 1) - image.at(x, y, 1)));
    return step;
  };
  const auto mean = [](const Image& image) {
    double sum = 0.0;
    for (int y = 20; y < 76; ++y)
      for (int x = 20; x < 76; ++x) sum += static_cast<double>(image.at(x, y, 1));
    return sum;
  };
  set_shadow_before_mirror(0.0f);
  const Image sharp = draw(r, kFrames);
  set_shadow_before_mirror(0.09f);
  const Image blurred = draw(r, 2 * kFrames);
  EXPECT_LT(steepest(blurred), 0.6f * steepest(sharp));
  EXPECT_NEAR(mean(blurred) / mean(sharp), 1.0, 0.04);
}

/// Without averaging of points the pictures are averaged, and the result is the same.
TEST_F(MirrorsAtRest, ModesThatAverageWholePicturesAgree) {
  set_shadow_before_mirror(0.02f);
  FrameRequest r = request();
  r.samples = 64;
  const auto picture = [&](const std::string& mode) {
    r.mode = mode;
    draw(r, kFrames);
    return renderer_.read_radiance();
  };
  const Image a = picture("bandwidth"), b = picture("uniform");
  double difference = 0.0, level = 0.0;
  for (int y = 20; y < 76; ++y)
    for (int x = 20; x < 76; ++x) {
      difference += std::abs(static_cast<double>(a.at(x, y, 1) - b.at(x, y, 1)));
      level += static_cast<double>(b.at(x, y, 1));
    }
  EXPECT_LT(difference, 0.02 * level);
}

}  // namespace
}  // namespace maquette::test
