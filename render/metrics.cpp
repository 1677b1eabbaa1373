#include "render/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "scenes/error.h"

namespace maquette {
namespace {

std::string size_text(const Image& image) { return std::to_string(image.width) + " x " + std::to_string(image.height); }

struct Pixel {
  std::array<double, 3> actual;
  std::array<double, 3> expected;
};

}  // namespace

ErrorFigures compare_images(const Image& image, const Image& reference) {
  if (image.width != reference.width || image.height != reference.height)
    throw Error("", "the pictures differ in size: " + size_text(image) + " and reference " + size_text(reference),
                "render both at the same --size");
  if (image.channels < 3 || reference.channels < 3) throw Error("", "a picture without R, G and B cannot be compared");
  ErrorFigures figures;
  std::vector<Pixel> pixels;
  double luminance = 0.0, peak = 0.0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (reference.channels > 3 && !(reference.at(x, y, 3) >= 1.0f)) continue;
      Pixel pixel{};
      bool finite = true;
      for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>(c);
        pixel.actual[k] = static_cast<double>(image.at(x, y, c));
        pixel.expected[k] = static_cast<double>(reference.at(x, y, c));
        finite = finite && std::isfinite(pixel.actual[k]) && std::isfinite(pixel.expected[k]);
      }
      if (!finite) {
        ++figures.invalid_count;
        continue;
      }
      const auto& e = pixel.expected;
      luminance += 0.2126 * e[0] + 0.7152 * e[1] + 0.0722 * e[2];
      peak = std::max({peak, e[0], e[1], e[2]});
      pixels.push_back(pixel);
    }
  }
  figures.pixel_count = pixels.size();
  if (pixels.empty()) return figures;
  const double mean = luminance / static_cast<double>(pixels.size());
  const double epsilon = 0.01 * mean * mean;
  double squares = 0.0, relative = 0.0;
  for (const Pixel& pixel : pixels) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double square = (pixel.actual[c] - pixel.expected[c]) * (pixel.actual[c] - pixel.expected[c]);
      squares += square;
      relative += square / (pixel.expected[c] * pixel.expected[c] + epsilon);
    }
  }
  const double count = 3.0 * static_cast<double>(pixels.size());
  figures.rmse = std::sqrt(squares / count);
  if (mean > 0.0) {
    figures.relative_rmse = *figures.rmse / mean;
    figures.relmse = relative / count;
  }
  if (*figures.rmse > 0.0 && peak > 0.0) figures.psnr = 20.0 * std::log10(peak / *figures.rmse);
  return figures;
}

}  // namespace maquette
