// The upsampling kernel (shaders/bandwidth/fill.comp) tap by tap in double, and its purpose: pictures that vary only
// across a diagonal.
#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "render/frame/frame_constants.h"
#include "render/gl/bindings.h"
#include "render/gl/context.h"
#include "render/gl/objects.h"
#include "render/math/shared_formulas.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

constexpr int kFullWidth = 72, kFullHeight = 52;
constexpr float kPixelAngle = 0.01f;

std::size_t at(int x, int y) { return static_cast<std::size_t>(y * kFullWidth + x); }

/// A picture to interpolate: one ray a pixel from the eye at the origin along -z.
struct Grid {
  std::vector<glm::uvec2> guide{static_cast<std::size_t>(kFullWidth * kFullHeight)};
  std::vector<glm::u8vec4> marks{static_cast<std::size_t>(kFullWidth * kFullHeight), glm::u8vec4(0, 0, 0, 1)};
  std::vector<glm::vec4> radiance{static_cast<std::size_t>(kFullWidth * kFullHeight)};
  std::vector<glm::vec4> axes{static_cast<std::size_t>(kFullWidth * kFullHeight / 4)};
  FrameConstants constants{};

  Grid() {
    constants.size = glm::ivec4(kFullWidth, kFullHeight, 1, 4);
    constants.eye.w = 1.0f;
    constants.forward = glm::vec4(0.0f, 0.0f, -1.0f, kPixelAngle);
    constants.right = glm::vec4(0.5f * kPixelAngle * kFullWidth, 0.0f, 0.0f, 0.0f);
    constants.up = glm::vec4(0.0f, 0.5f * kPixelAngle * kFullHeight, 0.0f, 0.0f);
  }
  void set_surface(int x, int y, float depth, const glm::vec3& normal, unsigned material) {
    const glm::vec2 oct = shared::octahedral_from_direction(normal);
    guide[at(x, y)] = {std::bit_cast<unsigned>(depth), static_cast<unsigned>(oct.x * 4095.0f + 0.5f) |
                                                           static_cast<unsigned>(oct.y * 4095.0f + 0.5f) << 12u |
                                                           material << 24u};
  }
  glm::dvec3 ray(int x, int y) const {
    return {kPixelAngle * (x + 0.5 - 0.5 * kFullWidth), -kPixelAngle * (y + 0.5 - 0.5 * kFullHeight), -1.0};
  }
};

enum class Pass { between, middle, quads };

/// Input of a shaded point that is interpolated too: a mean of 0 after 4 items.
struct Own {
  std::vector<float> residual;  ///< output
};

/// Runs fill.comp over the whole grid for one level.
std::vector<glm::vec4> filled(const Grid& grid, int level, Pass pass, Own* own = nullptr) {
  const auto texture = [](GLenum internal, GLenum format, GLenum type, int w, int h, const auto& values) {
    Texture t = Texture::make_2d("test", internal, w, h);
    t.upload(0, w, h, format, type, values.data());
    return t;
  };
  const std::vector<glm::vec4> nothing(grid.radiance.size(), glm::vec4(0.0f, 0.0f, 0.0f, 4.0f));
  const std::vector<float> ones(grid.radiance.size(), 1.0f);
  std::vector<unsigned> first_points;
  for (int y = 0; y < kFullHeight; y += 2)
    for (int x = 0; x < kFullWidth; x += 2) first_points.push_back(static_cast<unsigned>(x | y << 16));
  const Buffer block("frame", sizeof grid.constants, &grid.constants), quads = Buffer::from("quads", first_points);
  const Texture guide = texture(GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT, kFullWidth, kFullHeight, grid.guide);
  const Texture marks = texture(GL_RGBA8UI, GL_RGBA_INTEGER, GL_UNSIGNED_BYTE, kFullWidth, kFullHeight, grid.marks);
  const Texture radiance = texture(GL_RGBA32F, GL_RGBA, GL_FLOAT, kFullWidth, kFullHeight, grid.radiance);
  const Texture axes = texture(GL_RGBA32F, GL_RGBA, GL_FLOAT, kFullWidth / 2, kFullHeight / 2, grid.axes);
  const Texture mean = texture(GL_RGBA32F, GL_RGBA, GL_FLOAT, kFullWidth, kFullHeight, nothing);
  const Texture deviation = texture(GL_R32F, GL_RED, GL_FLOAT, kFullWidth, kFullHeight, ones);
  const Texture residual = texture(GL_R32F, GL_RED, GL_FLOAT, kFullWidth, kFullHeight, ones);
  const Texture worth = Texture::make_2d_array("worth", GL_RG32F, (kFullWidth + 7) / 8, (kFullHeight + 7) / 8, 12);
  const float kappa[] = {0.1f, 1.0f};
  glClearTexImage(worth.get(), 0, GL_RG, GL_FLOAT, kappa);
  glBindBufferBase(GL_UNIFORM_BUFFER, kBlockFrame, block.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferQuads, quads.get());
  const std::pair<GLuint, const Texture*> units[] = {{kUnitMean, &mean},       {kUnitDeviation, &deviation},
                                                     {kUnitScreenAxes, &axes}, {kUnitMarks, &marks},
                                                     {kUnitGuide, &guide},     {kUnitWorth, &worth}};
  for (const auto& [unit, t] : units) glBindTextureUnit(unit, t->get());
  glBindImageTexture(kImageRadiance, radiance.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(kImageResidual, residual.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  ShaderDefines defines{{"TEXTURES", "0"},
                        {"CUBIC", level > 0 ? "1" : "0"},
                        {"TILES", "0"},
                        {"OWN", own ? "1" : "0"},
                        {"FIND", "0"},
                        {"KEPT", "0"},
                        {"MIDDLE", pass == Pass::middle ? "1" : "0"}};
  if (pass == Pass::quads) defines.emplace_back("QUADS", "1");
  const Program program = Program::compute("bandwidth/fill.comp", defines);
  glProgramUniform1i(program.get(), program.location("u_level"), level);
  if (pass == Pass::quads)
    glProgramUniform1i(program.get(), program.location("u_quads"), static_cast<GLint>(first_points.size()));
  glUseProgram(program.get());
  glDispatchCompute(static_cast<GLuint>((kFullWidth * kFullHeight + 63) / 64), 1, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  std::vector<glm::vec4> values(grid.radiance.size());
  glGetTextureImage(radiance.get(), 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(values.size() * sizeof(glm::vec4)),
                    values.data());
  if (own) {
    own->residual.resize(values.size());
    glGetTextureImage(residual.get(), 0, GL_RED, GL_FLOAT, static_cast<GLsizei>(values.size() * sizeof(float)),
                      own->residual.data());
  }
  return values;
}

/// The same for one point, from the definition.
class TapByTap {
 public:
  TapByTap(const Grid& grid, const std::vector<glm::vec4>& before, int level)
      : grid_(grid), before_(before), level_(level) {}

  glm::dvec3 between(int x, int y, int dx, int dy) const { return along(x, y, dx, dy).value; }

  glm::dvec3 middle(int x, int y) const {
    const std::array<double, 4> shares = shares_at(x, y);
    constexpr int kDirections[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
    glm::dvec3 sum(0.0);
    double weights = 1e-300;
    for (int k = 0; k < 4; ++k) {
      const Along a = along(x, y, kDirections[k][0], kDirections[k][1]);
      sum += a.weight * shares[k] * a.value;
      weights += a.weight * shares[k];
    }
    return sum / weights;
  }

  /// A quad of 2 x 2 points whose first point is of a coarser level: each other point from the two or four coarser ones
  /// around.
  glm::dvec3 in_quad(int x, int y, int dx, int dy) const {
    const std::array<double, 4> shares = shares_at(x, y);
    glm::dvec3 sum(0.0);
    double weights = 1e-300;
    for (const int sx : {-1, 1})
      for (const int sy : {-1, 1}) {
        if ((dx == 0 && sx > 0) || (dy == 0 && sy > 0)) continue;
        const int qx = x + sx * dx, qy = y + sy * dy;
        const double diagonal_weight =
            dx + dy < 2 ? 1.0 : 0.5 * (shares[0] + shares[1]) + (sx == sy ? shares[2] : shares[3]);
        const double w = weight(x, y, qx, qy, 1.0);
        if (w <= 1e-4) continue;
        sum += w * diagonal_weight * value(qx, qy);
        weights += w * diagonal_weight;
      }
    return sum / weights;
  }

 private:
  /// Weights of the axes x, y, (1, 1) and (1, -1).
  std::array<double, 4> shares_at(int x, int y) const {
    const glm::vec4 m = grid_.axes[static_cast<std::size_t>(y / 2 * (kFullWidth / 2) + x / 2)];
    const double nx = m.x, ny = m.y, both = nx * nx + ny * ny + 2e-8, cross = 2.0 * static_cast<double>(m.z) * nx * ny;
    const double steps[] = {(nx * nx + 1e-8) / both, (ny * ny + 1e-8) / both, 1.0 + cross / both, 1.0 - cross / both};
    std::array<double, 4> shares{};
    for (std::size_t k = 0; k < 4; ++k) shares[k] = std::pow(std::max(steps[k], 0.15), level_ > 0 ? -4.0 : -2.0);
    return shares;
  }

  struct Along {
    glm::dvec3 value{0.0};
    double weight = 0.0;
  };

  glm::dvec3 value(int x, int y) const {
    return glm::dvec3(before_[at(std::clamp(x, 0, kFullWidth - 1), std::clamp(y, 0, kFullHeight - 1))]);
  }

  double weight(int x, int y, int qx, int qy, double step) const {
    if (qx < 0 || qy < 0 || qx >= kFullWidth || qy >= kFullHeight) return 0.0;
    const glm::uvec2 a = grid_.guide[at(x, y)], b = grid_.guide[at(qx, qy)];
    const double da = std::bit_cast<float>(a.x), db = std::bit_cast<float>(b.x);
    if (db <= 0.0 || a.y >> 24u != b.y >> 24u) return 0.0;
    const auto normal = [](unsigned w) {
      return glm::dvec3(shared::direction_from_octahedral(
          glm::vec2(static_cast<float>(w & 4095u), static_cast<float>(w >> 12u & 4095u)) / 4095.0f));
    };
    const glm::dvec3 na = normal(a.y), nb = normal(b.y), d = db * grid_.ray(qx, qy) - da * grid_.ray(x, y);
    const double off =
        std::max(std::abs(glm::dot(d, na)), std::abs(glm::dot(d, nb))) / (da * static_cast<double>(kPixelAngle) * step);
    return std::max(std::exp2(-1.5 * off * off - 6.0 * glm::dot(na - nb, na - nb)), 1e-4);
  }

  Along along(int x, int y, int dx, int dy) const {
    const int s = 1 << level_;
    const double length = std::hypot(dx, dy) * s;
    double w[4];
    glm::dvec3 v[4]{};
    for (int k = 0; k < 4; ++k) {
      const int steps = (2 * k - 3) * s;
      w[k] = weight(x, y, x + steps * dx, y + steps * dy, length * (k == 0 || k == 3 ? 3.0 : 1.0));
      v[k] = value(x + steps * dx, y + steps * dy);
    }
    if (level_ > 0 && std::min(std::min(w[0], w[1]), std::min(w[2], w[3])) > 0.4) {
      const glm::dvec3 low = glm::min(glm::min(v[0], v[1]), glm::min(v[2], v[3]));
      return {glm::max((9.0 * (v[1] + v[2]) - v[0] - v[3]) / 16.0, 0.5 * low), 2.0};
    }
    // Stored as square roots, in 8 bits.
    for (double& weight : w) weight = std::pow(std::floor(std::sqrt(weight) * 254.0 + 0.5) / 254.0, 2.0);
    return {(w[1] * v[1] + w[2] * v[2]) / std::max(w[1] + w[2], 1e-12), w[1] + w[2]};
  }

  const Grid& grid_;
  const std::vector<glm::vec4>& before_;
  int level_;
};

/// Every point that one dispatch fills.
void each_filled(int level, bool middle, const std::function<void(int x, int y, int dx, int dy)>& visit) {
  const int s = 1 << level;
  for (int y = 0; y < kFullHeight; y += s)
    for (int x = 0; x < kFullWidth; x += s) {
      const int odd_x = (x >> level) & 1, odd_y = (y >> level) & 1;
      if (middle ? odd_x + odd_y == 2 : odd_x + odd_y == 1) visit(x, y, odd_x, odd_y);
    }
}

TEST(Upsampling, AgreesWithTapByTap) {
  const GlContext context = GlContext::create_headless();
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  Grid grid;
  for (int y = 0; y < kFullHeight; ++y)
    for (int x = 0; x < kFullWidth; ++x) {
      // Two materials, holes of sky, steps of depth, and normals that vary from point to point.
      const float depth = unit(random) < 0.03f ? 0.0f : 1.0f + (x > 40 ? 0.02f : 0.0f) + 0.004f * unit(random);
      const glm::vec3 normal =
          glm::normalize(glm::vec3(0.5f * unit(random) - 0.25f, 0.5f * unit(random) - 0.25f, 1.0f));
      grid.set_surface(x, y, depth, normal, y > 30 && x < 30 ? 2u : 1u);
      grid.radiance[at(x, y)] = glm::vec4(std::exp(3.0f * unit(random)), unit(random), 1e4f * unit(random), 1.0f);
      if (unit(random) < 0.2f) grid.marks[at(x, y)].x = 1;  // shaded: unchanged
      if (depth <= 0.0f) grid.marks[at(x, y)] = glm::u8vec4(0);
    }
  for (glm::vec4& m : grid.axes)
    m = glm::vec4(std::exp(-6.0f * unit(random)), std::exp(-6.0f * unit(random)), 2.0f * unit(random) - 1.0f, 0.0f);
  for (const int level : {0, 1, 2})
    for (const Pass pass : {Pass::between, Pass::middle, Pass::quads}) {
      if (pass == Pass::quads && level > 0) continue;
      const std::vector<glm::vec4> found = filled(grid, level, pass);
      const TapByTap expected(grid, grid.radiance, level);
      int count = 0, off = 0;
      const auto check = [&](int x, int y, int dx, int dy) {
        if (grid.marks[at(x, y)].w == 0 || grid.marks[at(x, y)].x != 0) {
          EXPECT_EQ(found[at(x, y)], grid.radiance[at(x, y)]);
          return;
        }
        const glm::dvec3 e = pass == Pass::quads    ? expected.in_quad(x, y, dx, dy)
                             : pass == Pass::middle ? expected.middle(x, y)
                                                    : expected.between(x, y, dx, dy);
        bool agrees = true;
        for (int c = 0; c < 3; ++c) {
          const double tolerance = 2e-3 * std::abs(e[c]) + 1e-4;
          agrees = agrees && std::abs(static_cast<double>(found[at(x, y)][c]) - e[c]) <= tolerance;
        }
        ++count;
        off += agrees ? 0 : 1;
      };
      if (pass != Pass::middle) each_filled(level, false, check);
      if (pass != Pass::between) each_filled(level, true, check);
      EXPECT_GT(count, 100 >> (2 * level));
      // A weight near the middle of two codes may be rounded to either.
      EXPECT_LE(off, count / 50) << "level " << level << ", pass " << static_cast<int>(pass) << " of " << count;
    }
}

/// While frames accumulate a shaded point is compared with its neighbours if two of them are in a row, for every
/// orientation of the kernel, and never with a single one.
TEST(Upsampling, PointsAreJudgedByTwoNeighboursInARow) {
  const GlContext context = GlContext::create_headless();
  constexpr int kX = 21, kY = 21;  // in the middle of four
  struct Kind {
    const char* name;
    std::vector<glm::ivec2> same;  ///< neighbours on the same surface
    bool known;
  };
  const Kind kinds[] = {{"along x", {{-1, 0}, {1, 0}}, true},
                        {"along y", {{0, -1}, {0, 1}}, true},
                        {"a diagonal", {{-1, -1}, {1, 1}}, true},
                        {"the other", {{-1, 1}, {1, -1}}, true},
                        {"one corner", {{1, 1}}, false},
                        {"one beside", {{1, 0}}, false},
                        {"nothing", {}, false}};
  for (const Kind& kind : kinds)
    for (const float correlation : {-1.0f, 0.0f, 1.0f})
      for (const Pass pass : {Pass::middle, Pass::quads}) {
        if (pass == Pass::quads && std::string(kind.name).find("along") == 0) continue;  // it uses only corners
        Grid grid;
        for (glm::vec4& m : grid.axes) m = glm::vec4(0.1f, 0.1f, correlation, 0.0f);
        for (int y = 0; y < kFullHeight; ++y)
          for (int x = 0; x < kFullWidth; ++x) {
            grid.set_surface(x, y, 1.0f, glm::vec3(0.0f, 0.0f, 1.0f), 1u);
            grid.radiance[at(x, y)] = glm::vec4(3.0f);
          }
        grid.set_surface(kX, kY, 1.0f, glm::vec3(0.0f, 0.0f, 1.0f), 2u);
        for (const glm::ivec2& n : kind.same)
          grid.set_surface(kX + n.x, kY + n.y, 1.0f, glm::vec3(0.0f, 0.0f, 1.0f), 2u);
        grid.marks[at(kX, kY)].x = 1;
        grid.constants.sampling = glm::ivec4(64, 8, 0, 0);
        Own own;
        filled(grid, 0, pass, &own);
        const float residual = own.residual[at(kX, kY)];
        if (kind.known)
          EXPECT_NEAR(residual, 9.0f, 1e-3f) << kind.name << " " << correlation;
        else
          EXPECT_EQ(residual, -1.0f) << kind.name << " " << correlation;
      }
}

/// Steep waves across either diagonal: interpolation along the diagonal is exact, between two points in a row it is
/// wrong.
TEST(Upsampling, FollowsAFootprintThatIsStretchedAlongADiagonal) {
  const GlContext context = GlContext::create_headless();
  for (const int level : {0, 1})
    for (const int sign : {1, -1}) {
      const auto wave = [&](int x, int y) { return 2.0 + std::cos(2.2 * (x - sign * y) / (1 << level)); };
      Grid grid;
      for (int y = 0; y < kFullHeight; ++y)
        for (int x = 0; x < kFullWidth; ++x) {
          grid.set_surface(x, y, 1.0f, glm::vec3(0.0f, 0.0f, 1.0f), 1u);
          // Finer points contain the first dispatch's values for a wave that it cannot resolve.
          const bool coarse = (x >> level) % 2 == 0 && (y >> level) % 2 == 0;
          grid.radiance[at(x, y)] = glm::vec4(coarse ? static_cast<float>(wave(x, y)) : 2.0f);
        }
      const auto error = [&](float correlation) {
        for (glm::vec4& m : grid.axes) m = glm::vec4(0.1f, 0.1f, correlation, 0.0f);
        const std::vector<glm::vec4> found = filled(grid, level, Pass::middle);
        double square = 0.0;
        int count = 0;
        each_filled(level, true, [&](int x, int y, int, int) {
          if (x < 8 || y < 8 || x >= kFullWidth - 8 || y >= kFullHeight - 8) return;
          square += std::pow(static_cast<double>(found[at(x, y)].x) - wave(x, y), 2);
          ++count;
        });
        return std::sqrt(square / count);
      };
      const auto along = static_cast<float>(-sign);  // (nu_x, -+ nu_y): no cycles along the diagonal
      EXPECT_LT(error(along), 0.12) << level;
      EXPECT_GT(error(0.0f), 0.5) << level;
      EXPECT_GT(error(-along), error(0.0f)) << level;
    }
}

/// A cylinder across the viewing axis, its own axis rotated by `angle_deg` from the screen's right towards its top.
Scene rotated_cylinder(double angle_deg) {
  constexpr int kSides = 256;
  const double c = std::cos(glm::radians(angle_deg)), s = std::sin(glm::radians(angle_deg));
  Primitive p;
  p.material = 0;
  for (int k = 0; k <= kSides; ++k) {
    const double t = glm::pi<double>() * (static_cast<double>(k) / kSides - 0.5);
    for (const double along : {-4.0, 4.0}) {
      const glm::dvec3 n(-s * std::sin(t), c * std::sin(t), std::cos(t));
      p.positions.emplace_back(glm::dvec3(c * along, s * along, 0.0) + 0.5 * n);
      p.normals.emplace_back(n);
    }
  }
  for (std::uint32_t k = 0; k < 2 * kSides; k += 2)
    p.indices.insert(p.indices.end(), {k, k + 1, k + 2, k + 1, k + 3, k + 2});
  Scene scene;
  scene.materials.push_back(test::matte(glm::vec3(0.8f)));
  test::add(&scene, std::move(p));
  return scene;
}

/// The whole frame: the orientation of the footprint is computed on screen.
TEST(Upsampling, TheFootprintFollowsARotatedCylinder) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_environment(test::sky_with_lamp(glm::vec3(1.0f), glm::vec3(8.0f)));
  for (const double angle : {0.0, 20.0, 45.0, 80.0, 110.0, 135.0, 170.0}) {
    renderer.set_scene(std::make_shared<Scene>(rotated_cylinder(angle)));
    FrameRequest request;
    request.width = request.height = 96;
    request.mode = "bandwidth";
    request.camera.eye = {0.0f, 0.0f, 4.0f};
    request.camera.fov_y_rad = 0.3f;
    renderer.render(request);
    const Image angles = renderer.read_debug_view("footprint_angle"),
                stretch = renderer.read_debug_view("footprint_stretch");
    std::vector<double> off, stretched;
    for (int y = 0; y < 96; ++y)
      for (int x = 0; x < 96; ++x) {
        if (angles.at(x, y, 3) <= 0.0f) continue;
        const double d = std::abs(static_cast<double>(angles.at(x, y, 0)) - angle);
        off.push_back(std::min(d, 180.0 - d));
        stretched.push_back(stretch.at(x, y, 0));
      }
    ASSERT_GT(off.size(), 2000u);
    const auto median = [](std::vector<double>* v) {
      std::nth_element(v->begin(), v->begin() + static_cast<std::ptrdiff_t>(v->size() / 2), v->end());
      return (*v)[v->size() / 2];
    };
    EXPECT_LT(median(&off), 4.0) << angle;
    EXPECT_GT(median(&stretched), 3.0) << angle;
  }
}

}  // namespace
}  // namespace maquette
