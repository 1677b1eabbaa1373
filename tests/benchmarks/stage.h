#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/image.h"

namespace maquette::test {
class SampledHalf;
}

/// The benchmark program: every figure that the project promises, measured. Shared by its parts.
namespace maquette::bench {

struct Options {
  std::string
      data;  ///< folder with scenes/, environments/, measured/; empty: figures that need it are reported as absent
  std::string program;            ///< maquette itself, for figures of whole processes
  std::string scratch;            ///< references and expanded tables are kept here between runs
  std::string charts;             ///< folder for charts of what is measured, by gnuplot; empty: none
  std::vector<std::string> only;  ///< cases by part of their name; empty: all
  std::vector<std::pair<std::string, std::string>> settings;
  int repeats = 3;
  double reference_seconds = 60.0;  ///< at most, a case
  double sweep_seconds = 20.0;      ///< no single frame longer than this
  bool fresh = false;               ///< make references again
  bool wants(const std::string& name) const;
};

/// One line of the table: target and measured value.
struct Figure {
  enum class Verdict { met, missed, shown, absent };
  std::string name, target, measured;
  Verdict verdict = Verdict::shown;
};
using Figures = std::vector<Figure>;
Figure judged(std::string name, std::string target, std::string measured, bool met);
Figure shown(std::string name, std::string measured);
Figure absent(std::string name, std::string target, std::string why);
/// With three significant digits.
std::string number(double value);
std::string percent(double share);

/// The input of one picture.
struct Case {
  std::string name = {}, scene = {}, camera = {}, material = {};
  std::string environment = "builtin:clear-sky";
  int width = 640, height = 360;
  bool plain = false;  ///< without the textures of its materials
};

struct Clock {
  double wall_ms = 0.0, cpu_ms = 0.0;  ///< CPU time of all threads of the process
};
Clock now();
inline Clock operator-(const Clock& a, const Clock& b) { return {a.wall_ms - b.wall_ms, a.cpu_ms - b.cpu_ms}; }

inline Clock operator+(const Clock& a, const Clock& b) { return {a.wall_ms + b.wall_ms, a.cpu_ms + b.cpu_ms}; }

struct Reference {
  Image picture;
  Image halves[2];     ///< with independent seeds; the picture is their mean
  double noise = 0.0;  ///< its own relative RMSE, from the difference of its two halves
};

/// One context and one renderer, showing one case at a time.
class Stage {
 public:
  explicit Stage(const Options& options);
  /// Changes only what differs from the previous case.
  void show(const Case& c);
  FrameRequest request(const std::string& mode, int samples, std::uint32_t seed = 0) const;
  /// What modes `uniform` and `bandwidth` converge to: very bright texels by quadrature, everything else by mode
  /// uniform at a high count. Stored on disk under a key of the scene's content. Two halves with different seeds and
  /// grids.
  const Reference& reference();
  Image draw_uniform(int samples, std::uint32_t seed, int frames = 1);
  Renderer& renderer() { return *renderer_; }
  const Case& current() const { return case_; }
  const Options& options() const { return options_; }
  const DeviceInfo& device() const { return device_; }

 private:
  std::uint64_t content_key();
  void make_reference(Image halves[2]);
  void sample_halves(const Clock& begin, test::SampledHalf halves[2]);
  void set_inputs(std::shared_ptr<const Scene> scene, std::shared_ptr<const Environment> environment);
  const Options& options_;
  GlContext context_;
  DeviceInfo device_;
  std::unique_ptr<Renderer> renderer_;
  Case case_;
  CameraView camera_;
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Environment> environment_;
  std::uint64_t environment_hash_ = 0;
  Reference reference_;
  std::string reference_of_;
};

/// Camera of a node of the scene; without a name the first one, or one that frames the bounds.
CameraView find_camera(const Scene& scene, const std::string& name);

/// relative RMSE against the reference, with the reference's noise removed.
double error_against(const Image& picture, const Reference& reference);
double relative_rmse(const Image& picture, const Image& reference);

/// The seven pictures of the equal-quality figure; without the data six.
std::vector<Case> quality_cases(const Options& options);
/// A sphere under Grace Cathedral, four measured tables: the comparison with a research renderer. None without the
/// data.
std::vector<Case> research_cases(const Options& options);
/// Paths of MERL tables of the data, expanded into the scratch folder; throws Error when that fails.
std::vector<std::string> expand_tables(const Options& options, const std::vector<std::string>& names);

Figures measure_correct(Stage& stage);
Figures measure_samples(Stage& stage);
Figures measure_converged(Stage& stage);
Figures measure_progressive(Stage& stage);
Figures measure_research(Stage& stage);
Figures measure_equal_quality(Stage& stage);
Figures measure_validation(Stage& stage);
Figures measure_multisampling(Stage& stage);
Figures measure_interactive(Stage& stage);
Figures measure_looks(Stage& stage);
Figures measure_moving(Stage& stage);
Figures measure_pictures(Stage& stage);
Figures measure_scaling(Stage& stage);
Figures measure_reflections(Stage& stage);
Figures measure_reflection_frames(Stage& stage);
Figures measure_skipping(Stage& stage);
Figures measure_octree(Stage& stage);
Figures measure_path_tracer(Stage& stage);
Figures measure_meter(Stage& stage);
Figures measure_slf(Stage& stage);
Figures measure_prt(Stage& stage);

}  // namespace maquette::bench
