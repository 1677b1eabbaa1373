#include "viewer/error_meter.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <thread>
#include <utility>

#include "scenes/luminance.h"

namespace maquette {

namespace {

/// Grid columns: an answer within a second or two first, then where the error is, then detail for the wiper.
constexpr int kColumns[] = {72, 200, 480};
/// Paths a pixel and half at which the next finer grid begins; the last one goes on to kMostPaths.
constexpr int kPathsOfLevel[] = {16, 32, 4096};
constexpr double kNormal95 = 1.96;
constexpr std::uint32_t kSeeds[2] = {7001, 7002};

/// The window's own drawing needs the rest.
int few_cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / 4); }

bool same(const PathOptions& a, const PathOptions& b) {
  return a.transport == b.transport && a.env_rotation_rad == b.env_rotation_rad && a.env_scale == b.env_scale &&
         a.max_bounces == b.max_bounces;
}

}  // namespace

bool ErrorMeter::View::operator==(const View& other) const {
  return camera == other.camera && width == other.width && height == other.height && same(paths, other.paths) &&
         scene_revision == other.scene_revision;
}

PixelGrid make_pixel_grid(int width, int height, int columns) {
  PixelGrid grid;
  grid.factor = std::max(1, width / std::max(columns, 1)) | 1;
  while (grid.factor > 1 && height / grid.factor < 8) grid.factor -= 2;
  // An odd rest would put the grid between the pixels.
  const auto fit = [&](int side) {
    const int count = side / grid.factor;
    return count > 1 && (side - count * grid.factor) % 2 != 0 ? count - 1 : count;
  };
  grid.width = std::max(fit(width), 1);
  grid.height = std::max(fit(height), 1);
  grid.x = (width - grid.width * grid.factor) / 2;
  grid.y = (height - grid.height * grid.factor) / 2;
  return grid;
}

CameraView grid_camera(const CameraView& camera, const PixelGrid& grid, int height) {
  CameraView result = camera;
  const float share = static_cast<float>(grid.height * grid.factor) / static_cast<float>(height);
  result.fov_y_rad = 2.0f * std::atan(std::tan(0.5f * camera.fov_y_rad) * share);
  result.height_m = camera.height_m * share;
  return result;
}

std::optional<MeteredError> meter_error(const Image& picture, const GridReference& reference) {
  const PixelGrid& grid = reference.grid;
  MeteredError result;
  result.map = Image(grid.width, grid.height, 1, -1.0f);
  // Noise of the paths of a tile is alike (render/reference/path_sharing.h): tiles are what is independent.
  struct Tile {
    double sum = 0.0, pixels = 0.0;
  };
  const int tiles_across = (grid.width + kTileWidth - 1) / kTileWidth;
  std::vector<Tile> tiles(static_cast<std::size_t>(tiles_across * ((grid.height + kTileHeight - 1) / kTileHeight)));
  double light = 0.0;
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      const int x = grid.pixel_x(column), y = grid.pixel_y(row);
      const bool surface = picture.at(x, y, 3) >= 1.0f && reference.halves[0].at(column, row, 3) >= 1.0f;
      double product = 0.0;
      for (int c = 0; c < 3; ++c) {
        const auto shown = static_cast<double>(picture.at(x, y, c));
        product += (shown - static_cast<double>(reference.halves[0].at(column, row, c))) *
                   (shown - static_cast<double>(reference.halves[1].at(column, row, c))) / 3.0;
      }
      if (!surface || !std::isfinite(product)) continue;
      Tile& tile = tiles[static_cast<std::size_t>(row / kTileHeight * tiles_across + column / kTileWidth)];
      tile.sum += product;
      tile.pixels += 1.0;
      light += 0.5 * (luminance(reference.halves[0], column, row) + luminance(reference.halves[1], column, row));
      result.map.at(column, row) = static_cast<float>(std::sqrt(std::max(product, 0.0)));
      ++result.pixels;
    }
  }
  if (result.pixels < 2 || !(light > 0.0)) return std::nullopt;
  double sum = 0.0, squares = 0.0, seen = 0.0;
  for (const Tile& tile : tiles) sum += tile.sum;
  const double n = result.pixels, mean = sum / n, mean_light = light / n;
  for (const Tile& tile : tiles) {  // ratio estimator: tiles hold different numbers of pixels
    squares += (tile.sum - mean * tile.pixels) * (tile.sum - mean * tile.pixels);
    seen += tile.pixels > 0.0 ? 1.0 : 0.0;
  }
  if (seen < 2.0) return std::nullopt;
  const double spread = std::sqrt(squares * seen / (seen - 1.0)) / n;
  const auto root = [&](double square) { return std::sqrt(std::max(square, 0.0)) / mean_light; };
  result.error = root(mean);
  result.low = root(mean - kNormal95 * spread);
  result.high = root(mean + kNormal95 * spread);
  for (float& value : result.map.data)
    if (value >= 0.0f) value /= static_cast<float>(mean_light);
  return result;
}

double reference_noise(const GridReference& reference, double paths) {
  const Image &a = reference.halves[0], &b = reference.halves[1];
  double squares = 0.0, light = 0.0, count = 0.0;
  for (int row = 0; row < a.height; ++row)
    for (int column = 0; column < a.width; ++column) {
      if (!(a.at(column, row, 3) >= 1.0f)) continue;
      for (int c = 0; c < 3; ++c) {
        const double difference = static_cast<double>(a.at(column, row, c)) - static_cast<double>(b.at(column, row, c));
        squares += difference * difference / 3.0;
      }
      light += 0.5 * (luminance(a, column, row) + luminance(b, column, row));
      count += 1.0;
    }
  if (!(light > 0.0) || !(paths > 0.0)) return 0.0;
  // The difference of two means of half the paths each has four times the variance of the mean of all.
  const double of_one = 0.25 * squares / count * reference.paths;
  return std::sqrt(of_one / paths) / (light / count);
}

double reference_paths(const GridReference& reference, double seconds, int width, int height) {
  if (!(reference.seconds > 0.0)) return 0.0;
  const double traced = static_cast<double>(reference.paths) * reference.grid.width * reference.grid.height;
  const double cores = static_cast<double>(std::max(1u, std::thread::hardware_concurrency())) / few_cores();
  return cores * traced / reference.seconds * seconds / (static_cast<double>(width) * height);
}

bool ErrorMeter::watch(const View& view, const SceneMaker& make_scene) {
  if (watched_ && *watched_ == view) return false;
  watched_ = view;
  newest_.reset();
  problem_.clear();
  worker_.submit({view, make_scene});
  return true;
}

void ErrorMeter::cancel() {
  if (!watched_) return;
  watched_.reset();
  newest_.reset();
  ++version_;
  worker_.cancel();
}

std::shared_ptr<const GridReference> ErrorMeter::newest(std::uint64_t* version) {
  try {
    if (std::optional<GridReference> reference = worker_.take()) {
      newest_ = std::make_shared<const GridReference>(std::move(*reference));
      ++version_;
    }
  } catch (const std::exception& error) {
    problem_ = error.what();
  }
  *version = version_;
  return newest_;
}

void ErrorMeter::trace(const Job& job, const BackgroundTask<GridReference>& task) {
  const View& view = job.view;
  if (!scene_ || scene_revision_ != view.scene_revision) {
    scene_.reset();
    scene_ = job.make_scene();
    scene_revision_ = view.scene_revision;
  }
  tbb::task_arena few(few_cores());
  for (std::size_t level = 0; level < std::size(kColumns) && !task.cancel; ++level) {
    const PixelGrid grid = make_pixel_grid(view.width, view.height, kColumns[level]);
    PictureRequest request;
    request.camera = grid_camera(view.camera, grid, view.height);
    request.width = grid.width;
    request.height = grid.height;
    request.footprint = 1.0f / static_cast<float>(grid.factor);
    request.paths = view.paths;
    request.seed = kSeeds[0];
    ReferencePicture first(scene_, request);
    request.seed = kSeeds[1];
    ReferencePicture second(scene_, request);
    const auto begin = std::chrono::steady_clock::now();
    for (int count = 1; first.samples() < kPathsOfLevel[level] && !task.cancel; count = first.samples()) {
      bool whole = false;
      few.execute([&] { whole = first.add(count, task.stop) && second.add(count, task.stop); });
      if (!whole) return;
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      task.publish({grid, {first.mean(), second.mean()}, first.samples() + second.samples(), seconds});
    }
    if (grid.factor == 1) return;
  }
}

}  // namespace maquette
