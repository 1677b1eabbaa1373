#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <future>

#include "render/gl/context.h"
#include "render/metrics/metrics.h"
#include "render/picture/tonemap.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "scenes/luminance.h"
#include "scenes/percent.h"
#include "viewer/bake_lines.h"
#include "viewer/btf_preparation.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/interrupt.h"
#include "viewer/outputs.h"
#include "viewer/print.h"
#include "viewer/render_look.h"
#include "viewer/render_sheet.h"
#include "viewer/session.h"
#include "viewer/stats.h"
#include "viewer/timed_frames.h"

namespace maquette {

namespace {

constexpr int kWarmUpFrames = 2;
/// The last times of a long accumulation are enough for a median.
constexpr std::size_t kKeptFrames = 1000;
/// Without --time, --target-error gives up after this long.
constexpr double kPatience_s = 600.0;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::optional<Image> load_reference(const SceneOptions& options) {
  if (options.reference.empty()) return std::nullopt;
  Image reference = load_picture(options.reference);
  if (reference.width != options.width || reference.height != options.height)
    throw Error("--reference " + options.reference,
                "it has " + std::to_string(reference.width) + "x" + std::to_string(reference.height) +
                    " pixels, the picture " + std::to_string(options.width) + "x" + std::to_string(options.height),
                "give both the same size");
  return reference;
}

/// Relative RMSE of a mean of n frames, estimated with the mean of its first n / 2: the two halves are independent, so
/// the difference between the mean of all and that of a half has the variance of the mean of all. Errors that all
/// frames have in common (interpolation) are not included.
double estimate_error(const Image& all, const Image& half) {
  double sum = 0.0, light = 0.0;
  std::size_t count = 0;
  for (int y = 0; y < all.height; ++y) {
    for (int x = 0; x < all.width; ++x) {
      if (all.channels > 3 && all.at(x, y, 3) < 1.0f) continue;
      for (int c = 0; c < 3; ++c) {
        const double difference = static_cast<double>(all.at(x, y, c)) - static_cast<double>(half.at(x, y, c));
        sum += difference * difference;
      }
      light += luminance(all, x, y);
      ++count;
    }
  }
  if (count == 0 || light <= 0.0) return 0.0;
  const auto pixels = static_cast<double>(count);
  return std::sqrt(sum / (3.0 * pixels)) / (light / pixels);
}

/// One frame, or with --frames the measured ones after warm-up. By default each is drawn without results of earlier
/// frames, so that its time is that of a new picture.
void render_frames(Renderer* renderer, FrameRequest request, const SceneOptions& options, RenderReport* report) {
  if (!request.settings.changed().contains("shading.reuse")) request.settings.set("shading.reuse", false);
  request.single = options.frames == 0;
  if (options.frames > 0)
    for (int i = 0; i < kWarmUpFrames; ++i) renderer->render(request);
  const Clock::time_point start = Clock::now();
  for (int i = 0; i < std::max(1, options.frames); ++i) report->frames.push_back(renderer->render(request));
  report->total_s = seconds_since(start);
}

bool traces_picture(const FrameRequest& request) {
  return builtin_registry().find_mode(request.mode).can.traces_picture;
}

/// Tells on standard error how far an accumulation has come.
class AccumulationProgress {
 public:
  explicit AccumulationProgress(const SceneOptions& options) : options_(options) {}
  void update(double seconds, double limit_s, const std::optional<double>& error) {
    constexpr double kFirst_s = 2.0, kLines = 10.0;
    const double interval_s = options_.time_s ? std::max(kFirst_s, limit_s / kLines) : 2.0 * kFirst_s;
    if (seconds < last_s_ + interval_s || seconds > limit_s - 0.5 * interval_s) return;
    last_s_ = seconds;
    std::string text = options_.output.empty() || options_.output == "-" ? "render" : options_.output;
    char part[96];
    std::snprintf(part, sizeof part, options_.time_s ? ": %.0f of %.3g s" : ": %.0f s", seconds, limit_s);
    text += part;
    if (error) {
      std::snprintf(part, sizeof part, ", noise about %.2g %%", 100.0 * *error);
      text += part;
      if (options_.target_error) text += " of " + percent_text(*options_.target_error);
    }
    print_line(stderr, "%s; Ctrl-C keeps the picture so far\n", text.c_str());
  }

 private:
  const SceneOptions& options_;
  double last_s_ = 0.0;
};

/// How an accumulation ended.
enum class Ending { as_asked, out_of_time, interrupted };

/// Averages frames until --time, --target-error or Ctrl-C.
class Accumulation {
 public:
  Accumulation(Renderer* renderer, const SceneOptions& options, const std::optional<Image>& reference,
               RenderReport* report)
      : renderer_(*renderer), options_(options), reference_(reference), report_(*report) {}

  Ending run(FrameRequest request, Clock::time_point preparation) {
    slices_ = traces_picture(request);
    prepare(request);
    report_.preparation_s = seconds_since(preparation);
    const double limit_s = options_.time_s.value_or(kPatience_s);
    const InterruptGuard guard;
    AccumulationProgress progress(options_);
    const Clock::time_point start = Clock::now();
    TimedFrames frames(limit_s, [start] { return seconds_since(start); });
    for (bool first = true;; first = false) {
      if (slices_) request.deadline = start + duration_of(std::min(limit_s, frames.elapsed_s() + kSlice_s));
      if (report_.frames.size() == kKeptFrames) report_.frames.erase(report_.frames.begin());
      report_.frames.push_back(renderer_.render(request, !first));
      frames.end_frame();
      report_.total_s = frames.elapsed_s();
      // Slices end by themselves.
      const bool out_of_time = slices_ ? report_.total_s >= limit_s : frames.over();
      if (reached(out_of_time)) return Ending::as_asked;
      if (InterruptGuard::asked()) return Ending::interrupted;
      if (out_of_time) return options_.target_error ? Ending::out_of_time : Ending::as_asked;
      progress.update(report_.total_s, limit_s, report_.estimated_error);
    }
  }

 private:
  /// Compiles shaders and builds what rays are traced through, so that the time is that of frames alone: two small
  /// frames, the second of which is averaged with the first, and a whole one.
  void prepare(FrameRequest request) {
    constexpr int kShare = 16;
    const FrameRequest whole = request;
    request.width = std::max(1, request.width / kShare);
    request.height = std::max(1, request.height / kShare);
    if (slices_) request.samples = 1;
    renderer_.render(request);
    renderer_.render(request, true);
    if (!slices_) renderer_.render(whole);
  }

  /// A mode that traces whole pictures stops after so long for progress and Ctrl-C.
  static constexpr double kSlice_s = 0.5;
  static Clock::duration duration_of(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }

  /// Is the error as low as --target-error asks? Estimates it from the frames where there is no reference.
  bool reached(bool out_of_time) {
    const std::optional<double>& target = options_.target_error;
    const FrameStats& last = report_.frames.back();
    const int count = last.accumulated_frames;
    if (target && reference_) {
      // Reading the picture back is slow: it is checked whenever the number of frames has grown by about a tenth.
      if (count < next_check_ && !out_of_time) return false;
      next_check_ = count + std::max(1, count / 10);
      return compare_images(renderer_.read_radiance(), *reference_).relative_rmse.value_or(INFINITY) <= *target;
    }
    if (last.estimated_error) {
      report_.estimated_error = last.estimated_error;
    } else if (count == next_check_ && !slices_) {
      Image all = renderer_.read_radiance();
      if (half_.width > 0) report_.estimated_error = estimate_error(all, half_);
      half_ = std::move(all);
      next_check_ = 2 * count;
    }
    return target && report_.estimated_error && *report_.estimated_error <= *target;
  }

  Renderer& renderer_;
  const SceneOptions& options_;
  const std::optional<Image>& reference_;
  RenderReport& report_;
  bool slices_ = false;
  int next_check_ = 1;
  Image half_;
};

std::string duration_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", seconds);
  return text;
}

std::string time_text(const RenderReport& report, const FrameRequest& request, bool accumulates) {
  const FrameStats& last = report.frames.back();
  char text[64];
  if (accumulates && traces_picture(request))
    std::snprintf(text, sizeof text, "%.3g paths a pixel in %.1f s",
                  static_cast<double>(last.shading_samples) / (static_cast<double>(request.width) * request.height),
                  report.total_s);
  else if (accumulates)
    std::snprintf(text, sizeof text, "%d frames in %.1f s", last.accumulated_frames, report.total_s);
  else
    std::snprintf(text, sizeof text, "%.1f ms a frame", last.frame_ms);
  std::string result = text;
  if (accumulates) result += ", after " + duration_text(report.preparation_s) + " for shaders and bakes";
  return result;
}

/// The part about the error in the line that is printed for a picture.
std::string error_text(const RenderReport& report, const SceneOptions& options, Ending ending) {
  char text[96] = "";
  if (report.error && report.error->relative_rmse)
    std::snprintf(text, sizeof text, ", relative RMSE %.3g %%", 100.0 * *report.error->relative_rmse);
  std::string result = text;
  if (options.target_error && ending != Ending::as_asked) result += ", --target-error not reached";
  return result;
}

/// The picture lacks light that the scene has, because of the mode that was asked for.
void warn_of_light_left_out(const FramePlan& plan) {
  for (const LeftOut& left_out : plan.left_out)
    if (left_out.what == "lights" && left_out.decided_by == "mode")
      print_line(stderr, "warning: lamps and what glows light nothing: %s\n", left_out.why.c_str());
}

/// The error that is estimated from frames is their noise: what all of them miss alike is not in it.
void warn_of_blurred_shadows(const FramePlan& plan) {
  const bool blurred = std::ranges::any_of(plan.layers, [](const ShadingPlan& shading) {
    return shading.visibility == "baked" && !shading.shadow_rays;
  });
  if (blurred)
    print_line(stderr,
               "warning: with shading.visibility=baked shadows stay blurred, which no noise that is said counts; rays "
               "correct them (auto)\n");
}

std::map<std::string, std::string> provenance(const SceneOptions& options, const FrameRequest& request) {
  std::map<std::string, std::string> attributes = {
      {"maquette.scene", options.scene},
      {"maquette.environment", options.environment},
      {"maquette.mode", request.mode},
      {"maquette.seed", std::to_string(request.seed)},
  };
  for (const PartMode& part : request.part_modes) attributes["maquette.mode-of." + part.node] = part.mode;
  for (const auto& [name, value] : request.settings.changed()) attributes["maquette." + name] = to_text(value);
  return attributes;
}

/// Metadata of an EXR picture.
ImageLayers layers_of(const Renderer& renderer, const SceneOptions& options) {
  ImageLayers layers;
  if (auto variance = renderer.read_variance(); variance && options.debug_view.empty())
    layers.emplace("variance", std::move(*variance));
  return layers;
}

void write_picture(const Renderer& renderer, const Image& radiance, float exposure_ev, const SceneOptions& options,
                   const FrameRequest& request) {
  const bool debug = !options.debug_view.empty();
  const Image view = debug ? renderer.read_debug_view(options.debug_view) : Image();
  if (picture_format(options.output) == PictureFormat::exr)
    save_exr(options.output, debug ? view : radiance, provenance(options, request), layers_of(renderer, options));
  else
    save_png(options.output, debug ? debug_view_picture(view, options.debug_view)
                                   : renderer.read_display(exposure_ev, options.tonemap));
}

}  // namespace

int run_render(const CommandLine& line) {
  const SceneOptions& options = line.options;
  if (line.sheet) return render_sheet(line);
  if (!options.review.empty()) return render_look(line);
  check_picture_outputs(options, input_files(options));
  const std::optional<Image> reference = load_reference(options);
  // The scene and the environment are read while the driver starts.
  auto scene_job = std::async(std::launch::async, [&] { return load_session_scene(options); });
  auto environment_job = std::async(
      std::launch::async, [&] { return std::make_shared<const Environment>(load_environment(options.environment)); });
  const GlContext context = GlContext::create_headless();
  const DeviceInfo device = query_device();
  const std::shared_ptr<Scene> scene = scene_job.get();
  const std::shared_ptr<const Environment> environment = environment_job.get();
  print_warnings("", scene->warnings);
  print_warnings(environment->name, environment->warnings);
  const std::string units = units_warning(*scene, *environment, options.env_scale, "--env-scale");
  if (!units.empty()) print_line(stderr, "warning: %s: %s\n", environment->name.c_str(), units.c_str());
  const bool own_materials = options.materials.empty() && !scene->name.starts_with("builtin:");
  const std::string gloss = own_materials ? gloss_warning(*scene, "give measured ones by --material") : "";
  if (!gloss.empty()) print_line(stderr, "warning: %s: %s\n", scene->name.c_str(), gloss.c_str());

  prepare_btfs(options, *scene);
  Renderer renderer;
  const std::shared_ptr<const Scene> drawn =
      with_ground(scene, *environment, options.settings, radians(options.env_rotation_deg));
  renderer.set_scene(drawn);
  renderer.set_environment(environment);
  for (const auto& [name, source] : options.materials) renderer.set_material(name, source);
  FrameRequest request = make_request(*drawn, options);
  request.display =
      options.reference.empty() && (options.output.empty() || picture_format(options.output) == PictureFormat::png);
  const bool accumulates = options.time_s || options.target_error;
  // A few paths in each frame, which share the camera's rays: frames have little overhead, and the loop stops in time.
  if (traces_picture(request) && accumulates && options.samples == 0) request.samples = 8;
  const Clock::time_point preparation = Clock::now();
  renderer.finish_background_work(request);

  RenderReport report;
  Ending ending = Ending::as_asked;
  if (accumulates)
    ending = Accumulation(&renderer, options, reference, &report).run(request, preparation);
  else
    render_frames(&renderer, request, options, &report);
  warn_of_light_left_out(report.frames.back().plan);
  if (accumulates) warn_of_blurred_shadows(report.frames.back().plan);
  warn_of_frame_bakes(report.frames.back().status);
  const Image radiance = renderer.read_radiance();
  if (reference) report.error = measure_error(radiance, *reference).figures;
  if (!options.output.empty()) {
    const float suited_ev = exposure_of(options, *environment);
    write_picture(renderer, radiance, options.exposure_ev ? suited_ev : meter_exposure_ev(radiance, suited_ev), options,
                  request);
    if (options.stats != "-")
      print_line(stdout, "%s: %dx%d, mode %s%s, %s%s\n", options.output.c_str(), request.width, request.height,
                 request.mode.c_str(), request.part_modes.empty() ? "" : " and others for parts",
                 time_text(report, request, accumulates).c_str(), error_text(report, options, ending).c_str());
  }
  if (!options.stats.empty()) write_text(options.stats, stats_json(options, request, device, report));
  if (ending == Ending::interrupted)
    throw Error("maquette render", "interrupted after " + duration_text(report.total_s),
                options.output.empty() ? "" : options.output + " holds the picture so far");
  if (ending == Ending::out_of_time && !options.time_s)
    throw Error("--target-error " + to_text(*options.target_error), "it was not reached within ten minutes",
                "raise it, or give --time for as long as it may take");
  return 0;
}

}  // namespace maquette
