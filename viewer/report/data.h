#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/frame/plan.h"
#include "render/metrics/metrics.h"

/// The contents of a report, as plain values: measured by measure.h, written by write_data.h, charts.h and page.h.
namespace maquette::report {

/// What an error is measured against.
enum class Scope {
  estimator,   ///< unshadowed direct light, which the technique claims to compute: its own error
  model,       ///< all light paths: includes the error of effects that the technique leaves out
  reflection,  ///< the picture with `raytraced` reflections at full resolution: the error of a reflector technique
};
inline constexpr Scope kScopes[] = {Scope::estimator, Scope::model, Scope::reflection};
std::string scope_name(Scope scope);
/// Throws std::out_of_range for an unknown name.
Scope scope_from_name(const std::string& name);

struct Spread {
  double median = 0.0;
  double low = 0.0;   ///< smallest of the repeats
  double high = 0.0;  ///< largest
};
/// Values must not be empty.
Spread spread_of(std::vector<double> values);

/// One technique at one quality, seen by one camera, judged in one scope.
struct Point {
  std::string camera, technique, quality;
  Scope scope = Scope::model;
  int samples = 0;      ///< of the quality step, 0: it has none
  int step = 0;         ///< in the technique's quality steps
  int repeats = 0;      ///< of different seeds
  Spread time_ms;       ///< wall, of one frame
  double cpu_ms = 0.0;  ///< median, all threads
  std::size_t gpu_bytes = 0;
  std::size_t shading_samples = 0;      ///< of one frame
  std::optional<Spread> relative_rmse;  ///< without the reference's own noise; absent: a black reference
  bool below_noise = false;             ///< this error is not distinguishable from that of the reference
  ErrorFigures figures;                 ///< of the first repeat, including noise
  std::string picture;                  ///< PNG in the report's folder; empty in the scope estimator
  std::string difference;               ///< FLIP in false colours
};

struct ReferenceEntry {
  std::string camera;
  Scope scope = Scope::model;
  std::string file;  ///< EXR in the report's folder
  std::string made_by;
  int samples = 0;
  double noise = 0.0;  ///< its own relative RMSE, estimated
  double seconds = 0.0;
};

/// What the plan of a technique leaves out, or why the technique is not measured at all (`what` is then its name).
struct LeftOutEntry {
  std::string technique;
  std::string what, why;
};

struct NamedValue {
  std::string name, value;
};

struct CameraEntry {
  std::string name;
  std::string reference_picture;  ///< PNG of the scope model
};

struct TechniqueEntry {
  std::string name, help;
  bool traces_picture = false;  ///< slower than the others by orders of magnitude
};

struct Report {
  std::string scene, environment, command;
  int width = 0, height = 0;
  std::vector<CameraEntry> cameras;
  std::vector<TechniqueEntry> techniques;
  std::vector<Point> points;
  std::vector<ReferenceEntry> references;
  std::vector<LeftOutEntry> left_out;
  std::vector<NamedValue> machine;
  std::vector<std::string> skipped;  ///< what was not measured, and why, one line each
  double budget_s = 0.0, seconds = 0.0;
  int measured_now = 0, reused = 0;  ///< points of this run, points of earlier runs
  bool interrupted = false;

  bool has(Scope scope) const {
    return std::any_of(points.begin(), points.end(), [scope](const Point& p) { return p.scope == scope; });
  }
};

}  // namespace maquette::report
