#include "render/metrics/ssim.h"

#include <algorithm>
#include <cmath>

#include "render/metrics/planes.h"
#include "scenes/luminance.h"

namespace maquette {
namespace {

constexpr int kRadius = 5;
constexpr double kSigma_px = 1.5;
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;

Plane luma(const Image& image) {
  Plane plane(image.width, image.height);
  for (std::size_t i = 0; i < plane.data.size(); ++i) {
    const float* p = &image.data[i * static_cast<std::size_t>(image.channels)];
    plane.data[i] = luminance(glm::vec3(p[0], p[1], p[2]));
  }
  return plane;
}

Plane product(const Plane& a, const Plane& b) {
  Plane result(a.width, a.height);
  for (std::size_t i = 0; i < a.data.size(); ++i) result.data[i] = a.data[i] * b.data[i];
  return result;
}

Kernel window() {
  double total = 0.0;
  for (int i = -kRadius; i <= kRadius; ++i) total += std::exp(-i * i / (2.0 * kSigma_px * kSigma_px));
  Kernel kernel;
  for (int i = -kRadius; i <= kRadius; ++i)
    kernel.push_back(static_cast<float>(std::exp(-i * i / (2.0 * kSigma_px * kSigma_px)) / total));
  return kernel;
}

}  // namespace

Image ssim_map(const Image& image, const Image& reference) {
  const Kernel kernel = window();
  const auto mean = [&](const Plane& plane) { return convolve(plane, kernel, kernel); };
  const Plane a = luma(image), b = luma(reference);
  const Plane mean_a = mean(a), mean_b = mean(b);
  const Plane square_a = mean(product(a, a)), square_b = mean(product(b, b)), both = mean(product(a, b));
  Image map(image.width, image.height, 1);
  for (std::size_t i = 0; i < map.data.size(); ++i) {
    const float ma = mean_a.data[i], mb = mean_b.data[i];
    const float var_a = std::max(square_a.data[i] - ma * ma, 0.0f), var_b = std::max(square_b.data[i] - mb * mb, 0.0f);
    const float covariance = both.data[i] - ma * mb;
    map.data[i] =
        ((2.0f * ma * mb + kC1) * (2.0f * covariance + kC2)) / ((ma * ma + mb * mb + kC1) * (var_a + var_b + kC2));
  }
  return map;
}

}  // namespace maquette
