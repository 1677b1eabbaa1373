#include "viewer/report/measure.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "viewer/stats.h"

namespace maquette::report {

namespace {

/// An error below this many times the reference's noise is not reliable.
constexpr double kTrusted = 1.5;
constexpr int kMoreFrames = 8;
constexpr double kMoreTime_ms = 300.0;

double process_cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

}  // namespace

Measurement measure_frames(Renderer* renderer, const FrameRequest& request, const FrameRequest& warm, int repeats) {
  Measurement measurement;
  FrameRequest one = request;
  renderer->render(warm);
  for (int i = 0; i < repeats; ++i) {
    one.seed = request.seed + static_cast<std::uint32_t>(i);
    const double begin = process_cpu_ms();
    measurement.stats = renderer->render(one);
    measurement.cpu_ms.push_back(process_cpu_ms() - begin);
    measurement.wall_ms.push_back(measurement.stats.frame_ms);
    measurement.pictures.push_back(renderer->read_radiance());
  }
  // Short frames vary most: more of them are timed, within a time limit.
  double spent_ms = 0.0;
  for (int i = 0; i < kMoreFrames && spent_ms + measurement.wall_ms.back() < kMoreTime_ms; ++i) {
    const double begin = process_cpu_ms();
    measurement.wall_ms.push_back(renderer->render(request).frame_ms);
    measurement.cpu_ms.push_back(process_cpu_ms() - begin);
    spent_ms += measurement.wall_ms.back();
  }
  return measurement;
}

Point judge_measurement(const Measurement& measurement, const Judge& judge, Image* flip_map) {
  Point point;
  point.repeats = static_cast<int>(measurement.pictures.size());
  point.time_ms = spread_of(measurement.wall_ms);
  point.cpu_ms = median(measurement.cpu_ms);
  for (const auto& [name, bytes] : measurement.stats.gpu_bytes) point.gpu_bytes += bytes;
  point.shading_samples = measurement.stats.shading_samples;
  const ErrorReport report = measure_error(measurement.pictures.front(), judge.picture);
  point.figures = report.figures;
  if (flip_map != nullptr) *flip_map = report.flip_map;
  std::vector<double> raw, errors;
  for (const Image& picture : measurement.pictures) {
    const std::optional<double> plain = compare_images(picture, judge.picture).relative_rmse;
    const std::optional<double> error = noise_free_error(picture, judge);
    if (!plain || !error) continue;
    raw.push_back(*plain);
    errors.push_back(*error);
  }
  if (errors.empty()) return point;
  point.relative_rmse = spread_of(errors);
  point.below_noise = median(raw) < kTrusted * judge.entry.noise;
  return point;
}

}  // namespace maquette::report
