#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "render/reference/path.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr std::size_t kPixelsATask = 128;

/// Sums over the paths of one pixel. Double: float stops growing at 1.7e7 equal terms and loses the variance long
/// before.
struct PixelSums {
  glm::dvec3 sum{0.0};
  glm::dvec3 square{0.0};
  std::uint32_t count = 0;
  std::uint32_t covered = 0;
};

glm::dvec3 variance_of_mean(const PixelSums& p) {
  if (p.count < 2) return glm::dvec3(0.0);
  const double n = p.count;
  const glm::dvec3 variance = glm::max(p.square - p.sum * p.sum / n, glm::dvec3(0.0)) / (n - 1.0);
  return variance / n;
}

bool is_finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// Calls back about 100 times.
class Progress {
 public:
  Progress(const std::function<void(double)>& report, std::size_t total) : report_(report), total_(total) {}
  void add(std::size_t count) const {
    const std::size_t before = done_.fetch_add(count);
    if (report_ && (before + count) * 100 / total_ != before * 100 / total_)
      report_(std::min(static_cast<double>(before + count) / static_cast<double>(total_), 1.0));
  }

 private:
  const std::function<void(double)>& report_;
  std::size_t total_;
  mutable std::atomic<std::size_t> done_{0};
};

PlaceGrid grid_of(const PathScene& scene, const PictureRequest& r) {
  return {r.camera.eye, std::max(scene.bounds.radius(), glm::length(scene.bounds.center() - r.camera.eye))};
}

/// Full transport only: what throws no shadows has nothing to learn.
bool learns(const PathScene& scene, const PictureRequest& r) {
  return r.paths.transport == Transport::full && !scene.bounds.empty();
}
std::unique_ptr<LightGuide> make_guide(const PathScene& scene, const PictureRequest& r) {
  if (!learns(scene, r) || scene.environment.black) return nullptr;
  return std::make_unique<LightGuide>(*scene.environment.partition, grid_of(scene, r));
}

/// Lights that are sent over panes at each lesson, a pixel.
constexpr double kMirroredLights = 0.25;
constexpr std::uint32_t kLastLesson = 64;  ///< after so many paths

}  // namespace

struct ReferencePicture::Impl {
  std::shared_ptr<const PathScene> scene;
  PictureRequest request;
  std::unique_ptr<LightGuide> guide;
  EnvironmentLight environment;
  std::optional<MirrorGuide> mirrors;
  CameraFrame camera;
  std::vector<PixelSums> pixels;
  std::atomic<std::size_t> rays{0};

  Impl(std::shared_ptr<const PathScene> s, const PictureRequest& r)
      : scene(std::move(s)),
        request(r),
        guide(make_guide(*scene, r)),
        environment(scene->environment, r.paths, guide.get()) {
    if (learns(*scene, r)) mirrors.emplace(*scene, environment, grid_of(*scene, r), r.seed);
    camera = make_camera_frame(r.camera, r.width, r.height, scene->bounds);
    pixels.resize(static_cast<std::size_t>(r.width) * static_cast<std::size_t>(r.height));
  }

  glm::vec3 direction_through(const glm::vec2& at) const {
    const glm::vec2 size(request.width, request.height);
    const glm::vec2 ndc = 2.0f * at / size - 1.0f;
    return shared::camera_ray(camera.forward, camera.right * camera.tan_x, camera.up * camera.tan_y,
                              glm::vec2(ndc.x, -ndc.y));
  }

  /// A ray through a point of the picture, in pixels.
  struct PixelRay {
    Ray ray;
    RayDifferential differential;
  };
  PixelRay ray_through(const glm::vec2& at) const {
    // Textures are filtered over as much as rasterisation does: the spacing of its samples.
    const float step = request.footprint * (request.msaa == 16 ? 0.25f : request.msaa == 4 ? 0.5f : 1.0f);
    return {{camera.eye, direction_through(at), camera.near_m, std::numeric_limits<float>::max()},
            {camera.eye, direction_through(at + glm::vec2(step, 0.0f)), direction_through(at + glm::vec2(0.0f, step))}};
  }

  /// Until the pixel has `target` paths. Returns the paths traced.
  std::size_t trace_pixel(std::size_t pixel, std::uint32_t target, const std::stop_token& stop,
                          std::size_t* ray_count) {
    PixelSums& p = pixels[pixel];
    const std::uint32_t first = p.count;
    const auto width = static_cast<std::size_t>(request.width);
    const glm::vec2 corner(static_cast<float>(pixel % width), static_cast<float>(pixel / width));
    PathSampler sampler{mix_seed(request.seed, static_cast<std::uint32_t>(pixel)), 0};
    std::optional<CameraRay> shared_ray;  // all paths through a pixel's centre begin alike
    for (; p.count < target && !stop.stop_requested(); ++p.count) {
      sampler.index = p.count;
      const PixelRay r = ray_through(corner + (request.msaa > 1 ? sampler.pair(0) : glm::vec2(0.5f)));
      PathEstimate e;
      if (request.paths.transport == Transport::direct) {
        e = estimate_direct(*scene, environment, sampler, r.ray, &r.differential);
      } else {
        if (!shared_ray || request.msaa > 1) {
          shared_ray.emplace(*scene, environment, r.ray, &r.differential, 0u);
          *ray_count += shared_ray->rays();
        }
        e = shared_ray->estimate(sampler, request.paths.max_bounces, mirrors ? &*mirrors : nullptr);
      }
      *ray_count += e.rays;
      // A picture never holds NaN or infinity, whatever a table holds.
      const glm::dvec3 value = is_finite(e.radiance) ? glm::dvec3(e.radiance) : glm::dvec3(0.0);
      p.sum += value;
      p.square += value * value;
      p.covered += e.covered ? 1 : 0;
    }
    return p.count - first;
  }

  std::uint32_t least_count() const {
    return std::min_element(pixels.begin(), pixels.end(),
                            [](const auto& a, const auto& b) { return a.count < b.count; })
        ->count;
  }

  /// Until every pixel has `target` paths; false when stopped before.
  bool trace_to(std::uint32_t target, const std::stop_token& stop, const Progress& progress) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pixels.size(), kPixelsATask), [&](const auto& range) {
      std::size_t traced = 0, paths = 0;
      for (std::size_t i = range.begin(); i < range.end(); ++i) paths += trace_pixel(i, target, stop, &traced);
      rays += traced;
      progress.add(paths);
    });
    return !stop.stop_requested();
  }

  void learn() {
    if (guide) guide->learn();
    mirrors->learn(static_cast<std::size_t>(kMirroredLights * static_cast<double>(pixels.size())));
  }

  template <typename Value>
  Image image(int channels, const Value& value) const {
    Image out(request.width, request.height, channels);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const glm::dvec4 v = value(pixels[i]);
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

/// The guide learns after 1, 2, 4, ... paths a pixel, whatever the portions that were asked for.
bool ReferencePicture::add(int count, const std::stop_token& stop, const std::function<void(double)>& progress) {
  Impl& s = *impl_;
  // After an interrupted call the pixels left behind catch up first.
  const std::uint32_t target = s.least_count() + static_cast<std::uint32_t>(std::max(count, 0));
  const Progress report(progress, s.pixels.size() * static_cast<std::size_t>(std::max(count, 1)));
  for (std::uint32_t done = s.least_count(); done < target;) {
    const bool learns = done < kLastLesson && s.mirrors;
    const std::uint32_t next = std::min(target, learns ? std::bit_ceil(done + 1) : target);
    if (!s.trace_to(next, stop, report)) return false;
    if (learns && std::has_single_bit(next)) s.learn();
    done = next;
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

int ReferencePicture::samples() const { return static_cast<int>(impl_->least_count()); }

Image ReferencePicture::mean() const {
  return impl_->image(4, [](const PixelSums& p) {
    const double scale = p.count > 0 ? 1.0 / p.count : 0.0;
    return glm::dvec4(p.sum * scale, p.covered * scale);
  });
}

Image ReferencePicture::variance() const {
  return impl_->image(3, [](const PixelSums& p) { return glm::dvec4(variance_of_mean(p), 0.0); });
}

double ReferencePicture::relative_error(bool whole) const {
  double variance = 0.0, luminance = 0.0;
  std::size_t count = 0;
  for (const PixelSums& p : impl_->pixels) {
    if (p.count < 2) return 0.0;
    if (!whole && p.covered < p.count) continue;
    const glm::dvec3 v = variance_of_mean(p);
    variance += v.x + v.y + v.z;
    luminance += (0.2126 * p.sum.x + 0.7152 * p.sum.y + 0.0722 * p.sum.z) / p.count;
    ++count;
  }
  if (count == 0 || !(luminance > 0.0)) return 0.0;
  const auto n = static_cast<double>(count);
  return std::sqrt(variance / (3.0 * n)) / (luminance / n);
}

}  // namespace maquette
