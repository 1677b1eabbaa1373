// Predicted against measured: local bandwidth of the converged picture, variance over seeds, and a mirror sphere under
// a sky whose bandwidth is known in closed form.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "scenes/error.h"
#include "scenes/luminance.h"
#include "tests/benchmarks/stage.h"
#include "tests/support/local_bandwidth.h"

namespace maquette::bench {
namespace {

/// Pairs of predicted and measured values.
struct Pairs {
  std::vector<double> predicted, measured;
  std::vector<double> marks;  ///< of a window: its noise over its variation; of a quad: its material
  std::vector<glm::ivec2> pixels;
  std::size_t windows = 0;  ///< including those left out because noise hides their variation
  void append(const Pairs& other) {
    predicted.insert(predicted.end(), other.predicted.begin(), other.predicted.end());
    measured.insert(measured.end(), other.measured.begin(), other.measured.end());
    windows += other.windows;
  }
};

struct Agreement {
  double rank = 0.0, under = 0.0, ratio = 0.0, ratio_10 = 0.0, ratio_90 = 0.0;
};

/// The measurement cannot tell values below `floor` from it, so both count as the floor: a pair is under-estimated only
/// if the prediction is below a measurement above the floor.
Agreement agree(const Pairs& pairs, double floor) {
  Agreement a;
  std::vector<double> ratios, predicted = pairs.predicted, measured = pairs.measured;
  for (double& v : predicted) v = std::max(v, floor);
  for (double& v : measured) v = std::max(v, floor);
  a.rank = test::rank_correlation(predicted, measured);
  std::size_t under = 0;
  for (std::size_t i = 0; i < pairs.predicted.size(); ++i) {
    if (pairs.measured[i] > floor && pairs.predicted[i] < pairs.measured[i]) ++under;
    ratios.push_back(std::max(pairs.predicted[i], floor) / std::max({pairs.measured[i], floor, 1e-30}));
  }
  a.under = ratios.empty() ? 0.0 : static_cast<double>(under) / static_cast<double>(ratios.size());
  a.ratio = test::median(ratios);
  a.ratio_10 = test::percentile(ratios, 0.1);
  a.ratio_90 = test::percentile(ratios, 0.9);
  return a;
}

std::string text_of(const Agreement& a, const Pairs& pairs) {
  return "rank correlation " + number(a.rank) + ", under-estimated " + percent(a.under) + ", predicted over measured " +
         number(a.ratio) + " (10 %: " + number(a.ratio_10) + ", 90 %: " + number(a.ratio_90) + "), " +
         std::to_string(pairs.predicted.size()) + " of " + std::to_string(pairs.windows);
}

struct Definition {
  const char* name;
  test::LocalBandwidthOptions options;
  test::Pooling pooling;
  std::optional<test::WindowFilter> scaled = {};  ///< windows from 16 to 128 pixels instead of one size
  double floor() const { return scaled ? test::kScaledFloor : test::measured_floor(options); }
};

std::vector<Definition> definitions() {
  using test::Pooling;
  std::vector<Definition> d;
  test::LocalBandwidthOptions plain;
  d.push_back({"16 to 128 px, off edges by the longest", plain, Pooling::variation, test::WindowFilter::off_longest});
  d.push_back({"16 to 128 px, off edges by its own", plain, Pooling::variation, test::WindowFilter::off_own});
  d.push_back({"32 px, centre", plain, Pooling::centre});
  d.push_back({"32 px, mean", plain, Pooling::mean});
  d.push_back({"32 px, variation", plain, Pooling::variation});
  d.push_back({"32 px, light", plain, Pooling::light});
  d.push_back({"32 px, largest", plain, Pooling::largest});
  test::LocalBandwidthOptions quadrature = plain;
  quadrature.undo_window = test::UndoWindow::quadrature;
  d.push_back({"32 px, variation, window undone in quadrature", quadrature, Pooling::variation});
  test::LocalBandwidthOptions root = plain;
  root.square_root = true;
  d.push_back({"32 px, mean, square root", root, Pooling::mean});
  test::LocalBandwidthOptions with_mean = plain;
  with_mean.remove_mean = false;
  d.push_back({"32 px, mean, constant kept", with_mean, Pooling::mean});
  test::LocalBandwidthOptions wide = plain;
  wide.window = 64;
  d.push_back({"64 px, mean", wide, Pooling::mean});
  d.push_back({"64 px, variation", wide, Pooling::variation});
  wide.window = 128;
  d.push_back({"128 px, variation", wide, Pooling::variation});
  test::LocalBandwidthOptions small = plain;
  small.window = 16;
  d.push_back({"16 px, mean", small, Pooling::mean});
  return d;
}
constexpr std::size_t kJudged = 4;  // index into definitions(): see docs/performance.md

struct Views {
  Image bandwidth, variance, material;
  std::vector<bool> smooth;
};

Views predict(Stage& stage, int samples) {
  Renderer& renderer = stage.renderer();
  renderer.render(stage.request("bandwidth", samples));
  Views v;
  v.bandwidth = renderer.read_debug_view("bandwidth");
  v.variance = renderer.read_debug_view("variance");
  v.material = renderer.read_debug_view("material");
  v.smooth =
      test::smooth_surface_pixels(renderer.read_debug_view("depth"), renderer.read_debug_view("normal"), v.material);
  return v;
}

Pairs bandwidth_pairs(const Views& views, const Reference& reference, const Definition& d) {
  Pairs pairs;
  const Image &a = reference.halves[0], &b = reference.halves[1];
  const auto add = [&](const test::WindowBandwidth& w, int window) {
    pairs.predicted.push_back(test::pooled_prediction(views.bandwidth, reference.picture, w, window, d.pooling));
    pairs.measured.push_back(std::max(w.nu_x, w.nu_y));
    pairs.marks.push_back(w.noise);
    pairs.pixels.push_back({w.x, w.y});
  };
  if (d.scaled) {
    for (const auto& w : test::measure_scaled_bandwidth(a, b, views.smooth, *d.scaled)) add(w.bandwidth, w.window);
    pairs.windows = pairs.predicted.size();
    return pairs;
  }
  for (const auto& w : test::measure_local_bandwidth(a, b, views.smooth, d.options)) {
    ++pairs.windows;
    if (w.noise <= test::kMostNoise) add(w, d.options.window);
  }
  return pairs;
}

/// Variance of one sample: n times the variance of frames of n samples over many seeds, over quads as in the
/// prediction.
Pairs variance_pairs(Stage& stage, const Views& views, int samples, int seeds) {
  const Case& c = stage.current();
  Renderer& renderer = stage.renderer();
  const auto count = static_cast<std::size_t>(c.width * c.height);
  std::vector<double> sum(count, 0.0), square(count, 0.0);
  for (int s = 0; s < seeds; ++s) {
    renderer.render(stage.request("uniform", samples, static_cast<std::uint32_t>(501 + s)));
    const Image p = renderer.read_radiance();
    for (std::size_t i = 0; i < count; ++i) {
      const float* rgb = &p.data[4 * i];
      const double y = luminance(glm::dvec3(rgb[0], rgb[1], rgb[2]));
      sum[i] += y;
      square[i] += y * y;
    }
  }
  Pairs pairs;
  for (int y = 0; y + 1 < c.height; y += 2) {
    for (int x = 0; x + 1 < c.width; x += 2) {
      double measured = 0.0;
      bool smooth = true;
      for (int k = 0; k < 4; ++k) {
        const auto i = static_cast<std::size_t>((y + k / 2) * c.width + x + k % 2);
        smooth = smooth && views.smooth[i];
        measured += 0.25 * samples * (square[i] - sum[i] * sum[i] / seeds) / (seeds - 1);
      }
      if (!smooth) continue;
      ++pairs.windows;
      if (measured <= 0.0) continue;
      pairs.predicted.push_back(views.variance.at(x, y));
      pairs.measured.push_back(measured);
      pairs.marks.push_back(views.material.at(x, y));
      pairs.pixels.push_back({x, y});
    }
  }
  return pairs;
}

void write_pairs(const Stage& stage, const std::string& what, const Pairs& pairs) {
  const std::string name = what + "-" + stage.current().name;
  std::string path = stage.options().scratch + "/";
  for (const char c : name) path += c == '/' ? '-' : c;
  if (FILE* file = std::fopen((path + ".csv").c_str(), "w")) {
    for (std::size_t i = 0; i < pairs.predicted.size(); ++i)
      std::fprintf(file, "%g,%g,%g,%d,%d\n", pairs.predicted[i], pairs.measured[i], pairs.marks[i], pairs.pixels[i].x,
                   pairs.pixels[i].y);
    std::fclose(file);
  }
}

Figures judge(const std::string& what, const Pairs& pairs, double floor) {
  const Agreement a = agree(pairs, floor);
  return {judged(what + ", rank correlation", ">= 0.8", number(a.rank), a.rank >= 0.8),
          judged(what + ", under-estimated", "<= 5 %", percent(a.under), a.under <= 0.05),
          judged(what + ", median predicted / measured", "<= 2", number(a.ratio), a.ratio <= 2.0)};
}

/// A sky that varies along the horizon only: L = 1 + cos(m longitude), 1024 x 512.
std::shared_ptr<Environment> make_wave_sky(int m) {
  auto sky = std::make_shared<Environment>();
  sky->name = "cos(" + std::to_string(m) + " phi)";
  sky->width = 1024;
  sky->height = 512;
  sky->rgb.reserve(1024 * 512);
  for (int y = 0; y < sky->height; ++y)
    for (int x = 0; x < sky->width; ++x)
      sky->rgb.emplace_back(static_cast<float>(1.0 + std::cos(m * 2.0 * std::numbers::pi * (x + 0.5) / sky->width)));
  sky->hash = 0x5ca1ab1eu + static_cast<std::uint64_t>(m);
  return sky;
}

/// Longitude of the sky that a mirror sphere of radius 1 at the origin shows at a pixel of its equator.
double reflected_longitude(const FrameRequest& r, double x) {
  const double distance = glm::length(glm::dvec3(r.camera.eye));
  const double u = (2.0 * x / r.width - 1.0) * std::tan(0.5 * r.camera.fov_y_rad) * r.width / r.height;
  const double c = 1.0 / std::sqrt(1.0 + u * u), s = u * c;  // the ray is (s, -c), the eye (0, distance)
  const double t = distance * c - std::sqrt(1.0 - distance * distance * s * s);
  const double nx = t * s, nz = distance - t * c;
  const double along = 2.0 * (s * nx - c * nz);
  return std::atan2(s - along * nx, -c - along * nz);
}

Figures measure_mirror(Stage& stage) {
  const Case c{
      .name = "mirror", .scene = "builtin:sphere", .material = "builtin:metal-chrome", .width = 256, .height = 256};
  stage.show(c);
  Figures figures;
  double worst = 0.0;
  for (const int m : {4, 6, 8, 12, 16, 24, 32}) {
    stage.renderer().set_environment(make_wave_sky(m));
    const FrameRequest r = stage.request("bandwidth", 64);
    stage.renderer().render(r);
    const Image predicted = stage.renderer().read_debug_view("bandwidth");
    std::vector<double> ratios;
    for (int y = c.height / 2 - 3; y <= c.height / 2 + 2; ++y) {
      for (int x = c.width * 3 / 10; x < c.width * 7 / 10; ++x) {
        if (predicted.at(x, y, 3) < 1.0f) continue;
        double rotation = reflected_longitude(r, x + 1.0) - reflected_longitude(r, x);
        rotation = std::abs(std::remainder(rotation, 2.0 * std::numbers::pi));
        ratios.push_back(predicted.at(x, y) / (m / (2.0 * std::numbers::pi) * rotation));
      }
    }
    const double ratio = test::median(ratios);
    worst = std::max(worst, std::abs(ratio - 1.0));
    figures.push_back(shown("mirror sphere under cos(" + std::to_string(m) + " phi)",
                            "predicted over closed form " + number(ratio) +
                                " (10 %: " + number(test::percentile(ratios, 0.1)) +
                                ", 90 %: " + number(test::percentile(ratios, 0.9)) + ")"));
  }
  figures.push_back(judged("mirror sphere under cos(m phi), worst m", "within 20 %", percent(worst), worst <= 0.2));
  Case back = c;
  back.environment = "builtin:studio";  // the stage does not know the skies above
  stage.show(back);
  return figures;
}

}  // namespace

namespace {

/// ValidationSums over one set of cases.
struct ValidationSums {
  std::vector<Pairs> bandwidth = std::vector<Pairs>(definitions().size());
  Pairs variance;
};

Figures measure_case(Stage& stage, Case c, ValidationSums* sums) {
  constexpr int kFrameSamples = 64;
  Figures figures;
  c.plain = true;  // light is interpolated, and the prediction is for light
  stage.show(c);
  const Views views = predict(stage, kFrameSamples);
  const std::vector<Definition> all = definitions();
  for (std::size_t i = 0; i < all.size() && stage.options().reference_seconds > 0.0; ++i) {  // 0: variance alone
    const Pairs pairs = bandwidth_pairs(views, stage.reference(), all[i]);
    sums->bandwidth[i].append(pairs);
    const double floor = all[i].floor();
    std::fprintf(stderr, "  %-16s %-28s %s\n", c.name.c_str(), all[i].name,
                 text_of(agree(pairs, floor), pairs).c_str());
    if (i != kJudged) continue;
    figures.push_back(shown("bandwidth, " + c.name, text_of(agree(pairs, floor), pairs)));
    write_pairs(stage, "bandwidth", pairs);
  }
  const Pairs variance = variance_pairs(stage, views, kFrameSamples, 32);
  sums->variance.append(variance);
  write_pairs(stage, "variance", variance);
  figures.push_back(shown("variance, " + c.name, text_of(agree(variance, 0.0), variance)));
  std::fprintf(stderr, "  %-16s %-28s %s\n", c.name.c_str(), "variance",
               text_of(agree(variance, 0.0), variance).c_str());
  return figures;
}

void show_sums(const std::string& set, const ValidationSums& sums, Figures* figures) {
  const std::vector<Definition> all = definitions();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (sums.bandwidth[i].predicted.empty()) continue;
    const double floor = all[i].floor();
    figures->push_back(
        shown("bandwidth, " + set + ", " + all[i].name, text_of(agree(sums.bandwidth[i], floor), sums.bandwidth[i])));
  }
  if (!sums.variance.predicted.empty())
    figures->push_back(shown("variance, " + set, text_of(agree(sums.variance, 0.0), sums.variance)));
}

}  // namespace

Figures measure_validation(Stage& stage) {
  Figures figures;
  if (stage.options().wants("mirror")) figures = measure_mirror(stage);
  const auto measure = [&](const std::vector<Case>& cases, ValidationSums* sums) {
    for (const Case& c : cases) {
      if (!stage.options().wants(c.name)) continue;
      for (Figure& f : measure_case(stage, c, sums)) figures.push_back(std::move(f));
    }
  };
  ValidationSums sky, grace;
  measure(quality_cases(stage.options()), &sky);
  measure(research_cases(stage.options()), &grace);  // many small lamps: the paper's validation
  show_sums("all", sky, &figures);
  show_sums("under Grace", grace, &figures);
  if (sky.variance.predicted.empty()) return figures;
  const double floor = definitions()[kJudged].floor();
  for (Figure& f : judge("bandwidth", sky.bandwidth[kJudged], floor)) figures.push_back(std::move(f));
  for (Figure& f : judge("variance", sky.variance, 0.0)) figures.push_back(std::move(f));
  return figures;
}

}  // namespace maquette::bench
