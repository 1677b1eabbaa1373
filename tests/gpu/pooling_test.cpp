#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <vector>

#include "render/frame/frame_constants.h"
#include "render/gl/bindings.h"
#include "render/gl/context.h"
#include "render/gl/objects.h"

namespace maquette {
namespace {

constexpr float kAngle = 0.01f, kFootprint = 0.02f;
constexpr int kSamples = 8, kTile = 8;

/// A synthetic prediction: patches of three materials, holes of sky, some quads without a prediction.
struct Predicted {
  int width, height, quads_x, quads_y;
  std::vector<float> depth;
  std::vector<glm::uvec4> surface;
  std::vector<glm::vec4> energy, near;

  Predicted(int w, int h, bool first_only) : width(w), height(h), quads_x((w + 1) / 2), quads_y((h + 1) / 2) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        depth.push_back((x / 5 + 2 * (y / 7)) % 9 == 0 || unit(random) < 0.05f ? 0.0f : 1.0f);
        surface.emplace_back(0u, 0u, static_cast<unsigned>((x / 13 + y / 9) % 3) << 16u, 0u);
      }
    for (int y = 0; y < quads_y; ++y)
      for (int x = 0; x < quads_x; ++x) {
        const glm::ivec2 p = visible(x, y);
        const bool known = p.x >= 0 && (first_only ? x % 2 == 0 && y % 2 == 0 : unit(random) < 0.6f);
        const float t = std::exp(4.0f * unit(random)), near_t = 0.3f * unit(random) * t;
        const glm::vec4 e(t * (1.0f + 5.0f * unit(random)), t + near_t, 0.3f * t * t, own(p));
        energy.push_back(known ? e : glm::vec4(0.0f));
        near.push_back(known ? glm::vec4(3.0f * near_t, near_t, 2.0f * near_t * near_t, 1.0f) : glm::vec4(0.0f));
      }
  }
  std::size_t pixel(glm::ivec2 p) const { return static_cast<std::size_t>(p.y * width + p.x); }
  std::size_t quad(int x, int y) const { return static_cast<std::size_t>(y * quads_x + x); }
  float own(glm::ivec2 p) const { return p.x < 0 ? 0.0f : static_cast<float>((surface[pixel(p)].z >> 16u) + 1u); }
  glm::ivec2 visible(int x, int y) const {
    for (int k = 0; k < 4; ++k) {
      const int j = (k + x + 2 * y) & 3;
      const glm::ivec2 p = glm::min(glm::ivec2(2 * x + (j & 1), 2 * y + (j >> 1)), glm::ivec2(width - 1, height - 1));
      if (depth[pixel(p)] > 0.0f) return p;
    }
    return glm::ivec2(-1);
  }

  /// The result of bandwidth.comp for a quad, tap by tap: 5 x 5 quads of its material, with the border repeated.
  glm::vec4 pooled(int x, int y) const {
    const glm::ivec2 p = visible(x, y);
    if (p.x < 0) return glm::vec4(0.0f);
    double nu = 0.0, sum = 0.0, square = 0.0, count = 0.0, near_nu = 0.0, light_variance = 0.0;
    for (int k = 0; k < 25; ++k) {
      const std::size_t i = quad(std::clamp(x + k % 5 - 2, 0, quads_x - 1), std::clamp(y + k / 5 - 2, 0, quads_y - 1));
      if (energy[i].w != own(p)) continue;
      const double w = k == 12 ? 1.0 : 0.6;
      nu += w * energy[i].x;
      sum += w * energy[i].y;
      square += w * energy[i].z;
      count += w;
      near_nu += w * near[i].x;
      light_variance += w * near[i].z;
    }
    if (count <= 0.0) return glm::vec4(1e4f * kAngle, 0.0f, 0.0f, 1.0f);
    const double spread = light_variance / count;
    return glm::vec4(nu / sum * kAngle + near_nu / sum * kFootprint, sum / count,
                     std::sqrt(kSamples * square / count + spread), 1.0f);
  }
};

template <typename T>
Texture texture_of(GLenum internal, GLenum format, GLenum type, int w, int h, const std::vector<T>& values) {
  Texture t = Texture::make_2d("test", internal, w, h);
  t.upload(0, w, h, format, type, values.data());
  return t;
}

std::vector<glm::vec4> read_level(const Texture& texture, int level, int w, int h) {
  std::vector<glm::vec4> values(static_cast<std::size_t>(w * h));
  glGetTextureImage(texture.get(), level, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(values.size() * sizeof(glm::vec4)),
                    values.data());
  return values;
}

/// Runs the pass over all tiles and compares every quad, and the pyramid's next level where blocks are whole.
void expect_pooled_as_tap_by_tap(int w, int h, bool first_only) {
  const Predicted in(w, h, first_only);
  const bool coarse = in.quads_x % 2 == 0 && in.quads_y % 2 == 0;
  FrameConstants constants{};
  constants.size = glm::ivec4(w, h, first_only ? 2 : 1, 4);
  constants.environment = glm::vec4(1.0f, 0.0f, 1.0f, 1.0f);
  constants.eye.w = 1.0f;
  constants.forward.w = kAngle;
  const Buffer block("frame", sizeof constants, &constants);
  std::vector<unsigned> list;
  for (int y = 0; y < (h + kTile - 1) / kTile; ++y)
    for (int x = 0; x < (w + kTile - 1) / kTile; ++x) list.push_back(static_cast<unsigned>(x | y << 16));
  const Buffer tiles = Buffer::from("tiles", list);
  const Texture surface = texture_of(GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, w, h, in.surface);
  const Texture depth = texture_of(GL_R32F, GL_RED, GL_FLOAT, w, h, in.depth);
  const Texture energy = texture_of(GL_RGBA32F, GL_RGBA, GL_FLOAT, in.quads_x, in.quads_y, in.energy);
  const Texture near = texture_of(GL_RGBA32F, GL_RGBA, GL_FLOAT, in.quads_x, in.quads_y, in.near);
  const unsigned footprint = std::bit_cast<unsigned>(kFootprint);
  const std::vector<glm::uvec4> flat(in.energy.size(), glm::uvec4(footprint, footprint, 0u, 0u));
  const Texture curvature = texture_of(GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, in.quads_x, in.quads_y, flat);
  const Texture pyramid = Texture::make_2d("pyramid", GL_RGBA32F, in.quads_x, in.quads_y, 2);
  const Texture axes = Texture::make_2d("axes", GL_RGBA16F, in.quads_x, in.quads_y);

  glBindBufferBase(GL_UNIFORM_BUFFER, kBlockFrame, block.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferTiles, tiles.get());
  glBindTextureUnit(kUnitSurface, surface.get());
  glBindTextureUnit(kUnitDepth, depth.get());
  glBindTextureUnit(kUnitEnergy, energy.get());
  glBindTextureUnit(kUnitNear, near.get());
  glBindTextureUnit(kUnitScreenCurvature, curvature.get());
  glBindImageTexture(kImageBandwidth, pyramid.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageAxes, axes.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA16F);
  glBindImageTexture(kImageFirstCoarse, pyramid.get(), 1, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const Program program =
      Program::compute("bandwidth/bandwidth.comp", {{"TEXTURE_BANDWIDTH", "0"},
                                                    {"NEAR", "1"},
                                                    {"COARSE", coarse ? "1" : "0"},
                                                    {"FIRST_ONLY", first_only ? "1" : "0"},
                                                    {"PREDICTION_SAMPLES", std::to_string(kSamples)}});
  const auto count = static_cast<int>(list.size());
  glProgramUniform4i(program.get(), program.location("u_tiles"), 0, count, 1, 0);
  glUseProgram(program.get());
  glDispatchCompute(static_cast<GLuint>((4 * count + 63) / 64), 1, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);

  const std::vector<glm::vec4> fine = read_level(pyramid, 0, in.quads_x, in.quads_y);
  const auto near_to = [](glm::vec4 a, glm::vec4 b) {
    return glm::all(glm::lessThanEqual(glm::abs(a - b), 2e-4f * glm::abs(b) + 1e-6f));
  };
  for (int y = 0; y < in.quads_y; ++y)
    for (int x = 0; x < in.quads_x; ++x) {
      // At the border the last quads replace those beyond it; with taps two apart they count less often.
      if (first_only && (std::min(x, y) < 2 || x >= in.quads_x - 2 || y >= in.quads_y - 2)) continue;
      const glm::vec4 expected = in.pooled(x, y), found = fine[in.quad(x, y)];
      EXPECT_TRUE(near_to(found, expected)) << x << ", " << y << ": " << found.x << " " << found.y << " " << found.z
                                            << " for " << expected.x << " " << expected.y << " " << expected.z;
    }
  if (!coarse) return;
  const int half_x = in.quads_x / 2, half_y = in.quads_y / 2;
  const std::vector<glm::vec4> next = read_level(pyramid, 1, half_x, half_y);
  for (int y = 0; y < half_y; ++y)
    for (int x = 0; x < half_x; ++x) {
      glm::vec4 sum(0.0f);
      float largest = 0.0f;
      for (int k = 0; k < 4; ++k) {
        const glm::vec4 v = fine[in.quad(2 * x + (k & 1), 2 * y + (k >> 1))];
        largest = std::max(largest, v.x);
        sum += v;
      }
      const glm::vec4 expected(largest, sum.y / std::max(sum.w, 1.0f), sum.z / std::max(sum.w, 1.0f), sum.w);
      EXPECT_TRUE(near_to(next[static_cast<std::size_t>(y * half_x + x)], expected)) << x << ", " << y;
    }
}

TEST(Pooling, AgreesWithTapByTap) {
  const GlContext context = GlContext::create_headless();
  expect_pooled_as_tap_by_tap(96, 64, false);
  expect_pooled_as_tap_by_tap(101, 61, false);  // odd numbers of quads
}

TEST(Pooling, AgreesWithTapByTapWhereTheFirstQuadOfABlockIsPredicted) {
  const GlContext context = GlContext::create_headless();
  expect_pooled_as_tap_by_tap(96, 64, true);
}

}  // namespace
}  // namespace maquette
