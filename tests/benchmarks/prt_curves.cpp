// Precomputed radiance transfer of a coarse cloth: the curves and pictures of the thesis' figures 10.8, 10.12 and 10.15
// to 10.17 (seed 001).
#include "tests/benchmarks/prt_curves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numeric>

#include "render/btf/builtin_geometry.h"
#include "render/btf/generate.h"
#include "render/prt/job.h"
#include "render/reference/path_scene.h"
#include "render/reference/reference.h"
#include "render/technique/registry.h"
#include "scenes/btf/btf_file.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "tests/benchmarks/prt_cloth.h"
#include "tests/benchmarks/stage.h"
#include "tests/support/never.h"
#include "tests/support/transfer_reference.h"
#include "viewer/report/charts.h"
#include "viewer/stats.h"

namespace maquette::bench {
namespace {

constexpr int kCurveWidth = 160, kCurveHeight = 120;

struct Curve {
  std::string name;
  std::vector<std::pair<double, double>> points;
};

/// Lines over a logarithmic axis.
std::string curves_script(const std::vector<Curve>& curves, const std::string& x, const std::string& y,
                          const std::string& svg_file) {
  std::string script =
      "set terminal svg size 640,430 dynamic background rgb 'white' font 'Helvetica,Arial,sans-serif,15'\n"
      "set output '" +
      svg_file +
      "'\nset logscale x 2\nset border 3\nset grid linecolor rgb '#888888' linewidth 0.4 dashtype 3\n"
      "set key outside bottom center horizontal Left reverse samplen 1.5 height 1\n"
      "set tics nomirror\nset yrange [0:*]\nset xlabel '" +
      x + "'\nset ylabel '" + y + "'\n";
  std::string plots;
  std::vector<std::string> names;
  for (const Curve& curve : curves) names.push_back(curve.name);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    script += "$curve" + std::to_string(i) + " << EOD\n";
    for (const auto& [at, value] : curves[i].points) script += number(at) + " " + number(value) + "\n";
    script += "EOD\n";
    plots += (i == 0 ? "plot $curve" : ", $curve") + std::to_string(i) +
             " with linespoints pointtype 7 linewidth 2 linecolor rgb '" +
             report::technique_color(names, curves[i].name) + "' title '" + curves[i].name + "'";
  }
  return script + plots + "\n";
}

class ClothBench {
 public:
  explicit ClothBench(Stage& stage) : stage_(stage) {
    const std::string& data = stage.options().data;
    sky_ = std::make_shared<const Environment>(
        load_environment(data.empty() ? "builtin:clear-sky" : data + "/environments/autoshop_01_1k.hdr"));
    stage_.renderer().set_environment(sky_);
    camera_.eye = {0.5f, 0.75f, 0.9f};
    camera_.target = {0.0f, 0.08f, 0.0f};
    camera_.fov_y_rad = 0.62f;
  }

  Figures measure() {
    // On leather, or as `--case "on knit@64"` says.
    std::string under = "leather";
    for (const std::string& only : stage_.options().only)
      if (only.starts_with("on ")) under = only.substr(3);
    if (std::ranges::any_of(
            std::array{"compression", "light", "resolution", "components", "forms", "bounces", "popping"},
            [&](const char* part) { return wanted(part); }))
      cover(under);
    if (wanted("compression")) measure_compression();
    if (wanted("light")) measure_light();
    if (wanted("resolution")) measure_light_resolution();
    if (wanted("components")) measure_components();
    measure_forms();
    measure_bounces();
    if (wanted("popping")) measure_popping();
    measure_covers();
    measure_directions();
    return std::move(figures_);
  }

 private:
  void cover(const std::string& name) {
    cover_ = name;
    scene_ = cloth_covered("builtin:btf-" + name);
    stage_.renderer().set_scene(scene_);
  }

  Settings settings(int faces = 16, int components = 6) const {
    Settings s;
    s.set("prt.faces", faces);
    s.set("prt.components", components);
    // As many components for every cover; --set prt.btf_error chooses by the error.
    s.set("prt.btf_components", 2);
    s.set("prt.btf_error", 0.0);
    s.set("shading.visibility", std::string("none"));
    for (const auto& [name, value] : stage_.options().settings) s.set_from_text(name, value);
    s.set("prt.bake", (std::filesystem::path(stage_.options().scratch) /
                       ("prt-cloth-" + cover_ + "-" + std::to_string(s.get_int("prt.faces")) + "-" +
                        std::to_string(s.get_int("prt.components"))))
                          .string());
    return s;
  }

  /// Bakes what is not there yet. Returns the seconds that it took, or its load.
  double bake(const Settings& s) const {
    if (stage_.options().fresh) std::filesystem::remove_all(s.get_string("prt.bake"));
    const Clock begin = now();
    builtin_registry().find_bake("prt").run(
        {*scene_, -1, s, {}, s.get_string("prt.bake")},
        {kNever, [](const std::string&, double) {},
         [&](const std::string& line) { report_ = line.substr(line.find(": ") + 2); }});
    return 1e-3 * (now() - begin).wall_ms;
  }

  FrameRequest request(const Settings& s, int coefficients) const {
    FrameRequest r;
    r.mode = "prt";
    r.width = kCurveWidth;
    r.height = kCurveHeight;
    r.camera = camera_;
    r.settings = s;
    r.settings.set("prt.coefficients", coefficients);
    return r;
  }

  Image draw(const FrameRequest& r) const {
    stage_.renderer().finish_background_work(r);
    stage_.renderer().render(r);
    return stage_.renderer().read_radiance();
  }

  /// Plain sums with components of the BTF under a light cube.
  Image reference(int faces, int components = 2) const {
    const auto traced = build_path_scene({.scene = *scene_, .environment = sky_});
    const CubeDirections cube(faces);
    const int rays = faces > 16 ? 1 : settings().get_int("prt.rays");
    return test::trace_transfer_reference(
        {*traced, cube, CubePyramid(*sky_).resample(cube, environment_rotation(0.0)), rays, components}, camera_,
        kCurveWidth, kCurveHeight);
  }

  /// Figure 10.8: principal components of all vertices against those of clusters, at equal counts.
  void measure_compression() {
    MeasuredLibrary library;
    const TransferJob job = make_transfer_job(
        {scene_, std::make_shared<const FlatGeometry>(flatten(*scene_)), -1, {}, settings()}, {}, &library);
    const TransferMesh mesh = make_transfer_mesh(*job.geometry, job.parts, 0);
    const CubeDirections cube(16);
    const ArrivingLight arriving =
        trace_arriving_light(mesh, cube, build_ray_scene(*job.geometry, job.occluding), {2}, kNever);
    const Btf& btf = *job.materials[0];
    const BtfView& view = btf.views[btf.views.size() / 2];
    const LightTable table(arriving, vertices_of_groups(mesh, 1)[0], view.lights);
    const Eigen::MatrixXf transfer = table.transfer(cube.count(), view.light_weights, btf.components, 0);
    std::vector<Curve> curves;
    for (const int clusters : {1, 8, 32, 128}) {
      Curve curve{clusters == 1 ? "PCA" : std::to_string(clusters) + " clusters", {}};
      std::string text;
      for (const int components : {1, 2, 4, 6, 8, 16}) {
        const double e = factorise_transfer(transfer, cube, {.clusters = clusters, .components = components}).error;
        curve.points.emplace_back(components, 100.0 * e);
        text += (text.empty() ? "" : ", ") + std::to_string(components) + ": " + percent(e);
      }
      figures_.push_back(shown("10.8, error of the transfer by components, " + curve.name, text));
      curves.push_back(std::move(curve));
    }
    figures_.push_back(shown(
        "cloth", std::to_string(mesh.vertices.size()) + " vertices, " + std::to_string(btf.views.size()) + " views"));
    chart("10-08-compression", curves, "components", "error of the transfer (%)");
  }

  /// Figure 10.12: the largest Haar coefficients of the light against the first ones of each face.
  void measure_light() {
    constexpr int kFaces = 16, kPerFace = kFaces * kFaces;
    const CubeLight light = haar_light(CubePyramid(*sky_), CubeDirections(kFaces), environment_rotation(0.0));
    const auto n = static_cast<std::size_t>(light.rows());
    const std::vector<float> equal(n, 1.0f);
    Curve largest{"largest", {}}, first{"first of each face", {}};
    std::string text;
    std::vector<Image> pictures{picture_of_light(light, kFaces)};
    for (const int count : {1, 4, 16, 64, 128, 256}) {
      KeptLight kept = choose_coefficients(light, equal, static_cast<std::size_t>(6 * count));
      for (std::size_t k = 0; k < kept.coefficients.size(); ++k)  // whole, as in the thesis: a still light does not pop
        for (int c = 0; c < 3; ++c) kept.values[k][c] = light(kept.coefficients[k], c);
      KeptLight coarse;
      for (std::uint32_t i = 0; i < n; ++i)
        if (static_cast<int>(i % kPerFace) < count) {
          coarse.coefficients.push_back(i);
          coarse.values.emplace_back(light(i, 0), light(i, 1), light(i, 2));
        }
      largest.points.emplace_back(count, 100.0 * lost(light, kept));
      first.points.emplace_back(count, 100.0 * lost(light, coarse));
      text += (text.empty() ? "" : ", ") + std::to_string(count) + ": " + number(largest.points.back().second) + " / " +
              number(first.points.back().second) + " %";
      CubeLight shown_light = CubeLight::Zero(light.rows(), 3);
      for (std::size_t k = 0; k < kept.coefficients.size(); ++k)
        for (int c = 0; c < 3; ++c) shown_light(kept.coefficients[k], c) = kept.values[k][c];
      if (count >= 4 && count < 256) pictures.push_back(picture_of_light(shown_light, kFaces));
    }
    figures_.push_back(shown("10.12, error of the light by coefficients a face: largest / first", text));
    chart("10-12-light", {largest, first}, "coefficients a face", "error of the light (%)");
    save("10-12-light-all-4-16-64-128", pictures);
  }

  static double lost(const CubeLight& light, const KeptLight& kept) {
    double rest = light.cast<double>().squaredNorm();
    const double all = rest;
    for (const glm::vec3& v : kept.values) rest -= static_cast<double>(glm::dot(v, v));
    return std::sqrt(std::max(rest, 0.0) / all);
  }

  /// The faces side by side, each texel a block of pixels.
  static Image picture_of_light(CubeLight haar, int side) {
    constexpr int kBlock = 4;
    for (int c = 0; c < 3; ++c) inverse_haar_faces(side, haar.col(c).data());
    Image picture(6 * side * kBlock, side * kBlock, 3);
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x) {
        const int face = x / (side * kBlock), column = x / kBlock % side;
        for (int c = 0; c < 3; ++c) picture.at(x, y, c) = haar((face * side + y / kBlock) * side + column, c);
      }
    return picture;
  }

  /// Figure 10.16: the resolution of the light, with as many coefficients as the thesis takes.
  void measure_light_resolution() {
    const Image truth = reference(32);
    Curve curve{"against 6 x 32 x 32", {}};
    std::string text;
    std::vector<Image> pictures{truth};
    struct Step {
      int faces, coefficients;
    };
    for (const auto& [faces, coefficients] : {Step{16, 64}, Step{8, 40}, Step{4, 16}}) {
      const Settings s = settings(faces);
      const double seconds = bake(s);
      pictures.push_back(draw(request(s, coefficients)));
      const double e = error_of_covered(pictures.back(), truth);
      curve.points.emplace_back(faces, 100.0 * e);
      text += (text.empty() ? "" : ", ") + std::to_string(faces) + " (" + std::to_string(coefficients) +
              "): " + percent(e) + " in " + number(seconds) + " s";
    }
    figures_.push_back(shown("10.16, error by side of a face (coefficients), and bake or load", text));
    chart("10-16-light-resolution", {curve}, "side of a face", "error of the picture (%)");
    save("10-16-reference-16-8-4", pictures);
  }

  /// Figure 10.17: components of the transfer.
  void measure_components() {
    const Image truth = reference(settings().get_int("prt.faces"));
    Curve curve{"64 coefficients", {}};
    std::string text;
    std::vector<Image> pictures{truth};
    for (const int components : {1, 2, 4, 6}) {
      const Settings s = settings(16, components);
      bake(s);
      FrameRequest r = request(s, 64);
      pictures.push_back(draw(r));
      const double e = error_of_covered(pictures.back(), truth);
      curve.points.emplace_back(components, 100.0 * e);
      const Turning turning = turn(r);
      text += (text.empty() ? "" : "; ") + std::to_string(components) + ": " + percent(e) + ", update " +
              number(turning.update_ms) + " ms, frame " + number(turning.frame_ms) + " ms";
    }
    figures_.push_back(shown("10.17, by components of the transfer, light turning at 640 x 360", text));
    chart("10-17-components", {curve}, "components", "error of the picture (%)");
    save("10-17-reference-1-2-4-6", pictures);
  }

  struct Turning {
    double update_ms = 0.0, frame_ms = 0.0, vertex_bytes = 0.0, gpu_mb = 0.0;
  };
  /// Medians while the light turns at 640 x 360.
  Turning turn(FrameRequest r) const {
    r.width = 640;
    r.height = 360;
    std::vector<double> frames, updates;
    Turning turning;
    for (int i = 0; i < 15; ++i) {
      r.env_rotation_rad = 0.02f * static_cast<float>(i);
      const FrameStats stats = stage_.renderer().render(r);
      frames.push_back(stats.frame_ms);
      updates.push_back(stats.technique.at("light_update_ms"));
      turning.vertex_bytes = stats.technique.at("prt_vertex_bytes");
      turning.gpu_mb = 1e-6 * static_cast<double>(stats.gpu_bytes.at("prt"));
    }
    turning.update_ms = median(updates);
    turning.frame_ms = median(frames);
    return turning;
  }

  /// Section 10.2.6: all views in one factorisation, against plain sums with all components of the BTF.
  void measure_forms() {
    if (!wanted("forms")) return;
    const Image truth = reference(settings().get_int("prt.faces"), kMostBtfComponents);
    struct Form {
      const char* form;
      int btf_components, texel_clusters, clusters, components;
    };
    std::vector<Image> pictures{truth};
    for (const Form& f : {Form{"views", 2, 0, 32, 6}, Form{"views", 4, 0, 32, 6}, Form{"joint", 2, 4, 8, 6},
                          Form{"joint", 2, 8, 8, 6}, Form{"joint", 2, 8, 16, 6}, Form{"joint", 3, 8, 8, 6}}) {
      Settings s = settings(16, f.components);
      s.set("prt.form", std::string(f.form));
      s.set("prt.btf_components", f.btf_components);
      if (f.texel_clusters > 0) {
        s.set("prt.texel_clusters", f.texel_clusters);
        s.set("prt.joint_clusters", f.clusters);
      }
      const std::string name = std::string(f.form) + ", C_B " + std::to_string(f.btf_components) +
                               (f.texel_clusters > 0 ? ", k_B " + std::to_string(f.texel_clusters) : "") + ", " +
                               std::to_string(f.clusters) + " clusters";
      std::string folder = s.get_string("prt.bake") + "-" + name;
      std::replace(folder.begin(), folder.end(), ' ', '_');
      s.set("prt.bake", folder);
      const double seconds = bake(s);
      const Image picture = draw(request(s, 64));
      const Turning turning = turn(request(s, 20));
      figures_.push_back(
          shown("form " + name, percent(error_of_covered(picture, truth)) + ", " + number(turning.vertex_bytes) +
                                    " bytes a vertex, " + number(turning.gpu_mb) + " MB on the GPU, update " +
                                    number(turning.update_ms) + " ms, frame " + number(turning.frame_ms) +
                                    " ms; bake or load " + number(seconds) + " s: " + report_));
      pictures.push_back(picture);
    }
    save("forms", pictures);
  }

  /// Change of the picture by 0.1 degrees, relative to the change with all coefficients.
  void measure_popping() {
    const Settings s = settings();
    bake(s);
    const auto change = [&](double degrees, int coefficients) {
      FrameRequest r = request(s, coefficients);
      r.env_rotation_rad = glm::radians(static_cast<float>(degrees));
      const Image before = draw(r);
      r.env_rotation_rad = glm::radians(static_cast<float>(degrees + 0.1));
      return error_of_covered(draw(r), before);
    };
    for (const int coefficients : {20, 64, 120}) {
      std::vector<double> ratios;
      for (int i = 0; i < 24; ++i)
        ratios.push_back(change(15.3 * i, coefficients) / std::max(change(15.3 * i, 1024), 1e-12));
      figures_.push_back(
          shown("change by 0.1 degrees, " + std::to_string(coefficients) + " coefficients a face over all",
                "median " + number(median(ratios)) + ", largest of 24 " +
                    number(*std::max_element(ratios.begin(), ratios.end())) + ", error " +
                    percent(error_of_covered(draw(request(s, coefficients)), draw(request(s, 1024))))));
    }
  }

  /// Reflections between folds, against the path tracer with as many.
  void measure_bounces() {
    if (!wanted("bounces")) return;
    const auto traced = build_path_scene({.scene = *scene_, .environment = sky_});
    for (const int bounces : {0, 1, 3}) {
      Settings s = settings(16, 6);
      s.set("prt.bounces", bounces);
      s.set("prt.bake", s.get_string("prt.bake") + "-bounces" + std::to_string(bounces));
      const double seconds = bake(s);
      const Image picture = draw(request(s, 64));
      const PictureRequest p{.camera = camera_,
                             .width = kCurveWidth,
                             .height = kCurveHeight,
                             .seed = 7,
                             .paths = {.max_bounces = 1 + bounces}};
      ReferencePicture tracer(traced, p);
      tracer.add(std::max(64, static_cast<int>(stage_.options().reference_seconds * 8.0)));
      const Image mean = tracer.mean();
      Image traced_picture = picture;
      for (int y = 0; y < kCurveHeight; ++y)
        for (int x = 0; x < kCurveWidth; ++x)
          for (int c = 0; c < 3; ++c) traced_picture.at(x, y, c) = mean.at(x, y, c);
      const Turning turning = turn(request(s, 20));
      figures_.push_back(
          shown("prt.bounces=" + std::to_string(bounces) + " against the path tracer under the whole sky",
                percent(error_of_covered(picture, traced_picture)) + ", update " + number(turning.update_ms) +
                    " ms; bake or load " + number(seconds) + " s: " + report_));
    }
  }

  /// A BTF of 151 x 151 directions.
  void measure_directions() {
    if (!wanted("151")) return;
    const std::string file = (std::filesystem::path(stage_.options().scratch) / "leather-151.exr").string();
    const Clock begin = now();
    if (!std::filesystem::exists(file)) {
      const BuiltinGeometry& leather = *find_builtin_geometry("btf-leather");
      BtfGeneratorOptions options;
      options.texels = 32;
      options.tile_m = leather.tile_m;
      options.views = options.lights = directions_151();
      save_btf(file, generate_btf("leather-151", leather.make(64), options, {}));
    }
    const double made = 1e-3 * (now() - begin).wall_ms;
    cover_ = "leather-151";
    scene_ = cloth_covered(file);
    stage_.renderer().set_scene(scene_);
    const Settings s = settings();
    const double seconds = bake(s);
    const Image picture = draw(request(s, 64));
    const Turning turning = turn(request(s, 20));
    figures_.push_back(
        shown("BTF of 151 x 151 directions", percent(error_of_covered(picture, reference(s.get_int("prt.faces")))) +
                                                 ", " + number(turning.vertex_bytes) + " bytes a vertex, update " +
                                                 number(turning.update_ms) + " ms; made in " + number(made) +
                                                 " s, bake or load " + number(seconds) + " s: " + report_));
    save("151-directions", {picture});
  }
  /// Rings 11 degrees apart, of 1, 6, 12, ... 42 directions, the last ones thinned to make 151.
  static std::vector<glm::dvec3> directions_151() {
    std::vector<glm::dvec3> directions{glm::dvec3(0.0, 0.0, 1.0)};
    for (const auto& [ring, count] : {std::pair(1, 6), std::pair(2, 12), std::pair(3, 18), std::pair(4, 24),
                                      std::pair(5, 28), std::pair(6, 30), std::pair(7, 32)})
      for (int i = 0; i < count; ++i) directions.push_back(direction_of_angles(11.0 * ring, 360.0 * i / count));
    return directions;
  }

  bool wanted(const std::string& part) const { return stage_.options().only.empty() || stage_.options().wants(part); }

  /// Figure 10.15: covers.
  void measure_covers() {
    std::vector<Image> pictures;
    std::string text;
    for (const std::string name : {"leather", "knit@64", "fabric"}) {
      if (!wanted(name)) continue;
      cover(name);
      const Settings s = settings();
      const double seconds = bake(s);
      pictures.push_back(draw(request(s, 64)));
      text += (text.empty() ? "" : ", ") + name + ": " +
              percent(error_of_covered(pictures.back(), reference(s.get_int("prt.faces")))) + " in " + number(seconds) +
              " s";
    }
    figures_.push_back(shown("10.15, error by cover, and bake or load", text));
    save("10-15-covers", pictures);
  }

  void chart(const std::string& name, const std::vector<Curve>& curves, const std::string& x, const std::string& y) {
    const std::string& folder = stage_.options().charts;
    if (folder.empty()) return;
    std::string problem;
    const auto svg = report::draw_script(
        name, folder, [&](const std::string& svg_file) { return curves_script(curves, x, y, svg_file); }, &problem);
    figures_.push_back(svg ? shown("chart", folder + "/" + name + ".svg") : absent("chart", "", problem));
  }

  /// Side by side, without the sky behind them.
  void save(const std::string& name, const std::vector<Image>& pictures) const {
    if (stage_.options().charts.empty() || pictures.empty()) return;
    std::filesystem::create_directories(stage_.options().charts);
    const int width = pictures[0].width, height = pictures[0].height;
    const bool stacked = width > 3 * height;
    const auto count = static_cast<int>(pictures.size());
    Image all(stacked ? width : count * width, stacked ? count * height : height, 3);
    for (int y = 0; y < all.height; ++y)
      for (int x = 0; x < all.width; ++x) {
        const Image& picture = pictures[static_cast<std::size_t>(stacked ? y / height : x / width)];
        const int px = x % width, py = y % height;
        if (picture.channels == 4 && picture.at(px, py, 3) < 1.0f) continue;
        for (int c = 0; c < 3; ++c) all.at(x, y, c) = picture.at(px, py, c);
      }
    save_exr((std::filesystem::path(stage_.options().charts) / (name + ".exr")).string(), all);
  }

  Stage& stage_;
  std::shared_ptr<const Environment> sky_;
  std::shared_ptr<const Scene> scene_;
  std::string cover_;
  mutable std::string report_;  ///< last line of the last bake
  CameraView camera_;
  Figures figures_;
};

}  // namespace

Figures measure_prt_curves(Stage& stage) { return ClothBench(stage).measure(); }

}  // namespace maquette::bench
