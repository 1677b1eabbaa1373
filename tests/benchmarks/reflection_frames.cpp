// Reflector techniques in whole frames: the time that they add, how it grows with the scene, and how far reflected
// outlines are from those of `raytraced`.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "render/metrics/metrics.h"
#include "render/octree/octree_kind.h"
#include "render/technique/registry.h"
#include "scenes/error.h"
#include "scenes/luminance.h"
#include "tests/benchmarks/stage.h"
#include "tests/support/local_bandwidth.h"
#include "viewer/report/charts.h"

namespace maquette::bench {

namespace {

const Case kDriver{.name = "cockpit/driver", .scene = "builtin:cockpit", .camera = "driver"};
constexpr const char* kReference = "raytraced";
constexpr const char* kMode = "splitsum";  // without noise

FrameRequest request_of(const Stage& stage, const std::string& technique, const std::string& resolution) {
  FrameRequest r = stage.request(kMode, 0);
  r.reflections = technique;
  r.settings.set("reflections.resolution", resolution);
  return r;
}

constexpr double kSlow_ms = 1000.0;  // slower frames are timed once

/// Median times of a frame with each technique less those of a frame without, interleaved. The eye moves, so that
/// nothing of the frame before is reused. Throws where a technique drew nothing.
std::vector<Clock> added_times(Renderer* renderer, const std::vector<FrameRequest>& requests, int repeats) {
  std::vector<std::vector<double>> wall(requests.size()), cpu(requests.size());
  const auto time = [&](FrameRequest r, int round) {
    // Background work, and new targets after a change of technique: only the frame after that is timed.
    renderer->finish_background_work(r);
    renderer->render(r);
    r.camera.eye.x += 1e-4f * static_cast<float>(round + 1);
    const Clock begin = now();
    const FrameStats stats = renderer->render(r);
    const Clock taken = now() - begin;
    for (const LeftOut& left_out : stats.plan.left_out)
      if (left_out.what == "reflections" && r.reflections != "off")
        throw Error("reflection-frames", r.reflections + " drew nothing: " + left_out.why);
    return taken;
  };
  for (int round = 0; round < repeats; ++round) {
    for (std::size_t i = 0; i < requests.size(); ++i) {
      if (round > 0 && wall[i].front() > kSlow_ms) continue;
      FrameRequest plain = requests[i];
      plain.reflections = "off";
      if (round == 0) {  // a driver compiles programs when they are first drawn with
        time(requests[i], -2);
        time(plain, -2);
      }
      const Clock with = time(requests[i], round), without = time(plain, round);
      const Clock added = with - without;
      wall[i].push_back(added.wall_ms);
      cpu[i].push_back(added.cpu_ms);
    }
  }
  std::vector<Clock> medians;
  for (std::size_t i = 0; i < requests.size(); ++i) medians.push_back({test::median(wall[i]), test::median(cpu[i])});
  return medians;
}

std::string added_text(const Clock& t) { return number(t.wall_ms) + " ms (CPU " + number(t.cpu_ms) + " ms)"; }

/// Brightness ratio of an outline, and the lower ratio of a possible counterpart: where one picture has 2.05 and the
/// other 1.95, the nearest outline of 2 is not the same edge. Source: Canny 1986, "A Computational Approach to Edge
/// Detection", Sec. VI-D (thresholding with hysteresis).
constexpr float kStrong = 2.0f, kWeak = 1.5f;

/// Outlines of reflections: pixels of a reflector whose brightness differs from the neighbour on the right or below by
/// such a ratio.
std::vector<glm::ivec2> outline(const Image& reflection, float ratio = kStrong) {
  const auto differs = [&](int x, int y, int x2, int y2) {
    if (!(reflection.at(x, y, 3) > 0.0f && reflection.at(x2, y2, 3) > 0.0f)) return false;
    const double a = luminance(reflection, x, y), b = luminance(reflection, x2, y2);
    return std::max(a, b) > static_cast<double>(ratio) * std::min(a, b);
  };
  std::vector<glm::ivec2> pixels;
  for (int y = 0; y + 1 < reflection.height; ++y)
    for (int x = 0; x + 1 < reflection.width; ++x)
      if (differs(x, y, x + 1, y) || differs(x, y, x, y + 1)) pixels.emplace_back(x, y);
  return pixels;
}

struct Distances {
  double mean = 0.0, most = 0.0;
  std::size_t beyond = 0;    ///< number of outlines beyond their bound
  std::size_t unpaired = 0;  ///< of these, without a weak outline within the bound
  double mean_px = 0.0;      ///< of the bounds
  glm::ivec2 worst{0, 0};    ///< pixel that is farthest beyond its bound
};
/// The outlines of one picture.
struct Outlines {
  std::vector<glm::ivec2> strong, weak;
};
Outlines outlines_of(const Image& reflection) { return {outline(reflection), outline(reflection, kWeak)}; }

double nearest_px(const glm::ivec2& a, const std::vector<glm::ivec2>& to) {
  long nearest = std::numeric_limits<long>::max();
  for (const glm::ivec2& b : to) {
    const long x = a.x - b.x, y = a.y - b.y;
    nearest = std::min(nearest, x * x + y * y);
  }
  return std::sqrt(static_cast<double>(nearest));
}

/// Distance from each strong outline of `from` to the nearest of `to`, in pixels.
Distances distances(const Outlines& from, const Outlines& to, const std::function<double(glm::ivec2)>& bound_px) {
  Distances d;
  double farthest_beyond = -std::numeric_limits<double>::max();
  for (const glm::ivec2& a : from.strong) {
    const double pixels = nearest_px(a, to.strong);
    const double bound = bound_px(a), share = 1.0 / static_cast<double>(from.strong.size());
    d.mean += pixels * share;
    d.most = std::max(d.most, pixels);
    d.mean_px += bound * share;
    d.beyond += pixels > bound;
    d.unpaired += pixels > bound && nearest_px(a, to.weak) > bound;
    if (pixels - bound > farthest_beyond) d.worst = a;
    farthest_beyond = std::max(farthest_beyond, pixels - bound);
  }
  return d;
}

std::string distances_text(const Distances& d) {
  return "mean " + number(d.mean) + ", at most " + number(d.most) + "; " + std::to_string(d.beyond) +
         " beyond their bound, " + std::to_string(d.unpaired) + " of them without a weak one in it, " +
         number(d.mean_px) + " in the mean; worst at " + std::to_string(d.worst.x) + ", " + std::to_string(d.worst.y);
}

/// Side of the finest cells, m.
double cell_side_m(const Scene& scene, int depth) {
  const OctreeJob job = make_octree_job(scene, scene.materials, -1, depth);
  const OctreeGrid grid =
      compute_octree_grid({job.geometry, job.materials, job.transmits, *job.textures}, job.options, nullptr);
  return grid.side_m / std::exp2(grid.depth - grid.detail);
}

Figures measure_outlines(Stage& stage) {
  Case large = kDriver;
  large.width = 1280;
  large.height = 720;
  stage.show(large);
  const auto outline_of = [&](const std::string& technique, Image* distance_m) {
    const FrameRequest request = request_of(stage, technique, "full");
    stage.renderer().finish_background_work(request);
    stage.renderer().render(request);
    *distance_m = stage.renderer().read_debug_view("reflection_distance");
    return outlines_of(stage.renderer().read_debug_view("reflection"));
  };
  Image expected_m, measured_m;
  const Outlines expected = outline_of(kReference, &expected_m);
  const FrameRequest reference = request_of(stage, kReference, "full");
  const double cell_m = cell_side_m(stage.renderer().scene(), reference.settings.get_int("octree.depth"));
  const double px_rad = 2.0 * std::tan(0.5 * static_cast<double>(reference.camera.fov_y_rad)) / large.height;
  // The size of a cell's diagonal as seen in a flat pane. The nearest of the pixels at the edge counts, because behind
  // it may be the sky.
  const auto cell_px = [&](const Image& distance_m, glm::ivec2 at) {
    double nearest_m = std::numeric_limits<double>::max();
    for (const glm::ivec2& p : {at, at + glm::ivec2(1, 0), at + glm::ivec2(0, 1)}) {
      const auto m = static_cast<double>(distance_m.at(p.x, p.y, 0));
      if (m > 0.0) nearest_m = std::min(nearest_m, m);
    }
    return std::sqrt(3.0) * cell_m / nearest_m / px_rad;
  };
  Figures figures;
  for (const std::string& technique : builtin_registry().names(TechniqueKind::reflector)) {
    if (technique == kReference) continue;
    const std::string name = "reflected outlines, " + technique + ", 1280 x 720";
    const bool cells = technique == "octree";
    const std::string target = cells ? "2 pixels and a cell" : "1 pixel, 3 at most";
    const Outlines measured = outline_of(technique, &measured_m);
    if (expected.strong.empty() || measured.strong.empty()) {
      figures.push_back(absent(name, target, "no outline is seen"));
      continue;
    }
    const auto bound_of = [&](const Image& distance_m) {
      return [&](glm::ivec2 at) { return cells ? 2.0 + cell_px(distance_m, at) : 3.0; };
    };
    const Distances lost = distances(expected, measured, bound_of(expected_m)),
                    extra = distances(measured, expected, bound_of(measured_m));
    const bool met = cells ? lost.unpaired + extra.unpaired == 0
                           : lost.beyond + extra.beyond == 0 && std::max(lost.mean, extra.mean) <= 1.0;
    figures.push_back(judged(name, target,
                             "lost, of " + std::to_string(expected.strong.size()) + " pixels: " + distances_text(lost) +
                                 "; extra, of " + std::to_string(measured.strong.size()) +
                                 " pixels: " + distances_text(extra),
                             met));
  }
  return figures;
}

/// The same in a part with fitted patches: the driver's side glass, seen from the seat. Hatched pixels (low confidence)
/// are left out.
Figures measure_fitted_outlines(Stage& stage) {
  Case large = kDriver;
  large.width = 1280;
  large.height = 720;
  stage.show(large);
  FrameRequest request = request_of(stage, kReference, "full");
  request.reflectors = {"side_glass_left"};
  request.camera.eye = {0.37f, 1.13f, -0.05f};
  request.camera.target = {1.0f, 1.05f, 0.2f};
  request.camera.fov_y_rad = 0.87f;
  request.settings.set_from_text("reflections.mark", "none");
  const auto draw = [&](const char* technique) {
    request.reflections = technique;
    stage.renderer().finish_background_work(request);
    return stage.renderer().render(request);
  };
  draw("raytraced");
  const Outlines reference = outlines_of(stage.renderer().read_debug_view("reflection"));
  const FrameStats stats = draw("bezier");
  const Image uncertain = stage.renderer().read_debug_view("reflection_doubt");
  const auto vouched = [&](Outlines outlines) {
    std::erase_if(outlines.strong, [&](const glm::ivec2& p) { return uncertain.at(p.x, p.y, 0) > 0.0f; });
    return outlines;
  };
  const Outlines all = outlines_of(stage.renderer().read_debug_view("reflection"));
  const Outlines expected = vouched(reference), measured = vouched(all);
  const auto bound = [](glm::ivec2) { return 3.0; };
  const Distances lost = distances(expected, all, bound), extra = distances(measured, reference, bound);
  const std::string name = "reflected outlines, bezier, fitted side glass, 1280 x 720";
  if (expected.strong.empty() || measured.strong.empty())
    return {absent(name, "1 pixel, 3 at most", "no outline is seen")};
  return {judged(name, "1 pixel, 3 at most",
                 "lost, of " + std::to_string(expected.strong.size()) + " pixels: " + distances_text(lost) +
                     "; extra, of " + std::to_string(measured.strong.size()) + " pixels: " + distances_text(extra) +
                     "; " + number(stats.technique.at("fitted_patches")) + " patches, " +
                     number(stats.technique.at("fit_error_mm")) + " mm off, " +
                     number(stats.technique.at("uncertain_pixels")) + " pixels hatched",
                 lost.beyond == 0 && extra.beyond == 0 && std::max(lost.mean, extra.mean) <= 1.0)};
}

/// Frame times by depth of the octree and resolution, as in Table 11.1 of the method.
Figures measure_octree_table(Stage& stage) {
  stage.show(kDriver);
  Figures figures;
  for (int depth = 7; depth <= 9; ++depth) {
    std::vector<FrameRequest> requests;
    for (const char* resolution : {"full", "half", "quarter"}) {
      requests.push_back(request_of(stage, "octree", resolution));
      requests.back().settings.set("octree.depth", depth);
    }
    const std::vector<Clock> times = added_times(&stage.renderer(), requests, stage.options().repeats);
    figures.push_back(shown("octree of depth " + std::to_string(depth) + ", added at full, half, quarter resolution",
                            added_text(times[0]) + ", " + added_text(times[1]) + ", " + added_text(times[2])));
  }
  return figures;
}

Figures measure_added_times(Stage& stage) {
  stage.show(kDriver);
  std::vector<std::string> names;
  std::vector<FrameRequest> requests;
  for (const std::string& technique : builtin_registry().names(TechniqueKind::reflector)) {
    for (const char* resolution : {"full", "half", "quarter"}) {
      names.push_back(technique + " at " + resolution + " resolution");
      requests.push_back(request_of(stage, technique, resolution));
    }
  }
  const std::vector<Clock> times = added_times(&stage.renderer(), requests, stage.options().repeats);
  Figures figures;
  for (std::size_t i = 0; i < names.size(); ++i)
    figures.push_back(
        judged("cockpit 640 x 360, added by " + names[i], "40 ms", added_text(times[i]), times[i].wall_ms <= 40.0));
  return figures;
}

/// The cockpit's windshield over a rough board of about `triangles` triangles, seen from the driver's eye.
std::shared_ptr<Scene> board_under_windshield(const Scene& cockpit, int triangles) {
  const auto scene = std::make_shared<Scene>();
  scene->name = "board of " + std::to_string(triangles) + " triangles";
  const auto pane =
      std::find_if(cockpit.nodes.begin(), cockpit.nodes.end(), [](const Node& n) { return n.patch >= 0; });
  const auto index = static_cast<std::size_t>(pane - cockpit.nodes.begin());
  scene->patches.push_back(cockpit.patches[static_cast<std::size_t>(pane->patch)]);
  scene->patches[0].reflector = true;
  scene->materials.push_back(cockpit.materials[static_cast<std::size_t>(scene->patches[0].material)]);
  scene->patches[0].material = 0;
  scene->materials.emplace_back();
  scene->materials.back().base_color = glm::vec4(0.6f, 0.3f, 0.1f, 1.0f);
  const glm::mat4 world = compute_world_transforms(cockpit)[index];
  Bounds bounds;
  for (const glm::vec3& p : scene->patches[0].points) {
    const glm::vec3 at(world * glm::vec4(p, 1.0f));
    bounds.min = glm::min(bounds.min, at);
    bounds.max = glm::max(bounds.max, at);
  }
  const int side = static_cast<int>(std::lround(std::sqrt(0.5 * triangles)));
  Primitive board;
  board.material = 1;
  for (int row = 0; row <= side; ++row) {
    for (int column = 0; column <= side; ++column) {
      const float u = static_cast<float>(column) / static_cast<float>(side),
                  v = static_cast<float>(row) / static_cast<float>(side);
      const float rough = 0.01f * std::sin(60.0f * u) * std::cos(50.0f * v);
      board.positions.emplace_back(glm::mix(bounds.min.x, bounds.max.x, u), bounds.min.y - 0.05f + rough,
                                   glm::mix(bounds.min.z, bounds.max.z, v));
    }
  }
  const auto stride = static_cast<std::uint32_t>(side + 1);
  for (std::uint32_t row = 0; row + 1 < stride; ++row) {
    for (std::uint32_t column = 0; column + 1 < stride; ++column) {
      const std::uint32_t a = row * stride + column, b = a + 1, c = a + stride, d = c + 1;
      board.indices.insert(board.indices.end(), {a, c, d, a, d, b});
    }
  }
  scene->meshes.emplace_back().primitives.push_back(std::move(board));
  scene->nodes.resize(2);
  scene->nodes[0].name = "board";
  scene->nodes[0].mesh = 0;
  scene->nodes[1] = cockpit.nodes[index];
  scene->nodes[1].local = world;
  scene->nodes[1].parent = -1;
  scene->nodes[1].children.clear();
  scene->nodes[1].patch = 0;
  scene->roots = {0, 1};
  return scene;
}

/// Time that a technique adds to a frame, for scenes that differ only in their number of triangles.
struct CostCurve {
  std::string technique;
  std::vector<std::pair<int, double>> points;  ///< triangles, ms
};

std::string cost_script(const std::vector<CostCurve>& curves, const std::string& svg_file) {
  std::string script =
      "set terminal svg size 640,430 dynamic background rgb 'white' font 'Helvetica,Arial,sans-serif,15'\n"
      "set output '" +
      svg_file +
      "'\nset logscale xy\nset border 3\nset grid linecolor rgb '#888888' linewidth 0.4 dashtype 3\n"
      "set key outside bottom center horizontal Left reverse samplen 1.5 height 1\n"
      "set xlabel 'triangles of the scene'\nset ylabel 'added to a frame (ms)'\n"
      "set xtics nomirror ('10,000' 1e4, '100,000' 1e5, '1,000,000' 1e6)\nset xrange [7e3:1.4e6]\n"
      "set ytics nomirror (10, 20, 50, 100, 200, 500, 1000, 2000, 5000)\n";
  std::vector<std::string> names;
  for (const CostCurve& curve : curves) names.push_back(curve.technique);
  std::string plots;
  for (const CostCurve& curve : curves) {
    script += "$" + curve.technique + " << EOD\n";
    for (const auto& [triangles, ms] : curve.points) script += std::to_string(triangles) + " " + number(ms) + "\n";
    script += "EOD\n";
    plots += (plots.empty() ? "plot $" : ", $") + curve.technique +
             " with linespoints pointtype 7 linewidth 2 linecolor rgb '" +
             report::technique_color(names, curve.technique) + "' title '" + curve.technique + "'";
  }
  return script + plots + "\n";
}

Figures measure_scene_sizes(Stage& stage) {
  stage.show(kDriver);
  const Scene cockpit = stage.renderer().scene();
  Renderer renderer;
  renderer.set_environment(std::make_shared<Environment>(load_environment(kDriver.environment)));
  Figures figures;
  std::vector<std::string> names = builtin_registry().names(TechniqueKind::reflector);
  std::vector<CostCurve> curves;
  for (const std::string& name : names) curves.push_back({name, {}});
  for (const int triangles : {10000, 100000, 1000000}) {
    renderer.set_scene(board_under_windshield(cockpit, triangles));
    std::vector<FrameRequest> requests;
    for (const std::string& technique : names) requests.push_back(request_of(stage, technique, "half"));
    const std::vector<Clock> times = added_times(&renderer, requests, stage.options().repeats);
    std::string text;
    std::size_t fastest = 0;
    for (std::size_t i = 0; i < names.size(); ++i) {
      text += (i > 0 ? ", " : "") + names[i] + " " + number(times[i].wall_ms) + " (" + number(times[i].cpu_ms) + ")";
      if (times[i].wall_ms < times[fastest].wall_ms) fastest = i;
      const auto curve =
          std::find_if(curves.begin(), curves.end(), [&](const CostCurve& c) { return c.technique == names[i]; });
      curve->points.emplace_back(triangles, times[i].wall_ms);
    }
    figures.push_back(
        shown("added ms (CPU), " + std::to_string(triangles) + " triangles", text + "; " + names[fastest] + " wins"));
    // A technique that takes seconds is not run with ten times as many triangles.
    for (std::size_t i = names.size(); i-- > 0;)
      if (times[i].wall_ms > kSlow_ms) names.erase(names.begin() + static_cast<std::ptrdiff_t>(i));
  }
  if (!stage.options().charts.empty()) {
    std::string problem;
    const auto svg = report::draw_script(
        "reflection-cost", stage.options().charts,
        [&](const std::string& svg_file) { return cost_script(curves, svg_file); }, &problem);
    figures.push_back(svg ? shown("chart", stage.options().charts + "/reflection-cost.svg")
                          : absent("chart", "", problem));
  }
  return figures;
}

/// Time that glossy opaque surfaces add to a frame of the default mode, at default settings.
Figures measure_glossy(Stage& stage) {
  Figures figures;
  for (const char* camera : {"driver", "door"}) {
    stage.show({.name = std::string("cockpit/") + camera, .scene = "builtin:cockpit", .camera = camera});
    FrameRequest with = stage.request("bandwidth", 0);
    with.reflections = "octree";
    with.settings.set_from_text("shading.visibility", "auto");
    FrameRequest without = with;
    without.settings.set("reflections.glossy", 0.0);
    const std::vector<Clock> times = added_times(&stage.renderer(), {without, with}, stage.options().repeats);
    stage.renderer().finish_background_work(with);  // frames without reflections release the octree
    const FrameStats stats = stage.renderer().render(with);
    for (const LeftOut& left_out : stats.plan.left_out)
      if (left_out.what == "glossy") throw Error("reflection-frames", "no glossy surface was drawn: " + left_out.why);
    figures.push_back(shown(stage.current().name + ", " + number(stats.technique.at("glossy_rays")) + " glossy rays",
                            added_text(times[1] - times[0]) + " beside " + added_text(times[0]) + " of the panes"));
  }
  return figures;
}

}  // namespace

/// Time that `reflections.skip` saves in the default mode before the bright sky, and the difference of the pictures.
Figures measure_skipping(Stage& stage) {
  stage.show(kDriver);
  Figures figures;
  for (const char* resolution : {"half", "full"}) {
    FrameRequest all = stage.request("bandwidth", 0);
    all.reflections = "octree";
    all.settings.set("reflections.resolution", std::string(resolution));
    all.settings.set_from_text("shading.visibility", "auto");
    FrameRequest some = all;
    some.display = true;
    const std::vector<Clock> times = added_times(&stage.renderer(), {all, some}, stage.options().repeats);
    stage.renderer().finish_background_work(all);  // frames without reflections release the octree
    stage.renderer().render(all);
    Image reference = stage.renderer().read_radiance();
    const FrameStats stats = stage.renderer().render(some);
    Image image = stage.renderer().read_radiance();
    for (std::size_t i = 3; i < image.data.size(); i += 4) image.data[i] = reference.data[i] = 1.0f;  // the sky counts
    const double share = stats.technique.at("rays_skipped_share"),
                 flip = measure_error(image, reference).figures.flip.value();
    figures.push_back(judged(std::string("rays not followed, octree at ") + resolution + " resolution",
                             "30 %, FLIP 0.02",
                             number(100.0 * share) + " %, FLIP " + number(flip) + "; added " + added_text(times[1]) +
                                 " instead of " + added_text(times[0]),
                             share >= 0.3 && flip <= 0.02));
  }
  return figures;
}

Figures measure_reflection_frames(Stage& stage) {
  Figures all;
  const std::pair<const char*, Figures (*)(Stage&)> parts[] = {
      {"added times", measure_added_times},         {"glossy", measure_glossy},
      {"octree table", measure_octree_table},       {"outlines", measure_outlines},
      {"fitted-outlines", measure_fitted_outlines}, {"scene sizes", measure_scene_sizes}};
  for (const auto& [name, measure] : parts) {
    if (!stage.options().wants(name)) continue;
    const Figures some = measure(stage);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

}  // namespace maquette::bench
