// What surface light fields rest on, and what processes that share a bake gain.
#include "tests/benchmarks/slf_checks.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "render/math/low_discrepancy.h"
#include "render/reference/path_sampler.h"
#include "render/reference/path_scene.h"
#include "render/slf/light_field.h"
#include "scenes/brdf.h"
#include "tests/support/small_sun.h"
#include "tests/support/test_scenes.h"

namespace maquette::bench {
namespace {

constexpr int kSuns = 200;
constexpr std::size_t kTexelsOfLibrary = 512;

Figure check_sun() {
  double worst = 0.0;
  for (int trial = 0; trial < kSuns; ++trial) worst = std::max(worst, std::abs(test::sun_irradiance_error(trial)));
  return judged("irradiance of a sun of 0.27 degrees, 200 directions, edges of bins and the rim among them", "<= 1 %",
                percent(worst) + " at most", worst <= 0.01);
}

Figure check_convex_body(Stage& stage) {
  const glm::vec3 albedo(0.8f, 0.5f, 0.2f), sky(2.0f, 3.0f, 4.0f);
  Renderer& renderer = stage.renderer();
  renderer.set_scene(std::make_shared<Scene>(test::sphere_of(test::matte(albedo))));
  renderer.set_environment(test::constant_sky(sky));
  FrameRequest r;
  r.mode = "slf";
  r.width = 160, r.height = 120;
  r.camera.eye = {0.3f, 0.4f, 4.0f};
  r.camera.fov_y_rad = 0.5f;
  r.settings.set("slf.texels", 64);
  renderer.finish_background_work(r);
  renderer.render(r);
  const Image picture = renderer.read_radiance();
  double worst = 0.0;
  for (int y = 0; y < r.height; ++y)
    for (int x = 0; x < r.width; ++x)
      for (int c = 0; c < 3 && picture.at(x, y, 3) == 1.0f; ++c)
        worst = std::max(worst, std::abs(static_cast<double>(picture.at(x, y, c) / (albedo[c] * sky[c])) - 1.0));
  return judged("a convex body under a constant sky, 128 x 8: albedo times radiance", "<= 0.5 %",
                percent(worst) + " at most", worst <= 0.005);
}

/// One texel in a box with a lamp against paths of the tracer in directions that are drawn here.
Figure check_tracer() {
  Scene scene = test::box_scene(6, 2, test::matte({0.6f, 0.5f, 0.4f}));
  Material glow = test::matte(glm::vec3(0.0f));
  glow.emissive = glm::vec3(10.0f);
  scene.materials.push_back(glow);
  test::add(&scene, test::make_grid({-0.4f, 0.98f, -0.4f}, {0.8f, 0, 0}, {0, 0, 0.8f}, 1, 1), "lamp");
  const auto traced = build_path_scene({.scene = scene, .environment = test::constant_sky(0.0f)});
  const auto atlas = std::make_shared<LightFieldAtlas>(make_atlas(traced->geometry, {{0, false}}, {.side = 32}));
  const std::size_t t = atlas->texels.size() / 2 + 7;
  const IncidentTracer tracer(traced, atlas, {.paths = 1024});
  const Lumisphere& sphere = tracer.lumisphere();
  std::vector<float> bins(static_cast<std::size_t>(3 * sphere.count()));
  tracer.trace(t, bins);
  const TexelFrame frame = frame_of_texel(traced->geometry, *atlas, t);
  double squares = 0.0;
  int count = 0;
  for (int b = 0; b < sphere.count(); ++b) {
    constexpr std::uint32_t kPaths = 1024;
    double sum = 0.0, sum2 = 0.0;
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      const std::uint32_t seed = 7u + static_cast<std::uint32_t>(b);
      const Lumisphere::Sample d = sphere.draw(b, PathSampler{99u + static_cast<std::uint32_t>(b), i}.pair(5));
      const double v =
          d.weight > 0.0f
              ? static_cast<double>(
                    d.weight * estimate_radiance(*traced, {}, frame.origin, frame.to_world(d.direction), seed, i).y)
              : 0.0;
      sum += v, sum2 += v * v;
    }
    const double mean = sum / kPaths, variance = std::max(sum2 / kPaths - mean * mean, 0.0) / kPaths;
    if (!(variance > 0.0)) continue;
    const double off = static_cast<double>(bins[3 * static_cast<std::size_t>(b) + 1]) - mean;
    squares += off * off / (2.0 * variance);  // both have noise
    ++count;
  }
  const double deviations = std::sqrt(squares / std::max(count, 1));
  return judged("a texel's lumisphere against the plain tracer, RMS over bins", "<= 1.2 standard deviations of noise",
                number(deviations) + " over " + std::to_string(count) + " bins", deviations <= 1.2);
}

}  // namespace

Figures check_incident_light(Stage& stage) { return {check_sun(), check_convex_body(stage), check_tracer()}; }

Figures check_library(const Scene& scene, const IncidentBake& incident) {
  LightFieldAtlas atlas = incident.atlas;
  IncidentField light;
  light.side = incident.field.side;
  light.bins = incident.field.bins;
  atlas.texels.clear();
  for (std::size_t i = 0; i < kTexelsOfLibrary; ++i) {
    const std::size_t t = i * incident.field.texel_count() / kTexelsOfLibrary;
    if (incident.field.masked[t]) continue;
    atlas.texels.push_back(incident.atlas.texels[t]);
    const auto texel = incident.field.texel(t);
    light.radiance.insert(light.radiance.end(), texel.begin(), texel.end());
  }
  light.masked.assign(atlas.texels.size(), false);
  const std::atomic<bool> never{false};
  const Eigen::VectorXf measure = outgoing_measure(Lumisphere(light.side));
  Figures figures;
  std::string without;
  for (const BuiltinBrdf& brdf : builtin_brdfs()) {
    Scene covered = scene;
    for (Material& m : covered.materials) m.measured = "builtin:" + brdf.name;
    const auto materials = build_path_scene({.scene = covered, .environment = test::constant_sky(0.0f)});
    if (!warn_of_specular(*materials, atlas, light.side).empty()) {
      without += (without.empty() ? "" : ", ") + brdf.name;
      continue;
    }
    const auto bins = compute_outgoing(*materials, atlas, light, {.basis = LightBasis::bins}, never);
    const auto haar = compute_outgoing(*materials, atlas, light, {.basis = LightBasis::haar}, never);
    const double error = field_error(haar->radiance, bins->radiance, measure);
    figures.push_back(
        judged("outgoing light, " + brdf.name + ", haar, " + std::to_string(atlas.texels.size()) + " texels",
               "<= 2 % of bins", percent(error) + ", " + number(haar->coefficients) + " coefficients", error <= 0.02));
  }
  figures.push_back(shown("built-in materials that are said to be too specular", without));
  return figures;
}

Figures measure_ranks(const Options& options) {
  namespace fs = std::filesystem;
  const std::string name = "incident bake under mpirun, T(1 process of one core) / 2 T(2)", target = ">= 0.85";
  if (std::system("mpirun --version >/dev/null 2>&1") != 0) return {absent(name, target, "there is no mpirun")};
  const fs::path folder = fs::path(options.scratch) / "ranks";
  std::vector<double> seconds[2];
  for (int repeat = 0; repeat < options.repeats; ++repeat)
    for (const int ranks : {1, 2}) {
      std::error_code ignored;
      fs::remove_all(folder, ignored);
      const std::string command =
          "mpirun --allow-run-as-root --bind-to core -n " + std::to_string(ranks) + " '" + options.program +
          "' bake slf builtin:seat --set slf.texels=128 --set slf.paths=8 -o '" + folder.string() + "' >/dev/null 2>&1";
      const auto begin = std::chrono::steady_clock::now();
      if (std::system(command.c_str()) != 0) return {absent(name, target, "it failed: " + command)};
      seconds[ranks - 1].push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
  for (std::vector<double>& s : seconds) std::ranges::sort(s);
  const double one = seconds[0][seconds[0].size() / 2], two = seconds[1][seconds[1].size() / 2],
               gain = one / (2.0 * two);
  return {judged(
      name, target,
      number(gain) + ": " + number(one) + " s and " + number(two) + " s, medians of " + std::to_string(options.repeats),
      gain >= 0.85)};
}

}  // namespace maquette::bench
