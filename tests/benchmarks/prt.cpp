// Precomputed radiance transfer: the seat under a sky that turns, against plain sums and the path tracer.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>

#include "render/prt/buried_vertices.h"
#include "render/prt/job.h"
#include "render/reference/path_scene.h"
#include "render/reference/reference.h"
#include "render/technique/registry.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "tests/benchmarks/prt_curves.h"
#include "tests/benchmarks/stage.h"
#include "tests/support/sparse_transfer.h"
#include "tests/support/transfer_reference.h"

namespace maquette::bench {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kTurn_rad = 37.0 * 3.14159265358979323846 / 180.0;
const std::vector<std::string> kParts = {"seat_cushion", "seat_cushion_insert", "seat_backrest", "seat_backrest_insert",
                                         "seat_headrest"};

/// The seat alone, without its box: the sky reaches it from all sides.
std::shared_ptr<const Scene> seat_covered(const std::string& cover) {
  auto scene = std::make_shared<Scene>(build_builtin_scene("seat"));
  for (Material& m : scene->materials)
    if (m.name == "Seat" || m.name == "SeatInsert") m.measured = cover;
  for (Node& node : scene->nodes)
    if (node.mesh >= 0) node.visible = std::find(kParts.begin(), kParts.end(), node.name) != kParts.end();
  scene->name = "builtin:seat";
  return scene;
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

class TransferBench {
 public:
  explicit TransferBench(Stage& stage) : stage_(stage) {
    settings_.set("prt.vertices", 20000);
    // As many components for every cover; --set prt.btf_error chooses by the error.
    settings_.set("prt.btf_components", 2);
    settings_.set("prt.btf_error", 0.0);
    settings_.set("shading.visibility", std::string("none"));
    for (const auto& [name, value] : stage.options().settings) settings_.set_from_text(name, value);
  }

  Figures measure() {
    // Any built-in BTF: leather, knit@64, ...
    const std::vector<std::string>& covers = stage_.options().only;
    for (const std::string& cover : covers.empty() ? std::vector<std::string>{"leather"} : covers) measure_cover(cover);
    return std::move(figures_);
  }

 private:
  void measure_cover(const std::string& cover) {
    const auto scene = seat_covered("builtin:btf-" + cover);
    name_ = "seat, btf-" + cover;
    bake(*scene, cover);
    const std::string data = stage_.options().data;
    if (!data.empty()) measure_sky(scene, "workshop", data + "/environments/autoshop_01_1k.hdr");
    measure_sky(scene, "studio", "builtin:studio");
    measure_turned_object(scene);
    measure_light(*scene);
    measure_sums(cover);
  }

  void measure_sky(const std::shared_ptr<const Scene>& scene, const std::string& sky, const std::string& file) {
    sky_ = std::make_shared<const Environment>(load_environment(file));
    under_ = name_ + ", " + sky;
    Renderer& renderer = stage_.renderer();
    renderer.set_scene(scene);
    renderer.set_environment(sky_);
    const auto traced = build_path_scene({.scene = *scene, .environment = sky_});
    const CubeDirections cube(settings_.get_int("prt.faces"));
    const CubePyramid pyramid(*sky_);
    Image references[2];
    for (int turned = 0; turned < 2; ++turned) {
      const glm::dmat3 turn = environment_rotation(turned == 1 ? kTurn_rad : 0.0);
      references[turned] =
          test::trace_transfer_reference({*traced, cube, pyramid.resample(cube, turn), settings_.get_int("prt.rays"),
                                          settings_.get_int("prt.btf_components")},
                                         camera(*scene), kWidth, kHeight);
    }
    measure_vertices(*scene,
                     {*traced, cube, pyramid.resample(cube, environment_rotation(0.0)), settings_.get_int("prt.rays"),
                      settings_.get_int("prt.btf_components")},
                     references[0]);
    measure_errors(*scene, references);
    measure_turned_light(*scene);
    measure_most_changed(*scene, *traced);
    measure_raw(*scene, traced, references[0]);
  }

  /// What arrives at the vertices, linear between them, and what compression adds.
  void measure_vertices(const Scene& scene, test::TransferReference reference, const Image& at_pixels) {
    const std::atomic<bool> never{false};
    const TransferJob from = job(scene);
    const TransferMesh mesh = make_transfer_mesh(*from.geometry, from.parts, from.options.vertices);
    const RayScene occluders = build_ray_scene(*from.geometry, from.occluding);
    const ArrivingLight arriving = trace_arriving_light(mesh, reference.cube, occluders, {reference.rays}, never);
    reference.vertices = &mesh;
    reference.light_of =
        light_sources(mesh, find_buried_vertices(mesh, *from.geometry, reference.cube, occluders, arriving), arriving);
    const Image at_vertices = test::trace_transfer_reference(reference, camera(scene), kWidth, kHeight);
    figures_.push_back(shown(
        under_ + ": plain sums at the vertices, linear between them, against plain sums at the pixels",
        percent(error_of_covered(at_vertices, at_pixels)) + "; what is drawn with all coefficients, against them " +
            percent(error_of_covered(draw(request(scene, 0.0, 1024)), at_vertices)) + " (C_T)"));
  }

  /// The job of the files that were baked.
  TransferJob job(const Scene& scene) {
    MeasuredLibrary library;
    return make_transfer_job(
        {std::make_shared<Scene>(scene), std::make_shared<const FlatGeometry>(flatten(scene)), -1, {}, settings_}, {},
        &library);
  }

  /// The turned light against a light that is given turned.
  void measure_turned_light(const Scene& scene) {
    const Image turned = draw(request(scene, kTurn_rad, 64)), straight = draw(request(scene, 0.0, 64));
    stage_.renderer().set_environment(turned_sky(environment_rotation(kTurn_rad)));
    const Image given = draw(request(scene, 0.0, 64));
    stage_.renderer().set_environment(sky_);
    figures_.push_back(judged(
        under_ + ": light turned by 37 degrees, against a light given turned", "<= 1 %",
        percent(error_of_covered(turned, given)) + " (not turned: " + percent(error_of_covered(straight, given)) + ")",
        error_of_covered(turned, given) <= 0.01));
  }

  /// The same turn from where it changes most of what is seen.
  void measure_most_changed(const Scene& scene, const PathScene& traced) {
    CameraView best;
    std::vector<double> changes;
    for (int i = 0; i < 36; ++i) {
      const double azimuth = glm::radians(30.0 * (i % 12)), height = glm::radians(-15.0 + 25.0 * (i / 12));
      FrameRequest r = request(scene, 0.0, 1024);
      r.camera.target = {0.0f, 0.6f, -0.1f};
      r.camera.eye = r.camera.target + 1.6f * glm::vec3(std::cos(height) * std::sin(azimuth), std::sin(height),
                                                        std::cos(height) * std::cos(azimuth));
      const Image straight = draw(r);
      r.env_rotation_rad = static_cast<float>(kTurn_rad);
      changes.push_back(error_of_covered(straight, draw(r)));
      if (changes.back() >= *std::max_element(changes.begin(), changes.end())) best = r.camera;
    }
    const CubeDirections cube(settings_.get_int("prt.faces"));
    const CubePyramid pyramid(*sky_);
    double errors[2], other = 0.0;
    for (const bool turned : {false, true}) {
      const double angle = turned ? kTurn_rad : 0.0;
      const Image reference =
          test::trace_transfer_reference({traced, cube, pyramid.resample(cube, environment_rotation(angle)),
                                          settings_.get_int("prt.rays"), settings_.get_int("prt.btf_components")},
                                         best, kWidth, kHeight);
      FrameRequest r = request(scene, angle, 64);
      r.camera = best;
      errors[turned] = error_of_covered(draw(r), reference);
      r.env_rotation_rad = 0.0f;
      other = error_of_covered(draw(r), reference);
    }
    char eye[80];
    std::snprintf(eye, sizeof eye, "%.2f, %.2f, %.2f", static_cast<double>(best.eye.x), static_cast<double>(best.eye.y),
                  static_cast<double>(best.eye.z));
    figures_.push_back(judged(
        under_ + ": light turned by 37 degrees, from where it changes most of 36 places around (eye " + eye + ")",
        "within 1 point; not turned: > 5 %",
        percent(errors[1]) + " (as it stands " + percent(errors[0]) + ", unturned light " + percent(other) +
            "; median change of all places " + percent(quantile(changes, 0.5)) + ")",
        errors[1] <= errors[0] + 0.01 && other > 0.05));
  }

  /// The sky seen through a rotation, in double on four times as many texels a side.
  std::shared_ptr<const Environment> turned_sky(const glm::dmat3& sky_from_given) const {
    auto given = std::make_shared<Environment>();
    given->width = 4 * sky_->width;
    given->height = 4 * sky_->height;
    for (int y = 0; y < given->height; ++y)
      for (int x = 0; x < given->width; ++x)
        given->rgb.emplace_back(evaluate_environment(
            *sky_, sky_from_given * direction_from_latlong(x + 0.5, y + 0.5, given->width, given->height)));
    return given;
  }

  /// All of the scene by 25 degrees about a tilted axis, the camera along.
  void measure_turned_object(const std::shared_ptr<const Scene>& scene) {
    const glm::dmat4 turn =
        glm::rotate(glm::dmat4(1.0), glm::radians(25.0), glm::normalize(glm::dvec3(0.3, 0.8, -0.5)));
    auto turned = std::make_shared<Scene>(*scene);
    for (const int root : turned->roots) {
      glm::mat4& local = turned->nodes[static_cast<std::size_t>(root)].local;
      local = glm::mat4(turn * glm::dmat4(local));
    }
    FrameRequest along = request(*scene, 0.0, 64);
    for (glm::vec3* point : {&along.camera.eye, &along.camera.target})
      *point = glm::vec3(turn * glm::dvec4(glm::dvec3(*point), 1.0));
    along.camera.up = glm::vec3(glm::dmat3(turn) * glm::dvec3(along.camera.up));
    Renderer& renderer = stage_.renderer();
    renderer.set_scene(turned);
    const Image shown_turned = draw(along);
    renderer.set_scene(scene);
    const Image straight = draw(request(*scene, 0.0, 64));
    renderer.set_environment(turned_sky(glm::dmat3(turn)));
    const Image given = draw(request(*scene, 0.0, 64));
    renderer.set_environment(sky_);
    figures_.push_back(
        judged(under_ + ": object turned by 25 degrees about a tilted axis, against a light given turned", "<= 1 %",
               percent(error_of_covered(shown_turned, given)) +
                   " (not turned: " + percent(error_of_covered(straight, given)) + ")",
               error_of_covered(shown_turned, given) <= 0.01));
  }

  /// The sums alone, by the processor's lanes (AVX and F16C; AVX-512 is not used) and by plain code.
  void measure_sums(const std::string& cover) {
    const std::atomic<bool> never{false};
    const TransferJob from = job(*seat_covered("builtin:btf-" + cover));
    const auto transfer = bake_transfer(from, {}, nullptr, never, {});
    const CubeDirections cube(settings_.get_int("prt.faces"));
    const RelightTable& table = transfer->bake->table;
    const CubeLight light = haar_light(CubePyramid(*sky_), cube, glm::dmat3(1.0));
    std::vector<glm::vec4> sums;
    for (const std::size_t coefficients : {std::size_t{20}, std::size_t{120}}) {
      const KeptLight kept = choose_coefficients(light, table.importance(), 6 * coefficients);
      std::vector<double> lanes, plain;
      for (int i = 0; i < 9; ++i) {
        Clock begin = now();
        table.sums(kept, &sums);
        lanes.push_back((now() - begin).wall_ms);
        begin = now();
        table.sums_by_scalars(kept, &sums);
        plain.push_back((now() - begin).wall_ms);
      }
      figures_.push_back(
          shown("sums of " + std::to_string(table.rows()) + " rows, " + std::to_string(coefficients) +
                    " coefficients a face (AVX and F16C; AVX-512 is not used)",
                number(quantile(lanes, 0.5)) + " ms; by plain code " + number(quantile(plain, 0.5)) + " ms"));
    }
    compare_sparse(table, light);
  }

  /// The thesis' light side: of each row the largest coefficients alone.
  void compare_sparse(const RelightTable& table, const CubeLight& light) {
    std::vector<glm::vec4> whole, sparse;
    for (const std::size_t of_row : {std::size_t{16}, std::size_t{64}, std::size_t{256}}) {
      const test::SparseTransfer rows(table, of_row);
      std::string text = number(1e-6 * static_cast<double>(rows.bytes())) + " MB (dense " +
                         number(1e-6 * static_cast<double>(table.bytes())) + "), misses " + percent(rows.error()) +
                         " of q";
      for (const std::size_t coefficients : {std::size_t{20}, std::size_t{120}}) {
        const KeptLight kept = choose_coefficients(light, table.importance(), 6 * coefficients);
        table.sums(kept, &whole);
        std::vector<double> times;
        for (int i = 0; i < 5; ++i) {
          const Clock begin = now();
          rows.sums(kept, &sparse);
          times.push_back((now() - begin).wall_ms);
        }
        double missed = 0.0, all = 0.0;
        for (std::size_t r = 0; r < whole.size(); ++r) {
          missed += static_cast<double>(glm::dot(sparse[r] - whole[r], sparse[r] - whole[r]));
          all += static_cast<double>(glm::dot(whole[r], whole[r]));
        }
        text += "; " + std::to_string(coefficients) + " of the light: " + number(quantile(times, 0.5)) +
                " ms, sums miss " + percent(std::sqrt(missed / std::max(all, 1e-300)));
      }
      figures_.push_back(shown("sparse q with " + std::to_string(of_row) + " coefficients a row", text));
    }
  }

  CameraView camera(const Scene& scene) const { return find_camera(scene, "left"); }

  FrameRequest request(const Scene& scene, double turn_rad, int coefficients) const {
    FrameRequest r;
    r.mode = "prt";
    r.width = kWidth;
    r.height = kHeight;
    r.camera = camera(scene);
    r.env_rotation_rad = static_cast<float>(turn_rad);
    r.settings = settings_;
    if (coefficients > 0) r.settings.set("prt.coefficients", coefficients);
    return r;
  }

  void bake(const Scene& scene, const std::string& cover) {
    const std::string folder = (std::filesystem::path(stage_.options().scratch) / ("prt-" + cover)).string();
    if (stage_.options().fresh) std::filesystem::remove_all(folder);
    const std::atomic<bool> never{false};
    const Clock begin = now();
    std::string report;
    builtin_registry().find_bake("prt").run(
        {scene, -1, settings_, {}, folder},
        {never, [](const std::string&, double) {},
         [&](const std::string& line) { report += (report.empty() ? "" : "; ") + line; }});
    const Clock time = now() - begin;
    const double seconds = 1e-3 * time.wall_ms;
    const std::string measured = number(seconds) + " s (" + number(1e-3 * time.cpu_ms) + " s of CPU); " + report;
    figures_.push_back(stage_.options().fresh
                           ? judged(name_ + ": bake", "<= 600 s (aim 180)", measured, seconds <= 600.0)
                           : shown(name_ + ": bake (or its load)", measured));
    settings_.set("prt.bake", folder);
  }

  Image draw(const FrameRequest& r) {
    Renderer& renderer = stage_.renderer();
    renderer.finish_background_work(r);
    renderer.render(r);
    return renderer.read_radiance();
  }

  void measure_errors(const Scene& scene, const Image references[2]) {
    std::string sweep;
    double at_64 = 0.0;
    for (const int coefficients : {4, 16, 20, 64, 120, 128, 1024}) {
      const double e = error_of_covered(draw(request(scene, 0.0, coefficients)), references[0]);
      if (coefficients == 64) at_64 = e;
      sweep += (sweep.empty() ? "" : ", ") + std::to_string(coefficients) + ": " + percent(e);
    }
    figures_.push_back(judged(under_ + ": 64 coefficients a face, against plain sums of the same BTF and cube light",
                              "<= 5 %", percent(at_64), at_64 <= 0.05));
    figures_.push_back(shown(under_ + ": the same by coefficients a face (1024: all)", sweep));
    const Image turned = draw(request(scene, kTurn_rad, 64)), straight = draw(request(scene, 0.0, 64));
    const double of_turned = error_of_covered(turned, references[1]), other = error_of_covered(straight, references[1]);
    figures_.push_back(judged(under_ + ": light turned by 37 degrees, against plain sums", "within 1 point",
                              percent(of_turned) + " (unturned light: " + percent(other) + ")",
                              of_turned <= at_64 + 0.01));
    const double step = 0.1 * 3.14159265 / 180.0;
    double worst = 0.0;
    for (const double degrees : {0.0, 12.3, 37.0, 90.0}) {
      const double at = degrees * 3.14159265 / 180.0;
      const double kept = error_of_covered(draw(request(scene, at + step, 64)), draw(request(scene, at, 64)));
      const double all = error_of_covered(draw(request(scene, at + step, 1024)), draw(request(scene, at, 1024)));
      worst = std::max(worst, kept / std::max(all, 1e-12));
    }
    figures_.push_back(judged(under_ + ": change of the picture by 0.1 degrees, 64 coefficients over all", "<= 2",
                              number(worst), worst <= 2.0));
    save(references[0], straight, under_);
    save(references[1], turned, under_ + ", turned");
  }

  /// Against the raw BTF under the whole sky, no bounces.
  void measure_raw(const Scene& scene, const std::shared_ptr<const PathScene>& traced, const Image& cube_reference) {
    const CubeDirections cube(settings_.get_int("prt.faces"));
    const Image all_components =
        test::trace_transfer_reference({*traced, cube, CubePyramid(*sky_).resample(cube, environment_rotation(0.0)),
                                        settings_.get_int("prt.rays"), kMostBtfComponents},
                                       camera(scene), kWidth, kHeight);
    const PictureRequest p{
        .camera = camera(scene), .width = kWidth, .height = kHeight, .seed = 7, .paths = {.max_bounces = 1}};
    ReferencePicture picture(traced, p);
    picture.add(std::max(64, static_cast<int>(stage_.options().reference_seconds * 8.0)));
    const Image mean = picture.mean();
    Image raw = cube_reference;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int c = 0; c < 3; ++c) raw.at(x, y, c) = mean.at(x, y, c);
    figures_.push_back(shown(under_ + ": against the BTF with all its components under the whole sky, no bounces",
                             percent(error_of_covered(draw(request(scene, 0.0, 64)), raw)) + "; of it C_B " +
                                 percent(error_of_covered(cube_reference, all_components)) + ", cube light " +
                                 percent(error_of_covered(all_components, raw)) + ", both " +
                                 percent(error_of_covered(cube_reference, raw))));
    save(raw, cube_reference, under_ + ", raw");
  }

  void measure_light(const Scene& scene) {
    Renderer& renderer = stage_.renderer();
    struct Run {
      int coefficients, scale;
    };
    for (const auto& [coefficients, scale] : {Run{20, 1}, Run{120, 1}, Run{20, 2}}) {
      std::vector<double> updates, frames, vertices;
      FrameRequest r = request(scene, 0.0, coefficients);
      r.width = 640 * scale;
      r.height = 360 * scale;
      for (int i = 0; i < 40; ++i) {
        r.env_rotation_rad = 0.02f * static_cast<float>(i);
        const FrameStats stats = renderer.render(r);
        if (i < 5) continue;
        updates.push_back(stats.technique.at("light_update_ms"));
        frames.push_back(stats.frame_ms);
        for (const PassTime& pass : stats.passes)
          if (pass.name == "transfer_vertices") vertices.push_back(pass.ms);
      }
      const double median = quantile(updates, 0.5);
      const std::string text = number(median) + " ms, 95th percentile " + number(quantile(updates, 0.95)) +
                               " ms; frames " + number(quantile(frames, 0.5)) + " ms, of them vertices " +
                               number(quantile(vertices, 0.5)) + " ms";
      const std::string figure = "light update while it turns, " + std::to_string(r.width) + " x " +
                                 std::to_string(r.height) + ", " + std::to_string(coefficients) +
                                 " coefficients a face";
      figures_.push_back(coefficients == 20 && scale == 1 ? judged(figure, "<= 16 ms (aim 4)", text, median <= 16.0)
                                                          : shown(figure, text));
    }
  }

  void save(const Image& left, const Image& right, std::string name) const {
    if (stage_.options().charts.empty()) return;
    name.erase(std::remove(name.begin(), name.end(), ','), name.end());
    std::replace(name.begin(), name.end(), ' ', '-');
    std::filesystem::create_directories(stage_.options().charts);
    Image both(2 * kWidth, kHeight, 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < 2 * kWidth; ++x)
        for (int c = 0; c < 3; ++c) both.at(x, y, c) = (x < kWidth ? left.at(x, y, c) : right.at(x - kWidth, y, c));
    save_exr((std::filesystem::path(stage_.options().charts) / (name + ".exr")).string(), both);
  }

  Stage& stage_;
  Settings settings_;
  std::shared_ptr<const Environment> sky_;
  std::string name_, under_;
  Figures figures_;
};

}  // namespace

double error_of_covered(const Image& picture, const Image& reference) {
  double squares = 0.0, light = 0.0;
  std::size_t count = 0;
  for (int y = 0; y < reference.height; ++y)
    for (int x = 0; x < reference.width; ++x) {
      if (reference.at(x, y, 3) < 1.0f || picture.at(x, y, 3) < 1.0f) continue;
      ++count;
      for (int c = 0; c < 3; ++c) {
        squares += std::pow(static_cast<double>(picture.at(x, y, c) - reference.at(x, y, c)), 2.0);
        light += (c == 0 ? 0.2126 : c == 1 ? 0.7152 : 0.0722) * static_cast<double>(reference.at(x, y, c));
      }
    }
  return count > 0 ? std::sqrt(squares / static_cast<double>(3 * count)) * static_cast<double>(count) / light : 0.0;
}

Figures measure_prt(Stage& stage) { return TransferBench(stage).measure(); }

}  // namespace maquette::bench
