#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
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

}  // namespace

struct ReferencePicture::Impl {
  std::shared_ptr<const PathScene> scene;
  PictureRequest request;
  EnvironmentLight environment;
  CameraFrame camera;
  std::vector<PixelSums> pixels;
  std::atomic<std::size_t> rays{0};

  Impl(std::shared_ptr<const PathScene> s, const PictureRequest& r)
      : scene(std::move(s)), request(r), environment(scene->environment, request.paths) {
    camera = make_camera_frame(r.camera, r.width, r.height, scene->bounds);
    pixels.resize(static_cast<std::size_t>(r.width) * static_cast<std::size_t>(r.height));
  }

  glm::vec3 direction_through(const glm::vec2& at) const {
    const glm::vec2 size(request.width, request.height);
    const glm::vec2 ndc = 2.0f * at / size - 1.0f;
    return shared::camera_ray(camera.forward, camera.right * camera.tan_x, camera.up * camera.tan_y,
                              glm::vec2(ndc.x, -ndc.y));
  }

  PathEstimate trace(std::size_t pixel, std::uint32_t index) const {
    const auto width = static_cast<std::size_t>(request.width);
    const PathSampler sampler{mix_seed(request.seed, static_cast<std::uint32_t>(pixel)), index};
    const glm::vec2 corner(static_cast<float>(pixel % width), static_cast<float>(pixel / width));
    const glm::vec2 at = corner + (request.msaa > 1 ? sampler.pair(0) : glm::vec2(0.5f));
    // Textures are filtered over as much as rasterisation does: the spacing of its samples.
    const float step = request.footprint * (request.msaa == 16 ? 0.25f : request.msaa == 4 ? 0.5f : 1.0f);
    const Ray ray{camera.eye, direction_through(at), camera.near_m, std::numeric_limits<float>::max()};
    const RayDifferential differential{camera.eye, direction_through(at + glm::vec2(step, 0.0f)),
                                       direction_through(at + glm::vec2(0.0f, step))};
    return request.paths.transport == Transport::direct
               ? estimate_direct(*scene, environment, sampler, ray, &differential)
               : estimate_full(*scene, environment, sampler, ray, &differential, request.paths.max_bounces);
  }

  std::uint32_t add_path(std::size_t pixel) {
    PixelSums& p = pixels[pixel];
    PathEstimate estimate = trace(pixel, p.count);
    // A picture never holds NaN or infinity, whatever a table holds.
    if (!is_finite(estimate.radiance)) estimate.radiance = glm::vec3(0.0f);
    const glm::dvec3 value(estimate.radiance);
    p.sum += value;
    p.square += value * value;
    ++p.count;
    p.covered += estimate.covered ? 1 : 0;
    return estimate.rays;
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

const PictureRequest& ReferencePicture::request() const { return impl_->request; }

bool ReferencePicture::add(int count, const std::stop_token& stop, const std::function<void(double)>& progress) {
  Impl& s = *impl_;
  std::uint32_t target = 0;
  for (const PixelSums& p : s.pixels) target = std::max(target, p.count);
  // Pixels that an interrupted call left behind catch up.
  if (std::any_of(s.pixels.begin(), s.pixels.end(), [&](const PixelSums& p) { return p.count != target; })) --count;
  target += static_cast<std::uint32_t>(std::max(count, 0));
  std::atomic<std::size_t> done{0};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, s.pixels.size(), kPixelsATask), [&](const auto& range) {
    std::size_t rays = 0;
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      while (s.pixels[i].count < target && !stop.stop_requested()) rays += s.add_path(i);
    s.rays += rays;
    const std::size_t before = done.fetch_add(range.size()), total = s.pixels.size();
    if (progress && (before + range.size()) * 100 / total != before * 100 / total)
      progress(static_cast<double>(before + range.size()) / static_cast<double>(total));
  });
  return !stop.stop_requested();
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

int ReferencePicture::samples() const {
  std::uint32_t least = std::numeric_limits<std::uint32_t>::max();
  for (const PixelSums& p : impl_->pixels) least = std::min(least, p.count);
  return static_cast<int>(least);
}

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
