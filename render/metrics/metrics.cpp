#include "render/metrics/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "render/metrics/flip.h"
#include "render/metrics/ssim.h"
#include "render/picture/tonemap.h"
#include "render/views/false_color.h"
#include "scenes/error.h"
#include "scenes/luminance.h"

namespace maquette {
namespace {

std::string size_text(const Image& image) { return std::to_string(image.width) + " x " + std::to_string(image.height); }

void check_comparable(const Image& image, const Image& reference) {
  if (image.width != reference.width || image.height != reference.height)
    throw Error("", "the pictures differ in size: " + size_text(image) + " and reference " + size_text(reference),
                "render both at the same --size");
  for (const auto& [picture, name] : {std::pair{&image, "the picture"}, std::pair{&reference, "the reference"}})
    if (picture->channels < 3)
      throw Error("", std::string(name) + " has " + std::to_string(picture->channels) +
                          " channels: a picture without R, G and B cannot be compared");
}

bool is_finite(const Image& image, int x, int y) {
  const float* p = &image.data[image.index(x, y)];
  const bool alpha = image.channels < 4 || std::isfinite(p[3]);
  return alpha && std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// An alpha of NaN counts, so that it is said.
bool is_counted(const Image& reference, int x, int y) {
  return reference.channels <= 3 || !(reference.at(x, y, 3) < 1.0f);
}

/// Both pictures, set to black in both where one is invalid, so that no filter carries the fault into compared pixels.
/// The sky is kept, because a viewer sees it beside the surfaces.
struct Cleaned {
  Image image, reference;
  std::vector<std::size_t> compared;  ///< pixel indices
};

Cleaned clean(const Image& image, const Image& reference) {
  Cleaned result{Image(image.width, image.height, 3), Image(image.width, image.height, 3), {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (!is_finite(image, x, y) || !is_finite(reference, x, y)) continue;
      if (is_counted(reference, x, y)) result.compared.push_back(result.image.index(x, y) / 3);
      for (int c = 0; c < 3; ++c) {
        result.image.at(x, y, c) = image.at(x, y, c);
        result.reference.at(x, y, c) = reference.at(x, y, c);
      }
    }
  }
  return result;
}

double mean_over(const Image& map, const std::vector<std::size_t>& pixels) {
  double sum = 0.0;
  for (const std::size_t i : pixels) sum += static_cast<double>(map.data[i]);
  return sum / static_cast<double>(pixels.size());
}

/// Inverse of the display encoding. Source: IEC 61966-2-1.
float light_from_srgb(float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); }

void add_notes(const Image& reference, ErrorFigures* f) {
  if (f->invalid_count > 0)
    f->notes.push_back(std::to_string(f->invalid_count) +
                       " pixels are NaN or infinite in one of the pictures and were left out");
  if (f->pixel_count == 0) {
    f->notes.push_back(f->invalid_count > 0
                           ? "no pixel is left to compare"
                           : "the reference has alpha below 1 everywhere: it shows only sky, nothing to compare");
    return;
  }
  if (!f->relative_rmse)
    f->notes.push_back("the reference is black where it is compared: relative figures do not exist");
  if (f->rmse && *f->rmse == 0.0)
    f->notes.push_back(f->invalid_count > 0 ? "the pictures are equal where both are finite"
                                            : "the pictures are equal");
  std::size_t dark = 0;
  for (int y = 0; y < reference.height; ++y)
    for (int x = 0; x < reference.width; ++x)
      dark += is_counted(reference, x, y) && !(luminance(reference, x, y) > 0.0) ? 1 : 0;
  if (f->relative_rmse && 2 * dark > f->pixel_count)
    f->notes.push_back("more than half of the reference is black: FLIP's exposures follow the pixels with light");
}

struct Pixel {
  std::array<double, 3> actual;
  std::array<double, 3> expected;
};

}  // namespace

ErrorFigures compare_images(const Image& image, const Image& reference) {
  check_comparable(image, reference);
  ErrorFigures figures;
  const auto for_each_pixel = [&](const auto& add) {
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        if (!is_counted(reference, x, y)) continue;
        Pixel pixel{};
        for (int c = 0; c < 3; ++c) {
          pixel.actual[static_cast<std::size_t>(c)] = static_cast<double>(image.at(x, y, c));
          pixel.expected[static_cast<std::size_t>(c)] = static_cast<double>(reference.at(x, y, c));
        }
        add(pixel, is_finite(image, x, y) && is_finite(reference, x, y));
      }
  };
  double luminance_sum = 0.0, peak = 0.0;
  for_each_pixel([&](const Pixel& pixel, bool finite) {
    ++(finite ? figures.pixel_count : figures.invalid_count);
    if (!finite) return;
    const auto& e = pixel.expected;
    luminance_sum += luminance(glm::dvec3(e[0], e[1], e[2]));
    peak = std::max({peak, e[0], e[1], e[2]});
  });
  if (figures.pixel_count == 0) return figures;
  const double mean = luminance_sum / static_cast<double>(figures.pixel_count);
  const double epsilon = 0.01 * mean * mean;
  double squares = 0.0, relative = 0.0;
  for_each_pixel([&](const Pixel& pixel, bool finite) {
    for (std::size_t c = 0; finite && c < 3; ++c) {
      const double square = (pixel.actual[c] - pixel.expected[c]) * (pixel.actual[c] - pixel.expected[c]);
      squares += square;
      relative += square / (pixel.expected[c] * pixel.expected[c] + epsilon);
    }
  });
  const double count = 3.0 * static_cast<double>(figures.pixel_count);
  figures.rmse = std::sqrt(squares / count);
  if (mean > 0.0) {
    figures.relative_rmse = *figures.rmse / mean;
    figures.relmse = relative / count;
  }
  if (*figures.rmse > 0.0 && peak > 0.0) figures.psnr = 20.0 * std::log10(peak / *figures.rmse);
  return figures;
}

double display_exposure_ev(const Image& reference) {
  double sum = 0.0;
  std::size_t count = 0;
  for (int y = 0; y < reference.height; ++y) {
    for (int x = 0; x < reference.width; ++x) {
      const double value = luminance(reference, x, y);
      if (!is_counted(reference, x, y) || !std::isfinite(value) || !(value > 0.0)) continue;
      sum += std::log2(value);
      ++count;
    }
  }
  return count == 0 ? 0.0 : std::log2(0.18) - sum / static_cast<double>(count);
}

ErrorReport measure_error(const Image& image, const Image& reference) {
  constexpr std::size_t kMostPixels = std::size_t{1} << 25;  // 8K; the metrics take over a hundred bytes a pixel
  if (image.data.size() / static_cast<std::size_t>(image.channels) > kMostPixels)
    throw Error("", "pictures of " + size_text(image) + " are too large to be compared", "render them at 7680x4320");
  ErrorReport report;
  report.figures = compare_images(image, reference);
  ErrorFigures& figures = report.figures;
  add_notes(reference, &figures);
  report.flip_map = Image(image.width, image.height, 1);
  if (figures.pixel_count == 0) return report;
  const Cleaned cleaned = clean(image, reference);
  report.flip_map = flip_hdr_map(cleaned.image, cleaned.reference);
  figures.flip = mean_over(report.flip_map, cleaned.compared);
  figures.display_ev = display_exposure_ev(cleaned.reference);
  const auto ev = static_cast<float>(*figures.display_ev);
  Image shown = tone_map(cleaned.image, ev, "pbr-neutral"), expected = tone_map(cleaned.reference, ev, "pbr-neutral");
  figures.ssim = mean_over(ssim_map(shown, expected), cleaned.compared);
  for (Image* picture : {&shown, &expected})
    for (float& value : picture->data) value = light_from_srgb(value);
  figures.flip_ldr = mean_over(flip_ldr_map(shown, expected), cleaned.compared);
  return report;
}

Image difference_picture(const ErrorReport& report, const Image& image, const Image& reference) {
  Image values = report.flip_map;
  for (int y = 0; y < values.height; ++y)
    for (int x = 0; x < values.width; ++x)
      if (!is_finite(image, x, y) || !is_finite(reference, x, y)) values.at(x, y) = NAN;
  Image picture = false_color_image(values, FalseColorRange{0.0f, 1.0f});
  for (int y = 0; y < values.height; ++y)
    for (int x = 0; x < values.width; ++x)
      if (reference.channels > 3) picture.at(x, y, 3) = reference.at(x, y, 3);
  return picture;
}

}  // namespace maquette
