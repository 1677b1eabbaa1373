#include "render/metrics/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "render/metrics/flip_filters.h"

namespace maquette {
namespace {

using Vec = std::array<double, 3>;

// An independent FLIP, implemented directly from the papers: in double, with two-dimensional kernels, pixel by pixel.
namespace slow {

Vec xyz(const Vec& c) {
  return {0.4124564 * c[0] + 0.3575761 * c[1] + 0.1804375 * c[2],
          0.2126729 * c[0] + 0.7151522 * c[1] + 0.0721750 * c[2],
          0.0193339 * c[0] + 0.1191920 * c[1] + 0.9503041 * c[2]};
}
const Vec kWhite = xyz({1.0, 1.0, 1.0});

Vec rgb(const Vec& v) {  // the inverse matrix of IEC 61966-2-1
  return {3.2404542 * v[0] - 1.5371385 * v[1] - 0.4985314 * v[2],
          -0.9692660 * v[0] + 1.8760108 * v[1] + 0.0415560 * v[2],
          0.0556434 * v[0] - 0.2040259 * v[1] + 1.0572252 * v[2]};
}

Vec ycxcz(const Vec& c) {
  Vec v = xyz(c);
  for (std::size_t i = 0; i < 3; ++i) v[i] /= kWhite[i];
  return {116.0 * v[1] - 16.0, 500.0 * (v[0] - v[1]), 200.0 * (v[1] - v[2])};
}

Vec hunt_lab(const Vec& c) {
  Vec v = xyz(c);
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = v[i] / kWhite[i];
    v[i] = t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0;
  }
  const double l = 116.0 * v[1] - 16.0;
  return {l, 0.01 * l * 500.0 * (v[0] - v[1]), 0.01 * l * 200.0 * (v[1] - v[2])};
}

double hyab(const Vec& a, const Vec& b) { return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]); }

struct Kernel {
  int radius;
  std::vector<double> weights;
  double at(int x, int y) const {
    return weights[static_cast<std::size_t>((y + radius) * (2 * radius + 1) + x + radius)];
  }
};

template <typename F>
Kernel make(int radius, const F& value, bool balanced) {
  Kernel k{radius, {}};
  double positive = 0.0, negative = 0.0;
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) {
      k.weights.push_back(value(x, y));
      (k.weights.back() > 0.0 ? positive : negative) += k.weights.back();
    }
  for (double& w : k.weights) w /= balanced && w < 0.0 ? -negative : positive;
  return k;
}

Vec pixel(const Image& image, int x, int y) {
  x = std::clamp(x, 0, image.width - 1);
  y = std::clamp(y, 0, image.height - 1);
  Vec v{};
  for (int c = 0; c < 3; ++c)
    v[static_cast<std::size_t>(c)] = std::clamp(static_cast<double>(image.at(x, y, c)), 0.0, 1.0);
  return v;
}

template <typename F>
double filter(const Image& image, int x, int y, const Kernel& k, const F& channel) {
  double sum = 0.0;
  for (int j = -k.radius; j <= k.radius; ++j)
    for (int i = -k.radius; i <= k.radius; ++i) sum += k.at(i, j) * channel(ycxcz(pixel(image, x + i, y + j)));
  return sum;
}

double flip(const Image& a, const Image& b, int x, int y, double ppd) {
  const int radius =
      static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * std::numbers::pi * std::numbers::pi)) * ppd));
  const double parameters[3][4] = {{1.0, 0.0047, 0.0, 1e-5}, {1.0, 0.0053, 0.0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
  Vec colors[2];
  for (std::size_t c = 0; c < 3; ++c) {
    const double* p = parameters[c];
    const Kernel k = make(
        radius,
        [&](int i, int j) {
          const double d2 = (i * i + j * j) / (ppd * ppd);
          return p[0] * std::sqrt(std::numbers::pi / p[1]) *
                     std::exp(-std::numbers::pi * std::numbers::pi * d2 / p[1]) +
                 p[2] * std::sqrt(std::numbers::pi / p[3]) * std::exp(-std::numbers::pi * std::numbers::pi * d2 / p[3]);
        },
        false);
    for (int picture = 0; picture < 2; ++picture)
      colors[picture][c] = filter(picture == 0 ? a : b, x, y, k, [c](const Vec& v) { return v[c]; });
  }
  for (Vec& color : colors) {
    const double yy = (color[0] + 16.0) / 116.0;
    Vec light = rgb({(yy + color[1] / 500.0) * kWhite[0], yy * kWhite[1], (yy - color[2] / 200.0) * kWhite[2]});
    for (double& v : light) v = std::clamp(v, 0.0, 1.0);
    color = hunt_lab(light);
  }
  const double largest = std::pow(hyab(hunt_lab({0.0, 1.0, 0.0}), hunt_lab({0.0, 0.0, 1.0})), 0.7);
  double color = std::pow(hyab(colors[0], colors[1]), 0.7);
  color =
      color < 0.4 * largest ? 0.95 / (0.4 * largest) * color : 0.95 + (color - 0.4 * largest) / (0.6 * largest) * 0.05;
  const double sigma = 0.5 * 0.082 * ppd;
  const int r = static_cast<int>(std::ceil(3.0 * sigma));
  const auto gauss = [&](int i, int j) { return std::exp(-(i * i + j * j) / (2.0 * sigma * sigma)); };
  double feature = 0.0;
  for (const bool point : {false, true}) {
    const auto shape = [&](int i, int j) {
      return (point ? i * i / (sigma * sigma) - 1.0 : -static_cast<double>(i)) * gauss(i, j);
    };
    const Kernel across = make(r, shape, true), down = make(
                                                    r, [&](int i, int j) { return shape(j, i); }, true);
    const auto lightness = [](const Vec& v) { return (v[0] + 16.0) / 116.0; };
    const auto strength = [&](const Image& image) {
      return std::hypot(filter(image, x, y, across, lightness), filter(image, x, y, down, lightness));
    };
    feature = std::max(feature, std::abs(strength(a) - strength(b)));
  }
  return std::pow(color, 1.0 - std::sqrt(feature / std::sqrt(2.0)));
}

}  // namespace slow

Image noise(int width, int height, std::uint32_t seed, float scale = 1.0f) {
  std::mt19937 random(seed);
  Image image(width, height, 3);
  for (float& value : image.data) value = scale * static_cast<float>(random()) / 4294967296.0f;
  return image;
}

double mean(const Image& map) {
  double sum = 0.0;
  for (const float v : map.data) sum += static_cast<double>(v);
  return sum / static_cast<double>(map.data.size());
}

TEST(FlipLdr, EqualPicturesDifferNowhere) {
  const Image a = noise(23, 17, 1);
  for (const float v : flip_ldr_map(a, a).data) EXPECT_EQ(v, 0.0f);
}

TEST(FlipLdr, BlackAgainstWhiteAndGreenAgainstBlueAreAtTheTop) {
  // Constant pictures have no features; lightness 100 is below the largest distance (green to blue), which maps to 1.
  Image green(30, 30, 3), blue(30, 30, 3);
  for (int i = 0; i < 900; ++i) {
    green.data[static_cast<std::size_t>(3 * i + 1)] = 1.0f;
    blue.data[static_cast<std::size_t>(3 * i + 2)] = 1.0f;
  }
  EXPECT_NEAR(flip_ldr_map(green, blue).at(15, 15), 1.0f, 1e-3f);
  const double black_white = static_cast<double>(flip_ldr_map(Image(30, 30, 3), Image(30, 30, 3, 1.0f)).at(15, 15));
  const double largest = slow::hyab(slow::hunt_lab({0, 1, 0}), slow::hunt_lab({0, 0, 1}));
  const double ratio = std::pow(100.0 / largest, 0.7);
  EXPECT_NEAR(black_white, 0.95 + (ratio - 0.4) / 0.6 * 0.05, 1e-3);
}

TEST(FlipLdr, IsSymmetric) {
  const Image a = noise(31, 19, 1), b = noise(31, 19, 2);
  const Image ab = flip_ldr_map(a, b), ba = flip_ldr_map(b, a);
  for (std::size_t i = 0; i < ab.data.size(); ++i) EXPECT_EQ(ab.data[i], ba.data[i]);
}

TEST(FlipLdr, AgreesWithTheSlowVersion) {
  for (const double ppd : {kFlipPixelsPerDegree, 25.0}) {
    const Image a = noise(29, 21, 3);
    Image b = a;
    const Image n = noise(29, 21, 4);
    for (std::size_t i = 0; i < b.data.size(); ++i) b.data[i] += 0.3f * (n.data[i] - 0.5f);
    for (int y = 8; y < 12; ++y)
      for (int x = 3; x < 9; ++x) b.at(x, y, 0) = 1.0f;
    const Image map = flip_ldr_map(a, b, ppd);
    EXPECT_GT(mean(map), 0.05);
    for (const auto& [x, y] : {std::pair{0, 0}, {5, 9}, {14, 10}, {28, 20}, {3, 7}, {20, 2}})
      EXPECT_NEAR(static_cast<double>(map.at(x, y)), slow::flip(a, b, x, y, ppd), 2e-4) << x << ' ' << y << ' ' << ppd;
  }
}

TEST(FlipLdr, WhatIsFinerThanTheEyeIsSeenLess) {
  // The same squared difference as a checkerboard of one pixel and as a uniform veil.
  Image grey(64, 64, 3, 0.5f), veil(64, 64, 3, 0.6f), fine(64, 64, 3);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) fine.at(x, y, c) = (x + y) % 2 == 0 ? 0.6f : 0.4f;
  const double seen_veil = mean(flip_ldr_map(veil, grey)), seen_fine = mean(flip_ldr_map(fine, grey));
  EXPECT_GT(seen_veil, 0.0);
  EXPECT_LT(seen_fine, seen_veil);
}

TEST(FlipFilters, WeightsSumAsThePaperSays) {
  const auto sum = [](const Kernel& k, bool positive) {
    double total = 0.0;
    for (const float v : k) total += positive == (v > 0.0f) ? static_cast<double>(v) : 0.0;
    return total;
  };
  for (const flip::SpatialFilter& f : flip::spatial_filters(kFlipPixelsPerDegree)) {
    EXPECT_EQ(f.first.size(), 21u);  // 0.7 m from 3,840 pixels over 0.7 m: a radius of 10
    const double first = sum(f.first, true), second = f.second.empty() ? 0.0 : sum(f.second, true);
    EXPECT_NEAR(first * first + second * second, 1.0, 1e-5);
  }
  const flip::FeatureFilters f = flip::feature_filters(kFlipPixelsPerDegree);
  EXPECT_NEAR(sum(f.gaussian, true), 1.0, 1e-6);
  for (const Kernel* k : {&f.edge, &f.point}) {
    EXPECT_NEAR(sum(*k, true), 1.0, 1e-6);
    EXPECT_NEAR(sum(*k, false), -1.0, 1e-6);
  }
}

TEST(FlipHdr, ExposuresGoFromTheBrightestToTheMedian) {
  Image image(5, 1, 3);
  const float values[] = {1.0f, 2.0f, 4.0f, 8.0f, 64.0f};
  for (int x = 0; x < 5; ++x)
    for (int c = 0; c < 3; ++c) image.at(x, 0, c) = values[x];
  const FlipExposures e = flip_exposures(image);
  EXPECT_NEAR(e.stop_ev - e.start_ev, 4.0, 1e-9);  // 64 over the median 4
  EXPECT_EQ(e.count, 4);
  // at the first exposure the brightest pixel is displayed at 0.85 of the curve
  const double x = 64.0 * std::exp2(e.start_ev);
  EXPECT_NEAR((0.9036 * x * x + 0.018 * x) / (0.8748 * x * x + 0.354 * x + 0.14), 0.85, 1e-6);
}

TEST(FlipHdr, IsTheLargestOverTheExposures) {
  const Image a = noise(20, 14, 5, 30.0f), b = noise(20, 14, 6, 30.0f);
  const FlipExposures e = flip_exposures(b);
  Image expected(20, 14, 1);
  for (int i = 0; i < e.count; ++i) {
    const double scale = std::exp2(e.start_ev + (e.stop_ev - e.start_ev) * i / (e.count - 1));
    const auto shown = [scale](Image picture) {
      for (float& v : picture.data) {
        const double x = static_cast<double>(v) * scale;
        v = static_cast<float>(std::min((0.9036 * x * x + 0.018 * x) / (0.8748 * x * x + 0.354 * x + 0.14), 1.0));
      }
      return picture;
    };
    const Image map = flip_ldr_map(shown(a), shown(b));
    for (std::size_t k = 0; k < map.data.size(); ++k) expected.data[k] = std::max(expected.data[k], map.data[k]);
  }
  const Image map = flip_hdr_map(a, b);
  for (std::size_t k = 0; k < map.data.size(); ++k) EXPECT_NEAR(map.data[k], expected.data[k], 1e-4f);
}

TEST(FlipHdr, DoesNotDependOnTheUnit) {
  const Image a = noise(20, 14, 5), b = noise(20, 14, 6);
  Image a2 = a, b2 = b;
  for (Image* picture : {&a2, &b2})
    for (float& v : picture->data) v *= 1000.0f;
  EXPECT_NEAR(mean(flip_hdr_map(a, b)), mean(flip_hdr_map(a2, b2)), 1e-5);
}

TEST(FlipHdr, DarkPicturesHaveAResult) {
  // More than half is black: the median would be 0, the exposures infinite.
  Image mostly(10, 10, 3);
  for (int x = 0; x < 10; ++x)
    for (int c = 0; c < 3; ++c) mostly.at(x, 0, c) = 1.0f + static_cast<float>(x);
  const FlipExposures e = flip_exposures(mostly);
  EXPECT_TRUE(std::isfinite(e.stop_ev));
  EXPECT_FALSE(e.black);
  const Image black(10, 10, 3);
  EXPECT_TRUE(flip_exposures(black).black);
  EXPECT_EQ(mean(flip_hdr_map(black, black)), 0.0);
  const double seen = mean(flip_hdr_map(mostly, black));
  EXPECT_GT(seen, 0.0);
  EXPECT_LE(seen, 1.0);
  // A sun 1e6 times the rest, and the half-float limit.
  Image sun = mostly;
  sun.at(5, 5, 1) = 65504.0f * 1e3f;
  for (const float v : flip_hdr_map(sun, mostly).data) EXPECT_TRUE(v >= 0.0f && v <= 1.0f);
}

}  // namespace
}  // namespace maquette
