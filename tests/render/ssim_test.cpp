#include "render/metrics/ssim.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "scenes/luminance.h"

namespace maquette {
namespace {

Image noise(int width, int height, std::uint32_t seed) {
  std::mt19937 random(seed);
  Image image(width, height, 3);
  for (float& value : image.data) value = static_cast<float>(random()) / 4294967296.0f;
  return image;
}

/// Wang et al. 2004 for one pixel, as a plain double sum over the window.
double slow(const Image& a, const Image& b, int x, int y) {
  const auto luma = [](const Image& image, int i, int j) {
    i = std::clamp(i, 0, image.width - 1);
    j = std::clamp(j, 0, image.height - 1);
    return luminance(image, i, j);
  };
  double weight = 0.0, ma = 0.0, mb = 0.0;
  const auto w = [](int i, int j) { return std::exp(-(i * i + j * j) / 4.5); };
  for (int j = -5; j <= 5; ++j)
    for (int i = -5; i <= 5; ++i) {
      weight += w(i, j);
      ma += w(i, j) * luma(a, x + i, y + j);
      mb += w(i, j) * luma(b, x + i, y + j);
    }
  ma /= weight;
  mb /= weight;
  double va = 0.0, vb = 0.0, ab = 0.0;
  for (int j = -5; j <= 5; ++j)
    for (int i = -5; i <= 5; ++i) {
      const double da = luma(a, x + i, y + j) - ma, db = luma(b, x + i, y + j) - mb;
      va += w(i, j) * da * da / weight;
      vb += w(i, j) * db * db / weight;
      ab += w(i, j) * da * db / weight;
    }
  return (2 * ma * mb + 1e-4) * (2 * ab + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
}

TEST(Ssim, AgreesWithTheSlowVersion) {
  const Image a = noise(20, 15, 1), b = noise(20, 15, 2);
  const Image map = ssim_map(a, b);
  for (const auto& [x, y] : {std::pair{0, 0}, {10, 7}, {19, 14}, {4, 12}})
    EXPECT_NEAR(static_cast<double>(map.at(x, y)), slow(a, b, x, y), 1e-4);
}

TEST(Ssim, ClosedForms) {
  const Image a = noise(20, 15, 1);
  for (const float v : ssim_map(a, a).data) EXPECT_NEAR(v, 1.0f, 1e-5f);
  // Even pictures: only the term of the means is left.
  const double expected = (2 * 0.2 * 0.6 + 1e-4) / (0.04 + 0.36 + 1e-4);
  EXPECT_NEAR(static_cast<double>(ssim_map(Image(12, 12, 3, 0.2f), Image(12, 12, 3, 0.6f)).at(6, 6)), expected, 1e-4);
  EXPECT_NEAR(static_cast<double>(ssim_map(Image(3, 2, 3), Image(3, 2, 3)).at(0, 0)), 1.0, 1e-6);
}

}  // namespace
}  // namespace maquette
