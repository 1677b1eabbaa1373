// What the default mode shows, over the time that a view is at rest, against all light paths: RMSE from the products of
// the differences from two halves of the reference, and FLIP beside that of the halves themselves.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <span>

#include "render/metrics/metrics.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_io.h"
#include "tests/benchmarks/stage.h"

namespace maquette::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kSeconds[] = {0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 60.0};
constexpr double kTarget_s = 20.0;  ///< at which FLIP is judged

struct PictureView {
  Case shown;
  double flip = 0.10;                                   ///< largest allowed after kTarget_s
  std::function<CameraView(const Scene&)> camera = {};  ///< null: the scene's
  std::string pane = {};                                ///< material that is made of glass
};

/// Around the bounds' centre, `direction` towards the eye, at `distances` radii.
CameraView around(const Scene& scene, const glm::vec3& direction, float distances) {
  const Bounds bounds = compute_bounds(scene);
  CameraView view;
  view.fov_y_rad = 0.6f;
  view.target = bounds.center();
  view.eye = view.target + distances * bounds.radius() * glm::normalize(direction);
  return view;
}

/// At the driver's eye of a car that faces -Z, sized by its bounds.
CameraView at_the_wheel(const Scene& scene) {
  const Bounds bounds = compute_bounds(scene);
  const glm::vec3 size = bounds.max - bounds.min;
  CameraView view;
  view.fov_y_rad = 1.0f;
  view.eye = bounds.center() + glm::vec3(-0.18f * size.x, 0.33f * size.y, 0.0f);
  view.target = view.eye + glm::vec3(0.06f, -0.15f, -1.0f);
  return view;
}

std::vector<PictureView> picture_views(const Options& options) {
  std::vector<PictureView> views;
  for (const char* camera : {"driver", "passenger", "exterior", "door"})
    views.push_back({{.name = std::string("cockpit/") + camera, .scene = "builtin:cockpit", .camera = camera},
                     std::string(camera) == "exterior" ? 0.06 : 0.10});
  views.push_back({{.name = "plate", .scene = "builtin:plate"}, 0.06});
  if (options.data.empty()) return views;
  for (const auto& [light, file] :
       {std::pair("grace", "grace_latlong.exr"), std::pair("workshop", "autoshop_01_1k.hdr")}) {
    Case car{.scene = options.data + "/scenes/ferrari458.glb"};
    car.environment = options.data + "/environments/" + file;
    const auto add = [&, light = light](const char* name, double flip, std::function<CameraView(const Scene&)> camera,
                         const char* pane = "") {
      car.name = std::string("ferrari/") + name + "/" + light;
      views.push_back({car, flip, std::move(camera), pane});
    };
    add("wheel", 0.10, at_the_wheel, "Glass_Gray");  // opaque in the file
    add("front", 0.06, [](const Scene& scene) { return around(scene, {-0.7f, 0.3f, -1.0f}, 2.6f); });
    add("behind", 0.06, [](const Scene& scene) { return around(scene, {0.7f, 0.3f, 1.0f}, 2.6f); });
  }
  return views;
}

FrameRequest request_of(Stage& stage, const PictureView& view, const std::string& mode, std::uint32_t seed) {
  FrameRequest r = stage.request(mode, 0, seed);
  r.reflections = kAutoReflections;  // as commands and window have it
  const bool asked = std::any_of(stage.options().settings.begin(), stage.options().settings.end(),
                                 [](const auto& s) { return s.first == "shading.visibility"; });
  if (!asked) r.settings.set_from_text("shading.visibility", "auto");
  if (view.camera) r.camera = view.camera(stage.renderer().scene());
  return r;
}

/// Both halves of the reference, from the disk where the same was made before.
std::array<Image, 2> reference_halves(Stage& stage, const PictureView& view) {
  FrameRequest r = request_of(stage, view, "reference", 0);
  // Its first paths tell the scene's content apart.
  r.samples = 1;
  stage.renderer().render(r);
  const Image first = stage.renderer().read_radiance();
  const double seconds = stage.options().reference_seconds;
  const std::uint64_t key = content_hash(std::as_bytes(std::span(first.data)), static_cast<std::uint64_t>(seconds));
  const fs::path folder = fs::path(stage.options().scratch) / "pictures";
  fs::create_directories(folder);
  std::array<Image, 2> halves;
  for (std::uint32_t h = 0; h < 2; ++h) {
    char name[40];
    std::snprintf(name, sizeof name, "%016llx-%u.exr", static_cast<unsigned long long>(key), h);
    const std::string path = (folder / name).string();
    if (!stage.options().fresh && fs::exists(path)) {
      halves[h] = load_hdr_image(path);
      continue;
    }
    r.seed = 100 + h;
    r.samples = 4;
    const Clock begin = now();
    for (bool more = false; (now() - begin).wall_ms < 1e3 * seconds; more = true) stage.renderer().render(r, more);
    halves[h] = stage.renderer().read_radiance();
    save_exr(path, halves[h]);
  }
  return halves;
}

/// RMSE over the mean luminance, from (p - a)(p - b): the reference's own noise has no part in it.
double error_of(const Image& picture, const std::array<Image, 2>& halves) {
  double sum = 0.0, mean = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.data.size(); i += 4) {
    if (halves[0].data[i + 3] < 1.0f) continue;
    for (std::size_t c = i; c < i + 3; ++c) {
      const double p = picture.data[c], a = halves[0].data[c], b = halves[1].data[c];
      sum += (p - a) * (p - b);
      mean += 0.5 * (a + b);
    }
    count += 3;
  }
  return count == 0 || mean <= 0.0
             ? 0.0
             : std::sqrt(std::max(sum / static_cast<double>(count), 0.0)) * static_cast<double>(count) / mean;
}

Image mean_of(const std::array<Image, 2>& halves) {
  Image mean = halves[0];
  for (std::size_t i = 0; i < mean.data.size(); ++i) mean.data[i] = 0.5f * (halves[0].data[i] + halves[1].data[i]);
  return mean;
}

double flip_of(const Image& picture, const Image& reference) {
  return measure_error(picture, reference).figures.flip_ldr.value_or(1.0);
}

}  // namespace

Figures measure_pictures(Stage& stage) {
  Figures figures;
  for (const PictureView& view : picture_views(stage.options())) {
    if (!stage.options().wants(view.shown.name)) continue;
    stage.show(view.shown);
    if (!view.pane.empty()) stage.renderer().set_material(view.pane, "builtin:glass");
    const std::array<Image, 2> halves = reference_halves(stage, view);
    const Image reference = mean_of(halves);
    const double own = flip_of(halves[0], halves[1]);
    const FrameRequest request = request_of(stage, view, "bandwidth", 0);
    stage.renderer().finish_background_work(request);
    stage.renderer().render(request);  // compiles the shaders
    const Clock begin = now();
    std::string measured;
    double judged_flip = 1.0;
    bool more = false;
    for (const double seconds : kSeconds) {
      if (seconds > stage.options().sweep_seconds) break;
      do {
        stage.renderer().render(request, more);
        more = true;
      } while ((now() - begin).wall_ms < 1e3 * seconds);
      const Image picture = stage.renderer().read_radiance();
      const double flip = flip_of(picture, reference);
      if (seconds <= kTarget_s) judged_flip = flip;
      measured += (measured.empty() ? "" : "; ") + number(seconds) + " s " + percent(error_of(picture, halves)) + ", " +
                  number(flip);
      save_exr(
          (fs::path(stage.options().scratch) / "pictures" / (std::to_string(figures.size()) + "-shown.exr")).string(),
          picture);
    }
    save_exr(
        (fs::path(stage.options().scratch) / "pictures" / (std::to_string(figures.size()) + "-reference.exr")).string(),
        reference);
    if (!view.pane.empty()) stage.renderer().set_material(view.pane, "");
    figures.push_back(judged("default picture at rest, " + view.shown.name + ": RMSE, FLIP (LDR)",
                             "FLIP <= " + number(view.flip) + " after 20 s", measured + "; halves " + number(own),
                             judged_flip <= view.flip));
  }
  return figures;
}

}  // namespace maquette::bench
