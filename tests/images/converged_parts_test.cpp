// The parts of a converged picture, each against a slower computation: quadrature in double, mode uniform, exact means.
#include "tests/support/converged_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "render/gl/context.h"
#include "tests/support/sphere_quadrature.h"

namespace maquette::test {
namespace {

constexpr int kSide = 24;

/// A dim hall with lamps of a few texels each, 60 to 1000 times as bright as the mean.
Environment make_hall() {
  Environment hall;
  hall.name = "hall";
  hall.width = 512;
  hall.height = 256;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> even(0.0f, 1.0f);
  for (int i = 0; i < hall.width * hall.height; ++i) hall.rgb.push_back(glm::vec3(0.5f + even(random)) * 0.01f);
  for (int lamp = 0; lamp < 30; ++lamp) {
    const int x = static_cast<int>(even(random) * 511.0f), y = 20 + static_cast<int>(even(random) * 215.0f);
    const float light = 3.0f * std::pow(20.0f, even(random));
    for (int k = 0; k < 6; ++k)
      hall.rgb[static_cast<std::size_t>((y + k / 3) * hall.width + (x + k % 3) % hall.width)] =
          light * glm::vec3(1.0f, 0.8f, 0.5f + 0.1f * static_cast<float>(k));
  }
  return hall;
}

class ConvergedParts : public testing::Test {
 protected:
  void show(const std::string& material, const Environment& environment) {
    renderer_.set_scene(std::make_shared<Scene>(load_scene("builtin:sphere")));
    renderer_.set_environment(std::make_shared<Environment>(environment));
    renderer_.set_material("*", material);
  }
  Image draw(int samples, std::uint32_t seed, int frames = 1) {
    FrameRequest r;
    r.mode = "uniform";
    r.camera.eye = {0.0f, 0.0f, 4.5f};
    r.camera.fov_y_rad = 0.5236f;
    r.width = r.height = kSide;
    r.samples = samples;
    r.seed = seed;
    r.settings.set_from_text("shading.visibility", "none");
    for (int f = 0; f < frames; ++f) renderer_.render(r, f > 0);
    return renderer_.read_radiance();
  }
  void TearDown() override { EXPECT_TRUE(take_gl_errors().empty()); }

  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
};

TEST_F(ConvergedParts, LampsAndSunAgreeWithQuadrature) {
  for (const Environment& all : {make_hall(), load_environment("builtin:clear-sky")}) {
    const SplitEnvironment split = split_environment(all);
    ASSERT_GT(split.bright.size(), 4u);
    // Their light alone, as a separate map.
    Environment lamps = *split.rest;
    lamps.rgb.assign(lamps.rgb.size(), glm::vec3(0.0f));
    for (const BrightCell& cell : split.bright)
      lamps.rgb[static_cast<std::size_t>(cell.corner.y) * static_cast<std::size_t>(all.width) +
                static_cast<std::size_t>(cell.corner.x)] = glm::vec3(cell.light[0]);
    for (const char* material : {"builtin:metal-chrome", "builtin:paint-red-metallic", "builtin:matte-white"}) {
      show(material, *split.rest);
      draw(2, 0);
      const Image normals = renderer_.read_debug_view("normal");
      const SphereQuadrature exact = integrate_sphere(lamps, load_brdf(material), {4.5, 0.5236, kSide}, &normals);
      const double fine = relative_rmse(shade_cells(renderer_, split.bright, fine_grid(split), true), exact);
      const double coarse = relative_rmse(shade_cells(renderer_, split.bright, coarse_grid(split), true), exact);
      std::cout << all.name << ", " << material << ": fine grid " << 100.0 * fine << " %, coarse " << 100.0 * coarse
                << " %\n";
      // One pixel mirrors the sun: there the rounding of packed tables and floats is visible.
      const double bound = all.name == "hall" ? 0.003 : 0.01;
      EXPECT_LT(fine, bound) << material;
      EXPECT_LT(coarse, bound + 0.001) << material;
      EXPECT_LT(std::abs(fine - coarse), 0.001) << material;
    }
  }
}

TEST_F(ConvergedParts, SinglePixelsAreSampledAsModeUniformDoes) {
  show("builtin:paint-red-metallic", make_hall());
  std::vector<std::uint32_t> pixels;
  const Image alpha = draw(2, 0);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (alpha.at(x, y, 3) >= 1.0f) pixels.push_back(static_cast<std::uint32_t>(x | y << 16));
  const PixelSampler sampler;
  std::vector<glm::dvec3> difference(pixels.size()), square(pixels.size());
  constexpr int kSeeds = 24;
  double sum = 0.0;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    const Image whole = draw(1024, 100 + seed);
    draw(2, 300 + seed);
    const std::vector<glm::vec3> single = sampler.draw(pixels, 1024);
    for (std::size_t k = 0; k < pixels.size(); ++k)
      for (int c = 0; c < 3; ++c) {
        const float value = whole.at(static_cast<int>(pixels[k] & 65535u), static_cast<int>(pixels[k] >> 16), c);
        const double d = static_cast<double>(single[k][c]) - value;
        difference[k][c] += d;
        square[k][c] += d * d;
        sum += value;
      }
  }
  double total = 0.0, noise = 0.0, worst = 0.0;
  for (std::size_t k = 0; k < pixels.size(); ++k)
    for (int c = 0; c < 3; ++c) {
      total += difference[k][c];
      noise += square[k][c];
      worst = std::max(worst, std::abs(difference[k][c]) / std::sqrt(std::max(square[k][c], 1e-30)));
    }
  std::cout << "off by " << 100.0 * total / sum << " %, noise " << 100.0 * std::sqrt(noise) / sum << " %, worst pixel "
            << worst << " deviations\n";
  EXPECT_LT(std::abs(total), 5.0 * std::sqrt(noise) + 1e-4 * sum);
  EXPECT_LT(worst, 4.8);  // sums of 24 over the root of their squares, 1,000 of them: never above 4.9
}

/// In most runs the samples of a pixel miss the lamp, in a few they hit it: this biases adaptive counts.
TEST(SampledHalf, CountsDoNotBiasTheMean) {
  std::mt19937 random(11);
  std::bernoulli_distribution lamp(0.1);
  double crossed = 0.0, squares = 0.0, own = 0.0;
  constexpr int kTrials = 20000, kWidth = 16;
  const auto run = [&] { return glm::vec3(lamp(random) ? 10.0f : 0.0f); };
  for (int trial = 0; trial < kTrials; ++trial) {
    SampledHalf halves[2] = {{kWidth, 1}, {kWidth, 1}};
    for (SampledHalf& half : halves)
      for (int pilot = 0; pilot < 3; ++pilot) {
        Image image(kWidth, 1, 4);
        for (int x = 0; x < kWidth; ++x)
          for (int c = 0; c < 4; ++c) image.at(x, 0, c) = c < 3 ? run().x : 1.0f;
        half.add(image);
      }
    SampledHalf by_itself = halves[0];
    for (int more = 0; more < 10; ++more) {
      const auto add = [&](SampledHalf& half, const SampledHalf& other) {
        const std::vector<std::uint32_t> pixels = half.neediest(other, 4);
        std::vector<glm::vec3> values;
        for (std::size_t k = 0; k < pixels.size(); ++k) values.push_back(run());
        half.add(pixels, values);
      };
      add(halves[0], halves[1]);
      add(by_itself, by_itself);
    }
    double mean = 0.0, own_mean = 0.0;
    for (int x = 0; x < kWidth; ++x) {
      mean += halves[0].mean().at(x, 0, 0) / kWidth;
      own_mean += by_itself.mean().at(x, 0, 0) / kWidth;
    }
    crossed += (mean - 1.0) / kTrials;
    squares += (mean - 1.0) * (mean - 1.0) / kTrials;
    own += (own_mean - 1.0) / kTrials;
  }
  const double deviation = std::sqrt(squares / kTrials);
  std::cout << "by the other half's variance " << crossed << ", by its own " << own << ", +- " << deviation << '\n';
  EXPECT_LT(std::abs(crossed), 4.0 * deviation);
  EXPECT_LT(own, -10.0 * deviation);  // so the test would detect a bias
}

}  // namespace
}  // namespace maquette::test
