
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <deque>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "render/reference/pass_progress.h"
#include "render/reference/path.h"
#include "render/reference/pixel_sums.h"
#include "render/reference/presampled_environment.h"
#include "scenes/error.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr std::size_t kMostInTile = static_cast<std::size_t>(kTileWidth * kTileHeight);
static_assert(kMostInTile <= PathGroup::kMost);
constexpr std::size_t kTilesATask = 16;

/// Paths of every pixel before the counts become adaptive; the counts are decided again after each doubling. Two paths
/// say little about one pixel, but its neighbours contribute as well.
constexpr std::uint32_t kPilotPaths = 2;
/// Fewest paths a pixel of a complete pass, unless a decision ends it earlier.
constexpr std::uint32_t kLeastStep = 8;
/// A pass that is stopped leaves the pixels with unequal counts, so a pass adds at most this share of the existing
/// paths.
constexpr double kLargestStep = 0.25;
/// Least and largest number of paths of a pixel, relative to the average.
constexpr double kLeastRate = 0.25, kMostRate = 6.0;
constexpr int kSpreadRadius = 3;  ///< radius, in pixels, of the neighbourhood of a tile that decides its count
constexpr int kBlock = 8;         ///< pixels; the first pass goes from one pixel of each block to all of them

std::size_t pixel_count(const PictureRequest& r) {
  return static_cast<std::size_t>(r.width) * static_cast<std::size_t>(r.height);
}

HashGrid grid_of(const PathScene& scene, const PictureRequest& r) {
  return {r.camera.eye, std::max(scene.bounds.radius(), glm::length(scene.bounds.center() - r.camera.eye))};
}

/// Full transport only: without shadows there is nothing to learn.
bool learns(const PathScene& scene, const PictureRequest& r) {
  return r.paths.transport == Transport::full && !scene.bounds.empty();
}
std::unique_ptr<LightGuide> make_guide(const PathScene& scene, const PictureRequest& r) {
  if (!learns(scene, r) || scene.environment.black) return nullptr;
  return std::make_unique<LightGuide>(*scene.environment.partition, grid_of(scene, r));
}

/// Light paths that are traced over panes in each training iteration: this many for each pixel, and at least
/// kLeastLights, because small pictures show as much of the scene as large ones.
constexpr double kMirroredLights = 0.25;
constexpr std::size_t kLeastLights = 16384;
constexpr std::uint32_t kLastTrainedPath = 64;  ///< the last training iteration comes after so many paths
/// Before the first path of the picture, the guides are trained with one pixel in kTrainingSide^2: 1, then 2, then 4
/// paths, which do not count for the picture. Otherwise the first paths of all pixels would be drawn without a guide.
/// Small pictures, which a window shows first, have too few pixels for this.
constexpr int kTrainingSide = 8;
constexpr std::uint32_t kTrainingIterations = 3;
constexpr std::size_t kLeastTrained = std::size_t{1} << 14;  ///< pixels

}  // namespace

struct ReferencePicture::Impl {
  std::shared_ptr<const PathScene> scene;
  PictureRequest request;
  std::unique_ptr<LightGuide> guide;
  std::optional<PresampledEnvironment> samples;  ///< if there is a guide
  EnvironmentLight environment;
  std::optional<MirrorGuide> mirrors;
  CameraFrame camera;
  std::vector<PixelSums> pixels;
  /// [pixel] paths after `decided`, relative to the average. Empty: 1.
  std::vector<float> rates;
  std::vector<std::uint32_t> decided_counts;  ///< [pixel] paths at `decided`
  std::uint32_t decided = 0;
  std::uint32_t done = 0;  ///< paths a pixel in complete passes
  std::atomic<std::size_t> rays{0};
  std::uint32_t training_iteration = 0;  ///< complete training iterations before the first path
  std::vector<std::uint8_t> trained;     ///< [training pixel] done in the current iteration

  Impl(std::shared_ptr<const PathScene> s, const PictureRequest& r)
      : scene(std::move(s)),
        request(r),
        guide(make_guide(*scene, r)),
        samples(guide ? std::optional<PresampledEnvironment>(
                            std::in_place, EnvironmentLight(scene->environment, r.paths),
                            scene->environment.partition->leaf_count(), pixel_count(r), r.seed)
                      : std::nullopt),
        environment(scene->environment, r.paths, guide.get(), samples ? &*samples : nullptr) {
    if (learns(*scene, r)) mirrors.emplace(*scene, environment, grid_of(*scene, r), r.seed);
    camera = make_camera_frame(r.camera, r.width, r.height, scene->bounds);
    pixels.resize(pixel_count(r));
  }

  EyeRay eye_ray_through(const glm::vec2& at) const {
    const glm::vec2 size(request.width, request.height);
    const glm::vec2 ndc = 2.0f * at / size - 1.0f;
    return camera.ray_through(glm::vec2(ndc.x, -ndc.y));
  }

  /// A ray through a point of the picture, in pixels.
  struct PixelRay {
    Ray ray;
    RayDifferential differential;
  };
  PixelRay ray_through(const glm::vec2& at) const {
    // Textures are filtered over as much as rasterisation does: the spacing of its samples.
    const float step = request.footprint * (request.msaa == 16 ? 0.25f : request.msaa == 4 ? 0.5f : 1.0f);
    const EyeRay ray = eye_ray_through(at), x = eye_ray_through(at + glm::vec2(step, 0.0f)),
                 y = eye_ray_through(at + glm::vec2(0.0f, step));
    const glm::vec2 depths = camera.seen_depths(ray);
    return {{ray.origin, ray.direction, depths.x, depths.y}, {x.origin, y.origin, x.direction, y.direction}};
  }

  /// Number of paths of a pixel when the average is `average`.
  std::uint32_t target_of(std::size_t pixel, std::uint32_t average) const {
    if (rates.empty()) return average;
    // Rounded up with the fraction as probability: half a path for many pixels is many paths.
    const float chance = static_cast<float>(mix_seed(request.seed, tile_of(pixel)) >> 8) * 0x1p-24f;
    return decided_counts[pixel] +
           static_cast<std::uint32_t>(rates[pixel] * static_cast<float>(average - decided) + chance);
  }

  /// Of any pixel. Rounding in target_of can bring one more than kMostRate times the average.
  std::uint32_t most_paths(std::uint32_t average) const {
    if (rates.empty()) return average;
    std::uint32_t most = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) most = std::max(most, target_of(i, average));
    return most;
  }

  /// Adds one path's result to its pixel.
  static void add(const PathEstimate& e, PixelSums* p) {
    p->rays += e.rays;
    // A picture never holds NaN or infinity, whatever a table holds.
    const glm::dvec3 value = is_finite(e.radiance) ? glm::dvec3(e.radiance) : glm::dvec3(0.0);
    p->sum += value;
    p->square += value * value;
    p->covered += e.covered ? 1 : 0;
    ++p->count;
  }

  glm::vec2 corner_of(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(request.width);
    return {static_cast<float>(pixel % width), static_cast<float>(pixel / width)};
  }
  PathSampler sampler_of(std::size_t pixel, std::uint32_t path) const {
    return {mix_seed(request.seed, static_cast<std::uint32_t>(pixel)), path};
  }
  PixelRay first_ray(std::size_t pixel, const PathSampler& sampler) const {
    return ray_through(corner_of(pixel) + (request.msaa > 1 ? sampler.pair(0) : glm::vec2(0.5f)));
  }

  /// Full transport, paths of several pixels interleaved.
  class Tracer {
   public:
    Tracer(Impl* picture, const Halt& halt)
        : picture_(*picture),
          halt_(halt),
          group_(*picture->scene, picture->environment, picture->request.paths.max_bounces,
                 picture->mirrors ? &*picture->mirrors : nullptr) {}

    /// Adds paths until these pixels of a tile have their number; the results are there after complete().
    void add(std::span<const std::uint32_t> chosen, std::uint32_t average) {
      std::array<const CameraRay*, kMostInTile> rays{};
      std::uint32_t path = std::numeric_limits<std::uint32_t>::max(), end = 0;
      for (const std::uint32_t pixel : chosen) {
        path = std::min(path, picture_.pixels[pixel].count);
        end = std::max(end, picture_.target_of(pixel, average));
      }
      for (; path < end && !halt_(); ++path) {
        if (count_ + chosen.size() > PathGroup::kMost) complete();
        ++tile_;
        for (std::size_t i = 0; i < chosen.size(); ++i) {
          const std::uint32_t pixel = chosen[i];
          if (path < picture_.pixels[pixel].count || path >= picture_.target_of(pixel, average)) continue;
          const PathSampler sampler = picture_.sampler_of(pixel, path);
          // All paths through a pixel's centre share the camera ray.
          if (!rays[i] || picture_.request.msaa > 1) rays[i] = &first_ray(pixel, sampler);
          pixels_[count_] = pixel;
          tasks_[count_++] = {rays[i], sampler, tile_, {}};
        }
      }
    }
    void complete() {
      group_.follow(std::span(tasks_).first(count_));
      for (std::size_t i = 0; i < count_; ++i) {
        rays_ += tasks_[i].estimate.rays;
        Impl::add(tasks_[i].estimate, &picture_.pixels[pixels_[i]]);
      }
      paths_ += count_;
      count_ = 0;
      while (first_rays_.size() > kMostInTile) first_rays_.pop_front();  // the last tile may have more paths
    }
    std::size_t paths() const { return paths_; }
    std::size_t rays() const { return rays_; }

   private:
    const CameraRay& first_ray(std::size_t pixel, const PathSampler& sampler) {
      const PixelRay r = picture_.first_ray(pixel, sampler);
      first_rays_.emplace_back(*picture_.scene, picture_.environment, r.ray, &r.differential, 0u);
      rays_ += first_rays_.back().rays();
      return first_rays_.back();
    }

    Impl& picture_;
    const Halt& halt_;
    PathGroup group_;
    std::array<PathTask, PathGroup::kMost> tasks_;
    std::array<std::size_t, PathGroup::kMost> pixels_{};
    std::size_t count_ = 0, paths_ = 0, rays_ = 0;
    std::uint32_t tile_ = 0;  ///< number of the current tile path
    std::deque<CameraRay> first_rays_;
  };

  std::size_t trace_direct(std::size_t pixel, std::uint32_t target, const Halt& halt, std::size_t* ray_count) {
    PixelSums& p = pixels[pixel];
    const std::uint32_t first = p.count;
    while (p.count < target && !halt()) {
      const PathSampler sampler = sampler_of(pixel, p.count);
      const PixelRay r = first_ray(pixel, sampler);
      const PathEstimate e = estimate_direct(*scene, environment, sampler, r.ray, &r.differential);
      *ray_count += e.rays;
      add(e, &p);
    }
    return p.count - first;
  }

  /// Pixels in the order of their tiles.
  struct Tiles {
    std::vector<std::uint32_t> pixels;
    std::vector<std::size_t> begins{0};  ///< [tile + 1]
    std::size_t count() const { return begins.size() - 1; }
    std::span<const std::uint32_t> of(std::size_t tile) const {
      return std::span(pixels).subspan(begins[tile], begins[tile + 1] - begins[tile]);
    }
  };
  std::uint32_t tile_of(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(request.width);
    return static_cast<std::uint32_t>(pixel / width / kTileHeight * width + pixel % width / kTileWidth);
  }

  void trace_pixels(const Tiles& tiles, std::uint32_t average, const Halt& halt, const Progress& progress) {
    parallel_ranges<std::size_t>(0, tiles.count(), kTilesATask, [&](const auto& range) {
      std::size_t traced = 0, paths = 0;
      if (request.paths.transport == Transport::direct) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
          for (const std::uint32_t pixel : tiles.of(i))
            paths += trace_direct(pixel, target_of(pixel, average), halt, &traced);
      } else {
        Tracer tracer(this, halt);
        for (std::size_t i = range.begin(); i < range.end(); ++i) tracer.add(tiles.of(i), average);
        tracer.complete();
        paths = tracer.paths();
        traced = tracer.rays();
      }
      rays += traced;
      progress.add(paths);
    });
  }

  /// Traces until the pixels have `average` paths; false when it was halted before.
  bool trace_to(std::uint32_t average, const Halt& halt, const Progress& progress) {
    if (samples) samples->prepare(most_paths(average));
    if (done > 0) {
      trace_pixels(tiles_where([](int, int) { return true; }), average, halt, progress);
    } else {
      // From coarse to fine. The deadline does not interrupt the first pixel of each block.
      for (int side = kBlock; side > 0; side /= 2) {
        // Pixels whose coordinates are multiples of `side`, but not of 2 `side`.
        const auto in_grid = [side](int x, int y) {
          return x % side == 0 && y % side == 0 && (side == kBlock || x % (2 * side) != 0 || y % (2 * side) != 0);
        };
        trace_pixels(tiles_where(in_grid), average, side == kBlock ? Halt(halt.stop(), {}) : halt, progress);
      }
    }
    return !halt();
  }

  template <typename Which>
  Tiles tiles_where(const Which& which) const {
    Tiles tiles;
    for (int y = 0; y < request.height; y += kTileHeight)
      for (int x = 0; x < request.width; x += kTileWidth) {
        for (int v = y; v < std::min(y + kTileHeight, request.height); ++v)
          for (int u = x; u < std::min(x + kTileWidth, request.width); ++u)
            if (which(u, v)) tiles.pixels.push_back(static_cast<std::uint32_t>(v * request.width + u));
        if (tiles.pixels.size() > tiles.begins.back()) tiles.begins.push_back(tiles.pixels.size());
      }
    return tiles;
  }

  /// The sums of the pixel, or of one that stands for it.
  const PixelSums& sums_near(std::size_t pixel) const {
    const auto width = static_cast<std::size_t>(request.width);
    const std::size_t x = pixel % width, y = pixel / width;
    for (std::size_t side = 1; side < kBlock; side *= 2)
      if (const PixelSums& p = pixels[y / side * side * width + x / side * side]; p.count > 0) return p;
    return pixels[y / kBlock * kBlock * width + x / kBlock * kBlock];
  }

  /// [pixel] mean spread of the pixels around its tile, without those of the tile. A pixel's own samples, and those of
  /// its tile, must not decide its number of paths: pixels with small values by chance would get fewer paths, and the
  /// picture would be too dark.
  std::vector<float> spreads_around() const {
    const int width = request.width, height = request.height;
    std::vector<float> own(pixels.size()), around(pixels.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) own[i] = spread_of(pixels[i]);
    const Tiles tiles = tiles_where([](int, int) { return true; });
    parallel_for(std::size_t{0}, tiles.count(), [&](std::size_t tile) {
      const std::span<const std::uint32_t> inside = tiles.of(tile);
      const int x = static_cast<int>(inside[0]) % width, y = static_cast<int>(inside[0]) / width;
      float sum = 0.0f;
      int count = 0;
      for (int v = std::max(y - kSpreadRadius, 0); v < std::min(y + kTileHeight + kSpreadRadius, height); ++v)
        for (int u = std::max(x - kSpreadRadius, 0); u < std::min(x + kTileWidth + kSpreadRadius, width); ++u) {
          if (u >= x && u < x + kTileWidth && v >= y && v < y + kTileHeight) continue;
          sum += own[static_cast<std::size_t>(v * width + u)];
          ++count;
        }
      for (const std::uint32_t pixel : inside) around[pixel] = count > 0 ? sum / static_cast<float>(count) : 0.0f;
    });
    return around;
  }

  /// Decides the numbers of paths until the average has doubled.
  void find_rates() {
    const std::vector<float> spreads = spreads_around();
    const double mean = std::accumulate(spreads.begin(), spreads.end(), 0.0) / static_cast<double>(spreads.size());
    if (!(mean > 0.0)) return;
    decided_counts.resize(pixels.size());
    rates.resize(pixels.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) decided_counts[i] = pixels[i].count;
    const auto rate_of = [&](std::size_t pixel, double scale) {
      const double wanted = std::clamp(scale * static_cast<double>(spreads[pixel]), kLeastRate, kMostRate) * 2.0 * done;
      return std::max((wanted - decided_counts[pixel]) / done, kLeastRate);
    };
    // The bounds shift the average: find the scale by bisection.
    double low = 0.0, high = 1e3 / mean;
    for (int i = 0; i < 40; ++i) {
      const double scale = 0.5 * (low + high);
      double sum = 0.0;
      for (std::size_t k = 0; k < pixels.size(); ++k) sum += rate_of(k, scale);
      (sum > static_cast<double>(pixels.size()) ? high : low) = scale;
    }
    for (std::size_t i = 0; i < pixels.size(); ++i) rates[i] = static_cast<float>(rate_of(i, low));
    decided = done;
  }

  void learn() {
    if (guide) guide->learn();
    learn_mirrors();
  }
  void learn_mirrors() {
    mirrors->learn(
        std::max(kLeastLights, static_cast<std::size_t>(kMirroredLights * static_cast<double>(pixels.size()))));
  }

  /// Traces the paths of one training pixel.
  void train_pixel(const glm::vec2& at, std::uint32_t seed) {
    const PixelRay r = ray_through(at);
    const CameraRay ray(*scene, environment, r.ray, &r.differential, 0u);
    std::size_t traced = ray.rays();
    const std::uint32_t count = 1u << training_iteration;
    static_assert(1u << (kTrainingIterations - 1) <= PathGroup::kMost);
    std::array<PathTask, PathGroup::kMost> tasks;
    for (std::uint32_t i = 0; i < count; ++i) tasks[i] = {&ray, {seed, count - 1 + i}, 0, {}};
    const std::span wanted = std::span(tasks).first(count);
    PathGroup(*scene, environment, request.paths.max_bounces, &*mirrors).follow(wanted);
    for (const PathTask& task : wanted) traced += task.estimate.rays;
    rays += traced;
  }

  /// Runs the training iterations before the first path. False when it was stopped; the next call continues from there.
  bool train(const std::stop_token& stop) {
    if (pixels.size() < kLeastTrained || training_iteration == kTrainingIterations) return true;
    if (samples) samples->prepare(1u << kTrainingIterations);
    const int columns = request.width / kTrainingSide, rows = request.height / kTrainingSide;
    const std::uint32_t seed = mix_seed(request.seed, 0x747261u);
    for (; training_iteration < kTrainingIterations; ++training_iteration) {
      trained.resize(static_cast<std::size_t>(columns * rows));
      parallel_for(0, columns * rows, [&](int i) {
        std::uint8_t& is_trained = trained[static_cast<std::size_t>(i)];
        if (is_trained || stop.stop_requested()) return;
        const glm::vec2 at = (glm::vec2(i % columns, i / columns) + 0.5f) * static_cast<float>(kTrainingSide);
        train_pixel(at, mix_seed(seed, static_cast<std::uint32_t>(i)));
        is_trained = 1;
      });
      if (stop.stop_requested()) return false;
      if (guide) guide->learn();
      trained.clear();
    }
    learn_mirrors();
    return true;
  }

  template <typename Value>
  Image image(int channels, const Value& value) const {
    Image out(request.width, request.height, channels);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const glm::dvec4 v = value(i);
      for (int c = 0; c < channels; ++c)
        out.data[i * static_cast<std::size_t>(channels) + static_cast<std::size_t>(c)] = static_cast<float>(v[c]);
    }
    return out;
  }
};

ReferencePicture::ReferencePicture(std::shared_ptr<const PathScene> scene, const PictureRequest& request)
    : impl_(std::make_unique<Impl>(std::move(scene), request)) {}
ReferencePicture::~ReferencePicture() = default;
ReferencePicture::ReferencePicture(ReferencePicture&&) noexcept = default;
ReferencePicture& ReferencePicture::operator=(ReferencePicture&&) noexcept = default;

const PictureRequest& ReferencePicture::request() const { return impl_->request; }

/// The guides are updated after 1, 2, 4, ... paths a pixel, however the calls divide the paths.
bool ReferencePicture::add(int count, const std::stop_token& stop, const std::function<void(double)>& progress,
                           const Deadline& deadline) {
  Impl& s = *impl_;
  const Halt halt(stop, deadline);
  const std::uint32_t target = s.done + static_cast<std::uint32_t>(std::max(count, 0));
  if (s.mirrors && target > 0 && !s.train(stop)) return false;
  const Progress report(progress, s.pixels.size() * static_cast<std::size_t>(std::max(count, 1)));
  while (s.done < target) {
    const bool learns = s.mirrors && s.done < kLastTrainedPath;
    std::uint32_t next = learns ? std::min(target, std::bit_ceil(s.done + 1)) : target;
    const auto step = static_cast<std::uint32_t>(kLargestStep * s.done);
    next = std::min(next, s.done + std::max(step, kLeastStep));
    if (s.request.adaptive) next = std::min(next, std::bit_ceil(s.done + 1));
    if (!s.trace_to(next, halt, report)) return false;
    s.done = next;
    if (learns && std::has_single_bit(next)) s.learn();
    if (s.request.adaptive && next >= kPilotPaths && std::has_single_bit(next)) s.find_rates();
  }
  return true;
}

ReferenceCounts ReferencePicture::counts() const {
  ReferenceCounts counts;
  counts.rays = impl_->rays;
  for (const PixelSums& p : impl_->pixels) {
    counts.paths += p.count;
    counts.covered_pixels += p.covered > 0 ? 1 : 0;
  }
  return counts;
}

int ReferencePicture::samples() const { return static_cast<int>(impl_->done); }

Image ReferencePicture::mean() const {
  return impl_->image(4, [this](std::size_t pixel) {
    const PixelSums& p = impl_->sums_near(pixel);
    const double scale = p.count > 0 ? 1.0 / p.count : 0.0;
    return glm::dvec4(p.sum * scale, p.covered * scale);
  });
}

Image ReferencePicture::variance() const {
  return impl_->image(3, [this](std::size_t i) { return glm::dvec4(variance_of_mean(impl_->pixels[i]), 0.0); });
}

double ReferencePicture::relative_error(bool whole) const {
  double variance = 0.0, light = 0.0;
  std::size_t count = 0;
  for (const PixelSums& p : impl_->pixels) {
    if (p.count < 2) return 0.0;
    if (!whole && p.covered < p.count) continue;
    const glm::dvec3 v = variance_of_mean(p);
    variance += v.x + v.y + v.z;
    light += luminance(p.sum) / p.count;
    ++count;
  }
  if (count == 0 || !(light > 0.0)) return 0.0;
  const auto n = static_cast<double>(count);
  return std::sqrt(variance / (3.0 * n)) / (light / n);
}

}  // namespace maquette
