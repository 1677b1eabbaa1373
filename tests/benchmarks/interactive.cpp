// Waiting times of a user: rotating light, first picture of a file, swaps of material and environment; and how cost
// grows with samples a pixel, pixels and shading samples.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "scenes/image_io.h"
#include "tests/benchmarks/stage.h"
#include "tests/support/local_bandwidth.h"

namespace maquette::bench {

namespace fs = std::filesystem;

namespace {

const Case kDriver{.name = "cockpit/driver", .scene = "builtin:cockpit", .camera = "driver"};

std::string ms_text(const Clock& t) { return number(t.wall_ms) + " ms (CPU " + number(t.cpu_ms) + " ms)"; }

Clock median_of(std::vector<Clock> times) {
  std::vector<double> wall, cpu;
  for (const Clock& t : times) {
    wall.push_back(t.wall_ms);
    cpu.push_back(t.cpu_ms);
  }
  return {test::median(wall), test::median(cpu)};
}

/// Medians of frames of several requests, interleaved, each without reuse of earlier frames, after one frame of each as
/// warm-up.
std::vector<Clock> time_frames(Stage& stage, std::vector<FrameRequest> requests, int repeats) {
  for (FrameRequest& request : requests) request.settings.set("shading.reuse", false);
  std::vector<std::vector<Clock>> times(requests.size());
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t i = 0; i < requests.size(); ++i) {
      // A change of size or mode allocates new targets; only the frame after it is timed.
      stage.renderer().render(requests[i]);
      const Clock begin = now();
      stage.renderer().render(requests[i]);
      times[i].push_back(now() - begin);
    }
  }
  std::vector<Clock> medians;
  for (auto& t : times) medians.push_back(median_of(std::move(t)));
  return medians;
}

/// A light that rotates once in twelve seconds.
constexpr double kRotation_rad_per_s = 6.283185307 / 12.0;

struct RotatingFrames {
  Clock time = {};  ///< median
  double step_rad = 0.0, samples = 0.0, reused = 0.0;
  double error = 0.0, error_without_peaks = 0.0;  ///< of the last one
};

/// Relative RMSE without the pixels that are off by more than half the mean.
double error_without_peaks(const Image& picture, const Reference& reference) {
  Image kept = picture;
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < kept.data.size(); i += 4) {
    if (reference.picture.data[i + 3] < 1.0f) continue;
    sum += static_cast<double>(reference.picture.data[i + 1]);
    count += 1.0;
  }
  const double limit = 0.5 * sum / std::max(count, 1.0);
  for (std::size_t i = 0; i < kept.data.size(); i += 4) {
    double square = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      square += std::pow(static_cast<double>(kept.data[i + c]) - reference.picture.data[i + c], 2.0) / 3.0;
    if (square > limit * limit)
      for (std::size_t c = 0; c < 3; ++c) kept.data[i + c] = reference.picture.data[i + c];
  }
  return error_against(kept, reference);
}

/// Rotates the light in each frame by the angle for the time of the frame before, taken as its processor time over all
/// cores, so that other load on the machine does not make the light jump. The measured frames rotate it by equal steps,
/// and the last of them ends at rotation 0.
RotatingFrames draw_rotating(Stage& stage, FrameRequest r, const Reference& reference) {
  constexpr int kFirst = 24, kSteady = 8, kFrames = 30;
  const double cores = std::max(1u, std::thread::hardware_concurrency());
  std::vector<Clock> times;
  r.env_rotation_rad = -2.0f;
  double step = 0.0;
  for (int f = 0; f < kFirst; ++f) {
    const Clock begin = now();
    stage.renderer().render(r);
    times.push_back(now() - begin);
    step = kRotation_rad_per_s * 1e-3 * times.back().cpu_ms / cores;
    r.env_rotation_rad += static_cast<float>(step);
  }
  step = kRotation_rad_per_s * 1e-3 * median_of({times.end() - kSteady, times.end()}).cpu_ms / cores;
  times.clear();
  RotatingFrames result;
  result.step_rad = step;
  for (int f = 0; f < kFrames; ++f) {
    r.env_rotation_rad = static_cast<float>((f - kFrames + 1) * step);
    const Clock begin = now();
    const FrameStats stats = stage.renderer().render(r);
    times.push_back(now() - begin);
    const auto reused = stats.technique.find("continued_points");
    if (reused != stats.technique.end())
      result.reused = reused->second / std::max<double>(static_cast<double>(stats.shaded_pixels), 1.0);
    result.samples += static_cast<double>(stats.shading_samples) / kFrames;
  }
  const Image picture = stage.renderer().read_radiance();
  result.time = median_of(times);
  result.error = error_against(picture, reference);
  result.error_without_peaks = error_without_peaks(picture, reference);
  return result;
}

/// Uniform pictures with other seeds: what a request converges to where panes and visibility rule out
/// `Stage::reference`. Each seed has its own list of light samples: the error that all samples of one list have in
/// common (1.1 % of a mirrored sun) does not show in the difference of two halves with the same list.
Reference converge_uniform(Stage& stage, FrameRequest r) {
  Reference reference;
  constexpr std::uint32_t kSwapSeeds = 4;
  r.mode = "uniform";
  r.samples = 512;
  for (std::uint32_t h = 0; h < 2; ++h)
    for (std::uint32_t s = 0; s < kSwapSeeds; ++s) {
      r.seed = 77 + h * kSwapSeeds + s;
      stage.renderer().render(r);
      const Image picture = stage.renderer().read_radiance();
      Image& half = reference.halves[h];
      if (s == 0) half = Image(picture.width, picture.height, 4);
      for (std::size_t i = 0; i < picture.data.size(); ++i) half.data[i] += picture.data[i] / kSwapSeeds;
    }
  reference.noise = 0.5 * relative_rmse(reference.halves[0], reference.halves[1]);
  reference.picture = reference.halves[0];
  for (std::size_t i = 0; i < reference.picture.data.size(); ++i)
    reference.picture.data[i] = 0.5f * (reference.halves[0].data[i] + reference.halves[1].data[i]);
  return reference;
}

Figures measure_rotating_light(Stage& stage) {
  Figures figures;
  stage.show(kDriver);
  for (const bool plain : {true, false}) {
    FrameRequest r = stage.request("bandwidth", 0);
    if (!plain) {
      r.settings = {};
      for (const auto& [name, text] : stage.options().settings) r.settings.set_from_text(name, text);
      // As in the window, which traces indirect light's rays while the picture rests.
      stage.renderer().set_interactive(true);
      stage.renderer().finish_background_work(r);
    }
    const Reference reference = plain ? stage.reference() : converge_uniform(stage, r);
    const RotatingFrames t = draw_rotating(stage, r, reference);
    stage.renderer().set_interactive(false);
    const double fps = 1e3 / t.time.wall_ms;
    const std::string what = plain ? "light rotation, visibility none" : "light rotation, default settings";
    figures.push_back(judged("cockpit 640 x 360, " + what, ">= 15 frames/s",
                             number(fps) + " frames/s: " + ms_text(t.time) + ", " + number(57.2957795 * t.step_rad) +
                                 " degrees and " + number(1e-6 * t.samples) + " million samples a frame, " +
                                 number(100.0 * t.reused) + " % of the points reuse earlier frames",
                             fps >= 15.0));
    figures.push_back(judged("error of the 30th frame, " + what, "<= 5 %",
                             number(100.0 * t.error) + " % (" + number(100.0 * t.error_without_peaks) +
                                 " % without pixels off by half the mean; noise of the reference " +
                                 number(100.0 * reference.noise) + " %)",
                             t.error <= 0.05));
  }
  return figures;
}

Clock run_program(const std::string& command, bool* worked) {
  rusage before{}, after{};
  getrusage(RUSAGE_CHILDREN, &before);
  const Clock begin = now();
  *worked = std::system(command.c_str()) == 0;
  Clock t = now() - begin;
  getrusage(RUSAGE_CHILDREN, &after);
  const auto ms = [](const timeval& v) {
    return static_cast<double>(v.tv_sec) * 1e3 + static_cast<double>(v.tv_usec) * 1e-3;
  };
  t.cpu_ms = ms(after.ru_utime) + ms(after.ru_stime) - ms(before.ru_utime) - ms(before.ru_stime);
  return t;
}

Figures measure_first_frame(Stage& stage) {
  const Options& o = stage.options();
  const std::string name = "Ferrari, process start to first frame at 640 x 360", target = "<= 1.5 s";
  if (o.data.empty()) return {absent(name, target, "needs --data")};
  if (!fs::exists(o.program)) return {absent(name, target, o.program + " is not there; give --program")};
  const std::string cache = o.scratch + "/first-frame-cache";
  const std::string command = "MAQUETTE_CACHE='" + cache + "' '" + o.program + "' render '" + o.data +
                              "/scenes/ferrari458.glb' --size 640x360 -o '" + o.scratch +
                              "/first.png' > /dev/null 2>&1";
  fs::remove_all(cache);
  bool worked = false;
  const Clock cold = run_program(command, &worked);
  if (!worked) return {absent(name, target, "the program failed: " + command)};
  std::vector<Clock> warm;
  for (int i = 0; i < o.repeats; ++i) warm.push_back(run_program(command, &worked));
  const Clock t = median_of(warm);
  return {judged(name, target, ms_text(t), t.wall_ms <= 1500.0),
          shown(name + ", derived tables not cached", ms_text(cold))};
}

/// A software device compiles a program anew for each state that it finds in its texture slots, unless these always
/// hold the same (TextureSlots::settle). Its cache on disk hides that: MESA_SHADER_CACHE_DISABLE=true.
Figures measure_compiled_once(Stage& stage) {
  stage.show({.name = "compiled once", .scene = "builtin:sphere", .width = 64, .height = 48});
  const FrameRequest request = stage.request("bandwidth", 4);
  const auto timed = [&] {
    const Clock begin = now();
    stage.renderer().render(request);
    return now() - begin;
  };
  const Clock first = timed();
  stage.renderer().render(request, true);
  stage.renderer().render(request, true);  // other programs: what was measured
  stage.renderer().render(stage.request("uniform", 4));
  const double ratio = timed().cpu_ms / first.cpu_ms;
  return {judged("frame after other modes' over the first, which compiles", "CPU <= 0.3 x", number(ratio) + " x",
                 ratio <= 0.3)};
}

Figures measure_material_swap(Stage& stage) {
  Figures figures;
  stage.show({.name = "swap", .scene = "builtin:cockpit", .camera = "door"});
  const std::vector<Material>& materials = stage.renderer().scene().materials;
  const auto paint = std::find_if(materials.begin(), materials.end(),
                                  [](const Material& m) { return m.measured.find("paint") != std::string::npos; });
  if (paint == materials.end()) return {absent("material swap", "", "the cockpit has no paint")};
  const std::string name = paint->name;
  const FrameRequest r = stage.request("bandwidth", 0);
  const auto swap = [&](const std::string& source) {
    const Clock begin = now();
    stage.renderer().set_material(name, source);
    stage.renderer().render(r);
    return now() - begin;
  };
  stage.renderer().render(r);
  swap("builtin:paint-silver-metallic");
  swap("builtin:paint-red-metallic");
  std::vector<Clock> times;
  for (int i = 0; i < 2 * stage.options().repeats; ++i)
    times.push_back(swap(i % 2 ? "builtin:paint-red-metallic" : "builtin:paint-silver-metallic"));
  const Clock again = median_of(times);
  figures.push_back(
      judged("material swap, once read, frame included", "<= 0.1 s", ms_text(again), again.wall_ms <= 100.0));
  const Image swapped = stage.renderer().read_radiance();
  FrameRequest anew = r;
  anew.settings.set("shading.reuse", false);
  stage.renderer().render(anew);
  const Image from_nothing = stage.renderer().read_radiance();
  const Reference reference = converge_uniform(stage, r);
  figures.push_back(
      shown("error of that frame", number(100.0 * error_against(swapped, reference)) + " % (from nothing " +
                                       number(100.0 * error_against(from_nothing, reference)) +
                                       " %; noise of the reference " + number(100.0 * reference.noise) + " %)"));
  times.clear();
  for (int i = 0; i <= 2 * stage.options().repeats; ++i) {
    for (int f = 0; f < 8; ++f) stage.renderer().render(r, true);
    const Clock begin = now();
    stage.renderer().set_material(name, i % 2 ? "builtin:paint-red-metallic" : "builtin:paint-silver-metallic");
    stage.renderer().render(r, true);
    if (i > 0) times.push_back(now() - begin);
  }
  figures.push_back(shown("material swap amid a resting picture", ms_text(median_of(times))));
  if (stage.options().data.empty()) {
    figures.push_back(absent("material swap from a 33 MB file", "<= 1 s", "needs --data"));
    return figures;
  }
  const auto files = expand_tables(stage.options(), {"blue-metallic-paint2", "silver-metallic-paint"});
  const std::string cache = stage.options().scratch + "/swap-cache";
  fs::remove_all(cache);
  const char* old = std::getenv("MAQUETTE_CACHE");
  const std::string kept = old ? old : "";
  setenv("MAQUETTE_CACHE", cache.c_str(), 1);
  const Clock fresh = swap(files[0]);
  old ? setenv("MAQUETTE_CACHE", kept.c_str(), 1) : unsetenv("MAQUETTE_CACHE");
  figures.push_back(
      judged("material swap from a 33 MB file, never seen before", "<= 1 s", ms_text(fresh), fresh.wall_ms <= 1000.0));
  return figures;
}

Figures measure_environment_swap(Stage& stage) {
  const std::string path = stage.options().scratch + "/sky-4096.exr", target = "<= 2 s";
  if (!fs::exists(path)) {
    const Environment sky = load_environment("builtin:clear-sky");
    Image image(4096, 2048, 3);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const glm::dvec3 v = evaluate_environment(sky, direction_from_latlong(x + 0.5, y + 0.5, 4096, 2048));
        for (int c = 0; c < 3; ++c)
          image.at(x, y, c) = static_cast<float>(v[c] * (1.0 + 0.2 * std::sin(0.37 * x) * std::sin(0.53 * y)));
      }
    }
    save_exr(path, image);
  }
  stage.show({.name = "swap", .scene = "builtin:cockpit", .camera = "door"});
  const FrameRequest r = stage.request("bandwidth", 0);
  stage.renderer().render(r);
  const auto swap = [&] {
    const Clock begin = now();
    stage.renderer().set_environment(std::make_shared<Environment>(load_environment(path)));
    stage.renderer().render(r);
    return now() - begin;
  };
  const char* old = std::getenv("MAQUETTE_CACHE");
  const std::string kept = old ? old : "";
  const std::string cache = stage.options().scratch + "/environment-cache";
  fs::remove_all(cache);
  setenv("MAQUETTE_CACHE", cache.c_str(), 1);
  const Clock cold = swap();
  const Clock warm = swap();
  old ? setenv("MAQUETTE_CACHE", kept.c_str(), 1) : unsetenv("MAQUETTE_CACHE");
  Case back{.name = "back", .scene = "builtin:sphere", .environment = "builtin:studio"};
  stage.show(back);
  return {judged("4096 x 2048 environment ready, never seen before", target, ms_text(cold), cold.wall_ms <= 2000.0),
          shown("4096 x 2048 environment ready, seen before", ms_text(warm))};
}

/// Least squares of time = a + b * samples; the share of the variance that it explains.
struct LineFit {
  double intercept = 0.0, slope = 0.0, r2 = 0.0;
};
LineFit fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const double n = static_cast<double>(x.size());
  double sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sx += x[i];
    sy += y[i];
    sxx += x[i] * x[i];
    sxy += x[i] * y[i];
    syy += y[i] * y[i];
  }
  const double cxx = sxx - sx * sx / n, cxy = sxy - sx * sy / n, cyy = syy - sy * sy / n;
  LineFit f;
  f.slope = cxy / cxx;
  f.intercept = (sy - f.slope * sx) / n;
  f.r2 = cxy * cxy / (cxx * cyy);
  return f;
}

}  // namespace

Figures measure_interactive(Stage& stage) {
  struct Part {
    const char* name;
    Figures (*measure)(Stage&);
  };
  Figures figures;
  for (const Part& part : {Part{"light rotation", measure_rotating_light}, Part{"first frame", measure_first_frame},
                           Part{"compiled once", measure_compiled_once}, Part{"material swap", measure_material_swap},
                           Part{"environment swap", measure_environment_swap}}) {
    if (!stage.options().wants(part.name)) continue;
    for (Figure& f : part.measure(stage)) figures.push_back(std::move(f));
  }
  return figures;
}

Figures measure_multisampling(Stage& stage) {
  stage.show(kDriver);
  std::vector<FrameRequest> requests;
  for (const char* mode : {"bandwidth", "uniform"}) {
    for (const int msaa : {1, 4}) {
      requests.push_back(stage.request(mode, 64));
      requests.back().msaa = msaa;
    }
  }
  const std::vector<Clock> t = time_frames(stage, requests, 2 * stage.options().repeats);
  const double wall = t[1].wall_ms / t[0].wall_ms, cpu = t[1].cpu_ms / t[0].cpu_ms;
  return {judged("4 samples a pixel over 1, bandwidth, cockpit", "<= 2",
                 number(wall) + " x (CPU " + number(cpu) + " x)", wall <= 2.0),
          shown("4 samples a pixel over 1, every one shaded (uniform)",
                number(t[3].wall_ms / t[2].wall_ms) + " x (CPU " + number(t[3].cpu_ms / t[2].cpu_ms) + " x)")};
}

Figures measure_scaling(Stage& stage) {
  Figures figures;
  stage.show(kDriver);
  std::vector<FrameRequest> sizes{stage.request("bandwidth", 0), stage.request("bandwidth", 0)};
  sizes[1].width *= 2;
  sizes[1].height *= 2;
  const std::vector<Clock> t = time_frames(stage, sizes, 2 * stage.options().repeats);
  const double ratio = t[1].wall_ms / t[0].wall_ms;
  figures.push_back(judged("1280 x 720 over 640 x 360, default frame, cockpit", "<= 3",
                           number(ratio) + " x (CPU " + number(t[1].cpu_ms / t[0].cpu_ms) + " x)", ratio <= 3.0));
  std::vector<FrameRequest> counts;
  for (const int samples : {8, 16, 32, 64, 96, 128, 192, 256}) counts.push_back(stage.request("bandwidth", samples));
  const std::vector<Clock> times = time_frames(stage, counts, stage.options().repeats);
  std::vector<double> samples, cpu, wall;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    samples.push_back(static_cast<double>(stage.renderer().render(counts[i]).shading_samples) * 1e-6);
    cpu.push_back(times[i].cpu_ms);
    wall.push_back(times[i].wall_ms);
  }
  const LineFit f = fit_line(samples, wall), fc = fit_line(samples, cpu);
  figures.push_back(judged("time against shading samples, straight line", "linear (R2 >= 0.98)",
                           "R2 " + number(f.r2) + ", " + number(f.intercept) + " ms + " + number(f.slope) +
                               " ms per million (CPU: R2 " + number(fc.r2) + ", " + number(fc.intercept) + " + " +
                               number(fc.slope) + ")",
                           f.r2 >= 0.98));
  return figures;
}

}  // namespace maquette::bench
