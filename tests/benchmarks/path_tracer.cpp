// The reference path tracer: rays a second, agreement with closed forms and with `uniform`, error against time.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <numbers>
#include <type_traits>

#include "render/raytraced/embree_ray.h"
#include "render/reference/path_scene.h"
#include "render/reference/reference.h"
#include "render/reference/surface.h"
#include "render/reference/traversal.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"
#include "tests/benchmarks/embree_triangles.h"
#include "tests/benchmarks/stage.h"
#include "tests/support/cornell.h"
#include "tests/support/sphere_quadrature.h"

namespace maquette::bench {
namespace {

/// Prints a figure as soon as it is known: this part takes minutes.
void keep(Figures* figures, Figure figure) {
  std::fprintf(stderr, "   %s: %s\n", figure.name.c_str(), figure.measured.c_str());
  figures->push_back(std::move(figure));
}

using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, EmbreeRelease>;

/// The same surfaces as single triangles.
EmbreeScene build_triangles(const PathScene& scene) {
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < scene.mesh_begin[PathScene::kHidden]; ++i)
    indices.insert(indices.end(), scene.corners(i), scene.corners(i) + 3);
  return EmbreeScene(build_embree_triangles(scene.device.get(), scene.geometry.positions, indices));
}

/// Embree's time for the rays one by one: no filters, no shading.
double embree_alone_ms(RTCScene scene, const std::vector<LoggedRay>& rays) {
  const Clock start = now();
  parallel_ranges<std::size_t>(0, rays.size(), 1024, [&](const auto& range) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const LoggedRay& r = rays[i];
      RTCRayHit query;
      query.ray = embree_ray(r.origin, r.direction, r.near, r.far);
      query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      if (r.shadow)
        rtcOccluded1(scene, &context, &query.ray);
      else
        rtcIntersect1(scene, &context, &query);
    }
  });
  return (now() - start).cpu_ms;
}

/// So many that a picture's set-up time, which single rays do not have, counts little.
constexpr int kRayPaths = 32;

std::vector<LoggedRay> log_rays(const std::shared_ptr<const PathScene>& scene, const PictureRequest& request) {
  std::vector<LoggedRay> rays;
  std::mutex mutex;
  scene->log = [&](const LoggedRay& ray) {
    const std::lock_guard lock(mutex);
    rays.push_back(ray);
  };
  ReferencePicture(scene, request).add(kRayPaths);
  scene->log = nullptr;
  return rays;
}

PictureRequest picture_of(const CameraView& camera, int width, int height) {
  PictureRequest request;
  request.camera = camera;
  request.width = width;
  request.height = height;
  return request;
}

void measure_rays(Stage& stage, Figures* figures) {
  const Scene scene = load_scene("builtin:cockpit");
  const auto environment = std::make_shared<const Environment>(load_environment("builtin:clear-sky"));
  Scene opaque = scene;
  for (Material& m : opaque.materials) m = Material();
  const auto traced = build_path_scene({.scene = scene, .environment = environment});
  const auto plain = build_path_scene({.scene = opaque, .environment = environment});
  const EmbreeScene triangles = build_triangles(*plain);
  const PictureRequest request = picture_of(find_camera(scene, "driver"), 320, 180);
  const std::vector<LoggedRay> rays = log_rays(traced, request);
  const double count = static_cast<double>(rays.size());
  std::vector<double> ours, of_triangles, of_quads;  // million rays a second of processor time
  for (int i = 0; i < std::max(stage.options().repeats, 1); ++i) {
    const Clock start = now();
    ReferencePicture(traced, request).add(kRayPaths);
    ours.push_back(count / (now() - start).cpu_ms / 1e3);
    of_triangles.push_back(count / embree_alone_ms(triangles.get(), rays) / 1e3);
    of_quads.push_back(count / embree_alone_ms(plain->embree.get(), rays) / 1e3);
  }
  for (std::vector<double>* v : {&ours, &of_triangles, &of_quads})
    std::nth_element(v->begin(), v->begin() + static_cast<std::ptrdiff_t>(v->size() / 2), v->end());
  const auto against = [&](const std::vector<double>& loop) {
    const double mine = ours[ours.size() / 2], embree = loop[loop.size() / 2];
    return std::pair{mine / embree, number(mine / embree) + " (" + number(mine) + " against " + number(embree) +
                                        " million rays a second of processor time and core)"};
  };
  const auto [ratio, text] = against(of_triangles);
  keep(figures, judged("cockpit/driver: rays a second, shading included, over Embree alone on the triangles", ">= 0.5",
                       text, ratio >= 0.5));
  keep(figures, shown("the same, over Embree alone on the tracer's quads", against(of_quads).second));
}

/// Shading normals of the sphere that the tracer sees at the pixel centres.
Image traced_normals(const PathScene& scene, const PictureRequest& r) {
  Image normals(r.width, r.height, 4);
  const CameraFrame c = make_camera_frame(r.camera, r.width, r.height, scene.bounds);
  for (int y = 0; y < r.height; ++y)
    for (int x = 0; x < r.width; ++x) {
      const glm::vec2 ndc(2.0f * (static_cast<float>(x) + 0.5f) / static_cast<float>(r.width) - 1.0f,
                          1.0f - 2.0f * (static_cast<float>(y) + 0.5f) / static_cast<float>(r.height));
      const EyeRay through = c.ray_through(ndc);
      const Ray ray{through.origin, through.direction, c.near_m};
      RayHit hit;
      if (!intersect(scene, ray, RayKind::camera, 0, &hit)) continue;
      const SurfacePoint p = resolve_surface(scene, ray, hit, {});
      for (int k = 0; k < 3; ++k) normals.at(x, y, k) = p.n[k];
      normals.at(x, y, 3) = 1.0f;
    }
  return normals;
}

void measure_quadrature(Stage& stage, Figures* figures) {
  constexpr int kSide = 32, kMostPaths = 16384;
  constexpr double kNoise = 0.0005, kMost_ms = 60e3;  // of processor time
  for (const char* name : {"matte-white", "paint-red-metallic", "metal-chrome"}) {
    if (!stage.options().wants(std::string("reference/") + name)) continue;
    const std::string material = std::string("builtin:") + name;
    Scene scene = load_scene("builtin:sphere");
    scene.materials = effective_materials(scene, {{"*", material}});
    const auto environment = std::make_shared<const Environment>(load_environment("builtin:clear-sky"));
    const auto traced = build_path_scene({.scene = scene, .environment = environment});
    CameraView camera;
    camera.eye = {0.0f, 0.0f, 4.5f};
    camera.fov_y_rad = 0.5f;
    PictureRequest request = picture_of(camera, kSide, kSide);
    request.paths.transport = Transport::direct;
    ReferencePicture picture(traced, request);
    const Clock start = now();
    do picture.add(std::max(picture.samples(), 256));
    while (picture.samples() < kMostPaths && picture.relative_error() > kNoise && (now() - start).cpu_ms < kMost_ms);
    const Image normals = traced_normals(*traced, request);
    const test::SphereQuadrature exact =
        test::integrate_sphere(*environment, load_brdf(material), {4.5, 0.5, kSide}, &normals);
    const double error = test::relative_rmse(picture.mean(), exact);
    keep(figures, judged(std::string("direct transport against quadrature, ") + name, "<= 0.2 %",
                         percent(error) + " (its own noise " + percent(picture.relative_error()) + ", " +
                             std::to_string(picture.samples()) + " paths)",
                         error <= 0.002));
  }
}

void measure_furnace(Figures* figures) {
  auto environment = std::make_shared<Environment>();
  environment->width = 16;
  environment->height = 8;
  environment->rgb.assign(128, glm::vec3(1.0f));
  Scene scene = load_scene("builtin:sphere");
  for (Material& m : scene.materials) {
    m = Material();
    m.metallic = 0.0f;
    m.roughness = 1.0f;
    m.specular = 0.0f;
  }
  CameraView camera;
  ReferencePicture picture(build_path_scene({.scene = scene, .environment = environment}), picture_of(camera, 64, 64));
  picture.add(4096);
  const Image mean = picture.mean();
  double worst = 0.0, square = 0.0;
  std::size_t count = 0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const double error = std::abs(static_cast<double>(mean.at(x, y, 1)) - 1.0);
      worst = std::max(worst, error);
      square += error * error;
      ++count;
    }
  const double rms = std::sqrt(square / static_cast<double>(count));
  keep(figures, judged("white furnace, full transport", "<= 0.1 %",
                       percent(rms) + " (largest of any pixel " + percent(worst) + ")", rms <= 0.001));
}

/// The box of diffuse walls against radiosity, the paths' noise included.
void measure_cornell(Figures* figures) {
  constexpr std::uint32_t kPaths = 49152;
  const test::Radiosity radiosity(test::cornell_triangles(), {.largest_edge = 0.8, .rays = 1024, .light_cells = 16});
  auto dark = std::make_shared<Environment>();
  dark->width = 2;
  dark->height = 1;
  dark->rgb.assign(2, glm::vec3(0.0f));
  const auto scene = build_path_scene({.scene = load_scene("builtin:cornell"), .environment = dark});
  const test::CornellView view(12);
  const std::vector<test::CornellPixel> pixels = view.pixels(radiosity);
  std::vector<double> seen(pixels.size()), exact(pixels.size());
  parallel_for(std::size_t{0}, pixels.size(), [&](std::size_t i) {
    const test::SurfaceHit& hit = pixels[i].hit;
    exact[i] = luminance(hit.albedo / std::numbers::pi * radiosity.irradiance(hit.position, hit.normal, 4096));
    const glm::dvec3 eye = hit.position + 0.01 * (glm::dvec3(0.0, 2.73, 10.8) - hit.position);
    glm::dvec3 sum(0.0);
    for (std::uint32_t k = 0; k < kPaths; ++k)
      sum += glm::dvec3(estimate_radiance(*scene, {}, glm::vec3(eye), glm::vec3(glm::normalize(hit.position - eye)),
                                          static_cast<std::uint32_t>(i + 1), k));
    seen[i] = luminance(sum / static_cast<double>(kPaths));
  });
  double square = 0.0, mean = 0.0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    square += (seen[i] - exact[i]) * (seen[i] - exact[i]);
    mean += exact[i];
  }
  const auto n = static_cast<double>(pixels.size());
  const double error = std::sqrt(square / n) / (mean / n);
  keep(figures, judged("Cornell box against radiosity, noise of the paths included", "<= 0.5 %",
                       percent(error) + " (" + std::to_string(pixels.size()) + " points, " + std::to_string(kPaths) +
                           " paths each)",
                       error <= 0.005));
}

void measure_uniform_agreement(Stage& stage, Figures* figures) {
  for (Case c : {Case{.name = "reference/sphere", .scene = "builtin:sphere"},
                 Case{.name = "reference/plate", .scene = "builtin:plate"},
                 Case{.name = "reference/door", .scene = "builtin:cockpit", .camera = "door"}}) {
    if (!stage.options().wants(c.name)) continue;
    c.environment = "builtin:studio";
    c.width = 160;
    c.height = 90;
    stage.show(c);
    const auto converge = [&](const std::string& mode, const char* key, const char* value, std::uint32_t seed) {
      FrameRequest r = stage.request(mode, mode == "reference" ? 1024 : 4096, seed);
      r.settings.set_from_text(key, value);
      for (int f = 0; f < (mode == "reference" ? 1 : 4); ++f) stage.renderer().render(r, f > 0);
      return stage.renderer().read_radiance();
    };
    const Image uniform = converge("uniform", "shading.visibility", "none", 1);
    const Image other = converge("uniform", "shading.visibility", "none", 2);
    const Image direct = converge("reference", "reference.transport", "direct", 1);
    const Image again = converge("reference", "reference.transport", "direct", 2);
    const double noise_u = relative_rmse(other, uniform) / std::sqrt(2.0);
    const double noise_d = relative_rmse(again, direct) / std::sqrt(2.0);
    const double all = relative_rmse(direct, uniform);
    const double error = std::sqrt(std::max(all * all - noise_u * noise_u - noise_d * noise_d, 0.0));
    keep(figures,
         judged(c.name + ": direct transport against uniform, noise of both taken out", "<= 0.5 %",
                percent(error) + " (noise " + percent(noise_d) + " and " + percent(noise_u) + ")", error <= 0.005));
  }
}

/// Seen from the driver's eye, looking straight ahead; the car's front is towards -z.
CameraView driver_of_the_car() {
  CameraView camera;
  camera.eye = {-0.36f, 0.98f, 0.12f};
  camera.target = {-0.36f, 0.98f, -1.0f};
  camera.fov_y_rad = 1.0122910f;  // 58 degrees
  return camera;
}

std::shared_ptr<const PathScene> load_car(const Options& options) {
  Scene scene = load_scene(options.data + "/scenes/ferrari458.glb");
  scene.materials = effective_materials(scene, {{"Glass_Gray", "builtin:glass"}});
  return build_path_scene({.scene = scene,
                           .environment = std::make_shared<const Environment>(
                               load_environment(options.data + "/environments/grace_latlong.exr"))});
}

/// RMS difference of two pictures with different seeds, which is sqrt(2) times the error of each, over the mean
/// luminance.
double pair_error(const Image& a, const Image& b, bool whole) {
  double square = 0.0, light = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.data.size(); i += 4) {
    if (!whole && a.data[i + 3] < 1.0f) continue;
    for (std::size_t c = 0; c < 3; ++c) square += std::pow(static_cast<double>(a.data[i + c]) - b.data[i + c], 2.0);
    light += luminance(glm::dvec3(a.data[i], a.data[i + 1], a.data[i + 2]));
    ++count;
  }
  const auto n = static_cast<double>(count);
  return std::sqrt(square / (6.0 * n)) / (light / n);
}

void measure_car(Stage& stage, Figures* figures) {
  const std::string name = "Ferrari, driver's eye, Grace, 640 x 360: relative RMSE, sky included, after ";
  if (stage.options().data.empty()) {
    keep(figures, absent(name + "7, 26, 95 s", "7.3, 3.0, 1.4 %", "needs --data"));
    return;
  }
  const auto scene = load_car(stage.options());
  PictureRequest request = picture_of(driver_of_the_car(), 640, 360);
  ReferencePicture first(scene, request);
  request.seed = 1;
  ReferencePicture second(scene, request);
  // Processor time of both cores: other load on the machine does not count.
  double spent_ms = 0.0;
  for (const auto& [seconds, target] : {std::pair{7.0, 0.073}, {26.0, 0.03}, {95.0, 0.014}}) {
    while (spent_ms < 2e3 * seconds) {
      const Clock start = now();
      // All paths of one call share the pixel's first ray and its panes, so calls with single paths would be slower.
      const int count = std::max(first.samples() / 8, 1);
      first.add(count);
      second.add(count);
      spent_ms += 0.5 * (now() - start).cpu_ms;
    }
    const double error = pair_error(first.mean(), second.mean(), true);
    keep(figures, judged(name + number(seconds) + " s of two cores", "<= " + percent(target),
                         percent(error) + " (cabin alone " + percent(pair_error(first.mean(), second.mean(), false)) +
                             ", " + std::to_string(first.samples()) + " paths a pixel)",
                         error <= target));
  }
}

/// Largest ratios of a pixel's luminance to the mean of the eight around it.
struct Outliers {
  double any = 0.0;      ///< including mirror images of lamps that fill a pixel
  double firefly = 0.0;  ///< of pixels that are darker in a picture with another seed: relative to that picture
};

/// A lamp mirrored in chrome is equally bright in both pictures, because their rays hit the same point. A firefly is
/// random.
Outliers largest_outliers(const Image& image, const Image& other) {
  Outliers worst;
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x) {
      double around = 0.0;
      for (int k = 0; k < 9; ++k)
        if (k != 4) around += luminance(image, x + k % 3 - 1, y + k / 3 - 1) / 8.0;
      const double here = luminance(image, x, y), neighbourhood = std::max(around, luminance(other, x, y));
      if (around > 0.0) worst.any = std::max(worst.any, here / around);
      if (neighbourhood > 0.0) worst.firefly = std::max(worst.firefly, here / neighbourhood);
    }
  return worst;
}

void measure_fireflies(Stage& stage, Figures* figures) {
  constexpr int kPaths = 1024;
  const auto measure = [&](const std::string& name, const std::shared_ptr<const PathScene>& scene,
                           const CameraView& camera) {
    PictureRequest request = picture_of(camera, 160, 90);
    Image means[2];
    for (Image& mean : means) {
      ReferencePicture picture(scene, request);
      picture.add(kPaths);
      mean = picture.mean();
      ++request.seed;
    }
    const Outliers a = largest_outliers(means[0], means[1]), b = largest_outliers(means[1], means[0]);
    const double worst = std::max(a.firefly, b.firefly);
    keep(figures, judged(name + ", largest pixel over its neighbourhood at 1024 paths, 160 x 90", "<= 50",
                         number(worst) + " (" + number(std::max(a.any, b.any)) +
                             " with mirror images of lamps, which both of two seeds show)",
                         worst <= 50.0));
  };
  const Scene cockpit = load_scene("builtin:cockpit");
  measure("cockpit/driver",
          build_path_scene({.scene = cockpit,
                            .environment = std::make_shared<const Environment>(load_environment("builtin:clear-sky"))}),
          find_camera(cockpit, "driver"));
  if (stage.options().data.empty())
    keep(figures, absent("Ferrari, largest pixel over its neighbourhood at 1024 paths", "<= 50", "needs --data"));
  else
    measure("Ferrari", load_car(stage.options()), driver_of_the_car());
}

}  // namespace

Figures measure_path_tracer(Stage& stage) {
  Figures figures;
  const auto& wants = [&](const char* name) { return stage.options().wants(std::string("reference/") + name); };
  if (wants("rays")) measure_rays(stage, &figures);
  if (wants("furnace")) measure_furnace(&figures);
  if (wants("cornell")) measure_cornell(&figures);
  measure_quadrature(stage, &figures);
  measure_uniform_agreement(stage, &figures);
  if (wants("car")) measure_car(stage, &figures);
  if (wants("fireflies")) measure_fireflies(stage, &figures);
  return figures;
}

}  // namespace maquette::bench
