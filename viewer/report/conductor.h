#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "viewer/report/data.h"
#include "viewer/report/journal.h"
#include "viewer/report/references.h"
#include "viewer/report/studio.h"

namespace maquette::report {

/// Measures everything of a report within its budget. Cheap qualities of all cameras and techniques come first, so that
/// an interrupted report is balanced.
class Conductor {
 public:
  /// `say(line)` is called for each result.
  Conductor(Studio* studio, Journal* journal, std::string folder, std::function<void(const std::string&)> say);
  /// Fills cameras, techniques, points, references, left_out and skipped of the report.
  void run(Report* report);

 private:
  /// One technique with one camera in one scope, or in several for which it draws the same picture.
  struct Ladder {
    std::size_t camera = 0, technique = 0;
    std::vector<Scope> scopes;
    double last_ms = 0.0;  ///< a frame of the last step
    int last_samples = 0;
    int idle_steps = 0;  ///< consecutive steps that did not change the error
    struct Errors {
      double relative_rmse = 0.0, flip = 0.0;
    };
    std::map<Scope, Errors> last_errors;
    bool over = false;
  };

  double elapsed_s() const;
  void list_techniques(Report* report);
  void make_references(Report* report);
  void make_reflection_reference(std::size_t camera, Report* report);
  std::vector<Ladder> make_ladders() const;
  void climb(Ladder* ladder, int step, Report* report);
  bool reuse_earlier_points(Ladder* ladder, int step, Report* report);
  void measure(Ladder* ladder, int step, Report* report);
  void note_progress(Ladder* ladder, const QualityStep& step, const std::vector<Point>& points);
  FramePlan plan_of(const SweptTechnique& technique, Scope scope) const;
  FrameRequest request(const Ladder& ladder, const QualityStep& step) const;
  std::string key_of(const Ladder& ladder, const FrameRequest& request, Scope scope) const;
  void write_pictures(const Image& radiance, const Image& flip_map, const Image& reference, Point* point);
  float exposure_of_camera(const std::string& camera) const;

  Studio* studio_;
  Journal* journal_;
  std::string folder_;
  std::function<void(const std::string&)> say_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  SceneFacts facts_;
  std::vector<SweptCamera> cameras_;
  std::vector<SweptTechnique> techniques_;
  std::map<std::pair<std::string, Scope>, Judge> judges_;
};

}  // namespace maquette::report
