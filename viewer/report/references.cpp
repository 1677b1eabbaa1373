#include "viewer/report/references.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <stop_token>
#include <thread>

#include "scenes/error.h"
#include "scenes/image_io.h"
#include "scenes/luminance.h"
#include "viewer/interrupt.h"

namespace maquette::report {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kSeeds[2] = {101, 202};  // different from those of the frames that are judged
/// Rays of the path tracer, with shading, on a slow core. Measured: 1 to 2 million on an AMD EPYC.
constexpr double kRaysPerCoreSecond = 0.8e6;
constexpr double kPatience = 1.5;
constexpr int kFirstPaths = 4;  // a pixel and half

Image mean_of(const Image& a, const Image& b) {
  Image mean = a;
  for (std::size_t i = 0; i < mean.data.size(); ++i) mean.data[i] = 0.5f * (a.data[i] + b.data[i]);
  return mean;
}

double own_noise(const Image (&halves)[2]) {
  return 0.5 * compare_images(halves[0], halves[1]).relative_rmse.value_or(0.0);
}

PictureRequest picture_request(const FrameRequest& frame, Scope scope, std::uint32_t seed) {
  PictureRequest request;
  request.camera = frame.camera;
  request.width = frame.width;
  request.height = frame.height;
  request.msaa = frame.msaa;
  request.seed = seed;
  request.paths.transport = scope == Scope::model ? Transport::full : Transport::direct;
  request.paths.env_rotation_rad = frame.env_rotation_rad;
  request.paths.env_scale = frame.env_scale;
  return request;
}

/// Paths a pixel and half that fit the time on an idle machine. Computed from the scene's count of rays and not from
/// measured times, so that two runs with the same budget trace the same paths. A power of two.
int paths_for_time(const ReferencePicture& first, double seconds) {
  const double cores = std::max(1u, std::thread::hardware_concurrency());
  const double rays = seconds * cores * kRaysPerCoreSecond / 2.0;  // of one half
  const double rays_of_a_path = static_cast<double>(first.counts().rays) / first.samples();
  const double paths = std::clamp(rays / std::max(rays_of_a_path, 1.0), 1.0 * kFirstPaths, 65536.0);
  return static_cast<int>(std::bit_floor(static_cast<unsigned>(paths)));
}

/// Doubles the paths until they fill the time or the noise is low enough; ends early when the machine is so busy that
/// this takes far longer.
Judge trace(Studio* studio, const ReferenceOrder& order, const FrameRequest& frame) {
  ReferencePicture halves[2] = {ReferencePicture(studio->path_scene(), picture_request(frame, order.scope, kSeeds[0])),
                                ReferencePicture(studio->path_scene(), picture_request(frame, order.scope, kSeeds[1]))};
  std::stop_source stop;
  const auto watch = [&](double) {
    if (InterruptGuard::asked()) stop.request_stop();
  };
  const Clock::time_point begin = Clock::now();
  Judge judge;
  int wanted = kFirstPaths;
  for (int count = kFirstPaths; !InterruptGuard::asked(); count = halves[0].samples()) {
    for (ReferencePicture& half : halves) half.add(count, stop.get_token(), watch);
    judge.entry.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    judge.entry.samples = halves[0].samples() + halves[1].samples();
    for (int h = 0; h < 2; ++h) judge.halves[h] = halves[h].mean();
    judge.entry.noise = own_noise(judge.halves);
    wanted = std::max(wanted, paths_for_time(halves[0], order.seconds));
    // The next round takes as long as all before.
    if (judge.entry.noise <= order.target_noise || 2 * halves[0].samples() > wanted ||
        2.0 * judge.entry.seconds > kPatience * order.seconds)
      break;
  }
  judge.picture = mean_of(judge.halves[0], judge.halves[1]);
  judge.entry.made_by = "reference, two halves";
  return judge;
}

std::string half_file(const std::string& key, int half) {
  return "references/" + key + (half == 0 ? "-a.exr" : "-b.exr");
}

}  // namespace

std::optional<double> noise_free_error(const Image& picture, const Judge& judge) {
  const std::optional<double> plain = compare_images(picture, judge.picture).relative_rmse;
  if (!plain) return std::nullopt;
  double sum = 0.0, light = 0.0;
  std::size_t count = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (judge.picture.channels > 3 && !(judge.picture.at(x, y, 3) >= 1.0f)) continue;
      double product = 0.0;
      for (int c = 0; c < 3; ++c) {
        const auto a = static_cast<double>(picture.at(x, y, c));
        product += (a - static_cast<double>(judge.halves[0].at(x, y, c))) *
                   (a - static_cast<double>(judge.halves[1].at(x, y, c)));
      }
      if (!std::isfinite(product)) continue;
      sum += product;
      light += luminance(judge.picture, x, y);
      ++count;
    }
  }
  const double pixels = static_cast<double>(std::max<std::size_t>(count, 1));
  const double error = std::sqrt(std::max(sum, 0.0) / (3.0 * pixels)) / (light / pixels);
  return std::max(error, 0.1 * *plain);
}

Judge obtain_reference(Studio* studio, Journal* journal, const std::string& folder, const ReferenceOrder& order) {
  const FrameRequest request = studio->request(order.camera);
  ContentKey key = studio->key();
  mix_request(request, &key);
  key.mix("all light paths").mix(scope_name(order.scope));
  const std::string id = key.text();
  const auto path = [&](int half) { return folder + "/" + half_file(id, half); };
  Judge judge;
  const std::optional<ReferenceEntry> known = journal->find_reference(id);
  if (known && std::filesystem::exists(path(0)) && std::filesystem::exists(path(1))) {
    judge.entry = *known;
    for (int h = 0; h < 2; ++h) judge.halves[h] = load_hdr_image(path(h));
    judge.picture = mean_of(judge.halves[0], judge.halves[1]);
    judge.key = id;
    return judge;
  }
  judge = trace(studio, order, request);
  judge.key = id;
  judge.entry.camera = order.camera.name;
  judge.entry.scope = order.scope;
  judge.entry.file = half_file(id, 0);
  if (InterruptGuard::asked()) return judge;  // unfinished: must not be stored as a reference
  std::filesystem::create_directories(folder + "/references");
  for (int h = 0; h < 2; ++h)
    save_exr(path(h), judge.halves[h],
             {{"maquette.camera", order.camera.name}, {"maquette.scope", scope_name(order.scope)}});
  journal->add_reference(id, judge.entry);
  return judge;
}

std::optional<Judge> obtain_reflection_reference(Studio* studio, const std::string& folder, const SweptCamera& camera,
                                                 const SweptTechnique& raytraced) {
  const FrameRequest request =
      request_of(studio->request(camera), raytraced, raytraced.steps.back(), Scope::reflection);
  const bool whole = studio->renderer().finish_background_work(request);
  if (InterruptGuard::asked()) return std::nullopt;
  if (!whole) throw Error("mode " + request.mode, "its bake is not there", "set its run to auto, or bake it");
  const FrameStats stats = studio->renderer().render(request);
  if (stats.plan.reflections.empty()) return std::nullopt;
  ContentKey key = studio->key();
  mix_request(request, &key);
  Judge judge;
  judge.key = key.text();
  judge.picture = studio->renderer().read_radiance();
  // Panes in front of the sky are included, because only reflections are judged here.
  for (std::size_t i = 3; judge.picture.channels == 4 && i < judge.picture.data.size(); i += 4)
    judge.picture.data[i] = 1.0f;
  for (Image& half : judge.halves) half = judge.picture;
  judge.entry = {camera.name, Scope::reflection,    half_file(judge.key, 0), raytraced.name, request.samples,
                 0.0,         1e-3 * stats.frame_ms};
  std::filesystem::create_directories(folder + "/references");
  save_exr(folder + "/" + judge.entry.file, judge.picture,
           {{"maquette.camera", camera.name}, {"maquette.scope", scope_name(Scope::reflection)}});
  return judge;
}

}  // namespace maquette::report
