#include "tests/benchmarks/stage.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>

#include "render/metrics/metrics.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_io.h"
#include "tests/support/converged_parts.h"

namespace maquette::bench {

namespace fs = std::filesystem;

bool Options::wants(const std::string& name) const {
  if (only.empty()) return true;
  return std::any_of(only.begin(), only.end(), [&](const std::string& o) { return name.find(o) != std::string::npos; });
}

Figure judged(std::string name, std::string target, std::string measured, bool met) {
  return {std::move(name), std::move(target), std::move(measured),
          met ? Figure::Verdict::met : Figure::Verdict::missed};
}
Figure shown(std::string name, std::string measured) {
  return {std::move(name), "", std::move(measured), Figure::Verdict::shown};
}
Figure absent(std::string name, std::string target, std::string why) {
  return {std::move(name), std::move(target), std::move(why), Figure::Verdict::absent};
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(value) >= 100.0 ? "%.0f" : "%.3g", value);
  return text;
}

std::string percent(double share) { return number(100.0 * share) + " %"; }

Clock now() {
  timespec cpu{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
  const auto wall = std::chrono::steady_clock::now().time_since_epoch();
  return {std::chrono::duration<double, std::milli>(wall).count(),
          static_cast<double>(cpu.tv_sec) * 1e3 + static_cast<double>(cpu.tv_nsec) * 1e-6};
}

CameraView find_camera(const Scene& scene, const std::string& name) {
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (node.camera < 0) continue;
    const Camera& camera = scene.cameras[static_cast<std::size_t>(node.camera)];
    if (!name.empty() && camera.name != name && node.name != name) continue;
    CameraView view;
    view.eye = glm::vec3(world[i][3]);
    view.target = view.eye - glm::normalize(glm::vec3(world[i][2]));
    view.up = glm::vec3(world[i][1]);
    view.fov_y_rad = camera.fov_y_rad;
    return view;
  }
  if (!name.empty()) throw Error(scene.name, "has no camera '" + name + "'");
  const Bounds bounds = compute_bounds(scene);
  CameraView view;
  view.fov_y_rad = 0.5f;
  view.target = bounds.center();
  view.eye = view.target + glm::normalize(glm::vec3(1.0f, 0.45f, 1.0f)) * (bounds.radius() / std::sin(0.32f));
  return view;
}

Stage::Stage(const Options& options)
    : options_(options), context_(GlContext::create_headless()), device_(query_device()) {
  install_debug_output();
  renderer_ = std::make_unique<Renderer>();
}

void Stage::show(const Case& c) {
  if (c.scene != case_.scene || c.plain != case_.plain) {
    auto scene = std::make_shared<Scene>(load_scene(c.scene));
    for (Material& m : scene->materials)
      if (c.plain)
        m.base_color_texture = m.metallic_roughness_texture = m.normal_texture = m.occlusion_texture =
            m.emissive_texture = {};
    scene_ = scene;
    renderer_->set_scene(scene_);
    case_.material.clear();
  }
  if (c.environment != case_.environment || environment_hash_ == 0) {
    environment_ = std::make_shared<Environment>(load_environment(c.environment));
    environment_hash_ = environment_->hash;
    renderer_->set_environment(environment_);
  }
  if (c.material != case_.material) renderer_->set_material("*", c.material);
  camera_ = find_camera(renderer_->scene(), c.camera);
  case_ = c;
}

FrameRequest Stage::request(const std::string& mode, int samples, std::uint32_t seed) const {
  FrameRequest r;
  r.mode = mode;
  r.camera = camera_;
  r.width = case_.width;
  r.height = case_.height;
  r.samples = samples;
  r.seed = seed;
  r.settings.set_from_text("shading.visibility", "none");
  for (const auto& [name, text] : options_.settings) r.settings.set_from_text(name, text);
  return r;
}

std::uint64_t Stage::content_key() {
  // What the picture shows, except its light: a change of scene, camera or size needs a new reference.
  constexpr std::uint64_t kMade = 2;  // version of the method; 2: from the environment as it is, not as packed
  std::uint64_t key = environment_hash_ + kMade;
  const auto mix = [&](const void* data, std::size_t bytes) {
    key = content_hash({static_cast<const std::byte*>(data), bytes}, key);
  };
  mix(case_.material.data(), case_.material.size());
  renderer_->render(request("uniform", 2));
  for (const char* view : {"depth", "normal", "base_color", "material"}) {
    const Image image = renderer_->read_debug_view(view);
    mix(image.data.data(), image.data.size() * sizeof(float));
  }
  for (const Material& m : renderer_->scene().materials) mix(m.measured.data(), m.measured.size());
  return key;
}

namespace {

/// a += b, except alpha.
void add_light(Image* a, const Image& b) {
  for (std::size_t i = 0; i < a->data.size(); ++i)
    if (i % 4 != 3) a->data[i] += b.data[i];
}

/// The layers over the opaque surfaces: picture = through * opaque + added, for each pixel and channel.
struct Panes {
  Image through, added;
};

/// Computed from pictures of the same samples with and without the panes, for several seeds: the two that differ most
/// give both unknowns, and the others check the result.
Panes solve_panes(const std::vector<Image>& with, const std::vector<Image>& without) {
  Panes panes{with[0], with[0]};
  for (std::size_t i = 0; i < with[0].data.size(); ++i) {
    std::size_t low = 0, high = 0;
    for (std::size_t s = 1; s < with.size(); ++s) {
      if (without[s].data[i] < without[low].data[i]) low = s;
      if (without[s].data[i] > without[high].data[i]) high = s;
    }
    const double step = static_cast<double>(without[high].data[i]) - without[low].data[i];
    const double rise = static_cast<double>(with[high].data[i]) - with[low].data[i];
    const double through = step > 1e-6 * std::abs(without[high].data[i]) ? rise / step : 0.0;
    const double added = with[low].data[i] - through * without[low].data[i];
    panes.through.data[i] = static_cast<float>(through);
    panes.added.data[i] = static_cast<float>(added);
    for (std::size_t s = 0; s < with.size(); ++s)
      if (std::abs(through * without[s].data[i] + added - with[s].data[i]) > 1e-3 * (with[high].data[i] + 1e-3))
        throw Error("benchmark", "panes are not linear over what is behind them");
  }
  return panes;
}

}  // namespace

void Stage::set_inputs(std::shared_ptr<const Scene> scene, std::shared_ptr<const Environment> environment) {
  renderer_->set_environment(std::move(environment));
  renderer_->set_scene(std::move(scene));
  if (!case_.material.empty()) renderer_->set_material("*", case_.material);
}

Image Stage::draw_uniform(int samples, std::uint32_t seed, int frames) {
  const FrameRequest r = request("uniform", samples, seed);
  for (int f = 0; f < frames; ++f) renderer_->render(r, f > 0);
  return renderer_->read_radiance();
}

/// Runs at every pixel first, then where they reduce the error most, until noise or time reaches its limit.
void Stage::sample_halves(const Clock& begin, test::SampledHalf halves[2]) {
  constexpr int kFrames = 4, kSamples = 256, kMaxRuns = 1024, kPilotRuns = 8;
  constexpr double kEnough = 0.002;
  // The kernel for single pixels supports only measured tables and the sky.
  const FramePlan plan = renderer_->render(request("uniform", 2)).plan;
  const bool single = !case_.material.empty() && !plan.shading().lights;
  for (int h = 0; h < 2; ++h) halves[h] = test::SampledHalf(case_.width, case_.height);
  int runs = 0;
  double noise = 1.0;
  const auto go_on = [&] {
    return runs < kMaxRuns && noise > kEnough && 0.5 * (now() - begin).cpu_ms < 1e3 * options_.reference_seconds;
  };
  for (; go_on() && (!single || runs < kPilotRuns); runs += 2) {
    // Low-discrepancy runs, each with its own seed, alternating between the halves.
    for (int h = 0; h < 2; ++h)
      halves[h].add(draw_uniform(kSamples, static_cast<std::uint32_t>(1000 + runs + h), kFrames));
    noise = 0.5 * relative_rmse(halves[0].mean(), halves[1].mean());
  }
  if (!go_on()) return;
  const test::PixelSampler sampler;
  for (; go_on(); runs += 2) {
    const std::size_t count = static_cast<std::size_t>(case_.width) * static_cast<std::size_t>(case_.height) / 32;
    const std::vector<std::uint32_t> pixels[2] = {halves[0].neediest(halves[1], count),
                                                  halves[1].neediest(halves[0], count)};
    for (int h = 0; h < 2; ++h) {
      draw_uniform(2, static_cast<std::uint32_t>(1000 + runs + h));  // seed and light samples
      halves[h].add(pixels[h], sampler.draw(pixels[h], kFrames * kSamples));
    }
    noise = 0.5 * relative_rmse(halves[0].mean(), halves[1].mean());
  }
}

void Stage::make_reference(Image halves[2]) {
  const Clock begin = now();
  const test::SplitEnvironment split = test::split_environment(*environment_);
  const std::shared_ptr<const Scene> opaque = renderer_->facts().has_glass ? test::without_panes(*scene_) : scene_;
  std::vector<Image> with, without;
  if (opaque != scene_) {
    for (std::uint32_t seed = 0; seed < 4; ++seed) with.push_back(draw_uniform(2, seed));
    set_inputs(opaque, environment_);
    for (std::uint32_t seed = 0; seed < 4; ++seed) without.push_back(draw_uniform(2, seed));
  }
  set_inputs(opaque, split.rest);
  test::SampledHalf sampled[2];
  sample_halves(begin, sampled);
  for (int h = 0; h < 2; ++h) {
    halves[h] = sampled[h].mean();
    if (split.bright.empty()) continue;
    const test::CellGrid grid = h == 0 ? test::coarse_grid(split) : test::fine_grid(split);
    add_light(&halves[h], test::shade_cells(*renderer_, split.bright, grid, !case_.material.empty()));
  }
  if (opaque != scene_) {
    const Panes panes = solve_panes(with, without);
    for (int h = 0; h < 2; ++h)
      for (std::size_t i = 0; i < halves[h].data.size(); ++i)
        if (i % 4 != 3) halves[h].data[i] = panes.through.data[i] * halves[h].data[i] + panes.added.data[i];
  }
  set_inputs(scene_, environment_);
  const Clock spent = now() - begin;
  std::fprintf(stderr, "  %-16s converged picture: noise %.3f %%, %zu bright cells, %.1f s (processor time %.1f s)\n",
               case_.name.c_str(), 50.0 * relative_rmse(halves[0], halves[1]), split.bright.size(),
               1e-3 * spent.wall_ms, 1e-3 * spent.cpu_ms);
}

const Reference& Stage::reference() {
  const std::uint64_t key = content_key();
  char id[24];
  std::snprintf(id, sizeof id, "%016llx", static_cast<unsigned long long>(key));
  if (reference_of_ == id) return reference_;
  const fs::path folder = fs::path(options_.scratch) / "references";
  fs::create_directories(folder);
  const std::string paths[2] = {(folder / (std::string(id) + "-a.exr")).string(),
                                (folder / (std::string(id) + "-b.exr")).string()};
  auto& halves = reference_.halves;
  if (!options_.fresh && fs::exists(paths[0]) && fs::exists(paths[1])) {
    for (int h = 0; h < 2; ++h) halves[h] = load_hdr_image(paths[h]);
  } else {
    make_reference(halves);
    for (int h = 0; h < 2; ++h) save_exr(paths[h], halves[h]);
  }
  reference_.noise = 0.5 * relative_rmse(halves[0], halves[1]);
  reference_.picture = halves[0];
  for (std::size_t i = 0; i < halves[0].data.size(); ++i)
    reference_.picture.data[i] = 0.5f * (halves[0].data[i] + halves[1].data[i]);
  reference_of_ = id;
  return reference_;
}

double relative_rmse(const Image& picture, const Image& reference) {
  const ErrorFigures e = compare_images(picture, reference);
  if (!e.relative_rmse) throw Error("benchmark", "a picture has no light to compare");
  return *e.relative_rmse;
}

double error_against(const Image& picture, const Reference& reference) {
  const double e = relative_rmse(picture, reference.picture);
  return std::sqrt(std::max(e * e - reference.noise * reference.noise, 0.01 * e * e));
}

std::vector<Case> quality_cases(const Options& options) {
  std::vector<Case> cases{
      {.name = "cockpit/driver", .scene = "builtin:cockpit", .camera = "driver"},
      {.name = "cockpit/door", .scene = "builtin:cockpit", .camera = "door"},
      {.name = "plate", .scene = "builtin:plate"},
      {.name = "sphere/matte",
       .scene = "builtin:sphere",
       .material = "builtin:matte-white",
       .width = 512,
       .height = 512},
      {.name = "sphere/paint",
       .scene = "builtin:sphere",
       .material = "builtin:paint-red-metallic",
       .width = 512,
       .height = 512},
      {.name = "sphere/chrome",
       .scene = "builtin:sphere",
       .material = "builtin:metal-chrome",
       .width = 512,
       .height = 512},
  };
  if (!options.data.empty()) cases.push_back({.name = "ferrari", .scene = options.data + "/scenes/ferrari458.glb"});
  return cases;
}

std::vector<std::string> expand_tables(const Options& options, const std::vector<std::string>& names) {
  const fs::path folder = fs::path(options.scratch) / "measured";
  fs::create_directories(folder);
  std::vector<std::string> paths;
  std::string command = "'" + options.data + "/../tools/expand-measured' '" + folder.string() + "'";
  bool missing = false;
  for (const std::string& name : names) {
    paths.push_back((folder / (name + ".binary")).string());
    if (fs::exists(paths.back())) continue;
    missing = true;
    command += " " + name;
  }
  if (missing && std::system((command + " > /dev/null").c_str()) != 0)
    throw Error(options.data, "measured tables could not be expanded", "install python3-numpy");
  return paths;
}

std::vector<Case> research_cases(const Options& options) {
  std::vector<Case> cases;
  if (options.data.empty()) return cases;
  const std::vector<std::string> names{"gold-metallic-paint", "color-changing-paint3", "teflon", "chrome-steel"};
  const std::vector<std::string> tables = expand_tables(options, names);
  for (std::size_t i = 0; i < names.size(); ++i)
    cases.push_back({.name = "grace/" + names[i],
                     .scene = "builtin:sphere",
                     .material = tables[i],
                     .environment = options.data + "/environments/grace_latlong.exr",
                     .width = 512,
                     .height = 512});
  return cases;
}

}  // namespace maquette::bench
