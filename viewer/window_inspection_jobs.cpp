// Sweeps and files of the tab Inspect, which are measured on a thread of their own.
#include <filesystem>

#include "scenes/error.h"
#include "scenes/files.h"
#include "viewer/inspection_options.h"
#include "viewer/measure/measure_files.h"
#include "viewer/outputs.h"
#include "viewer/window_inspection.h"

namespace maquette {

void WindowInspection::start_job(WindowSession* session, bool exports) {
  if (job_ || !traced_) {
    session->add_message(MessageLevel::warning, "inspection: wait until the scene is prepared");
    return;
  }
  const InspectionView& view = session->state.inspection;
  const EditorState& state = session->state;
  SceneOptions options = inspected_options(state, traced_->scene->name);
  constexpr int kSweepHeight = 54, kExportHeight = 180;
  options.height = exports ? kExportHeight : kSweepHeight;
  const float aspect = static_cast<float>(std::max(seen_.width, 1)) / static_cast<float>(std::max(seen_.height, 1));
  options.width = std::max(1, static_cast<int>(std::lround(aspect * static_cast<float>(options.height))));
  options.samples = exports ? 16 : 8;
  MeasureOptions measured = measure_options_of(view);
  measured.edits = state.edits;
  if (exports) {
    measured.paths = 64;
    measured.layers = "exr";
    measured.regions = picture_regions(view.regions, options.width, options.height);
  } else {
    const std::string& name = sweep_names()[static_cast<std::size_t>(view.sweep)];
    Sweep sweep{name, {}};
    sweep_x_.clear();
    sweep_y_.clear();
    for (int i = 0; i < view.sweep_count; ++i) {
      const double t = static_cast<double>(i) / std::max(view.sweep_count - 1, 1);
      sweep.values.push_back(static_cast<double>(view.sweep_range[0]) * (1.0 - t) +
                             static_cast<double>(view.sweep_range[1]) * t);
      check_sweep_value(name, sweep.values.back());
      sweep_x_.push_back(static_cast<float>(sweep.values.back()));
    }
    measured.sweeps = {sweep};
    sweep_of_ghost_ = changes_glass_alone(name);
    sweep_title_ = std::string(sweep_of_ghost_ ? "ghost angle" : "reflected light") + " over " + name;
  }
  const std::string path = view.export_path.data();
  job_ = std::make_unique<Job>();
  job_->what = exports ? "Export" : "Sweep of " + measured.sweeps.front().name;
  job_->exports = exports;
  job_->result =
      std::async(std::launch::async, [job = job_.get(), options, measured, traced = *traced_, exports, path] {
        LastEye last;
        MeasureOptions asked = measured;
        Measurement result = measure(
            options, asked, traced.scene, traced.environment,
            [job](double share) {
              job->share = static_cast<float>(share);
              if (job->cancel) throw Error("inspection", "cancelled", "");
            },
            &last);
        if (exports) {
          write_text(path, lower_extension(path) == ".json" ? measurement_json(result) : measurement_csv(result));
          write_layers(std::filesystem::path(path).replace_extension(".exr").string(), result, last);
        }
        return result;
      });
}

void WindowInspection::finish_job(WindowSession* session) {
  if (!job_ || !is_ready(job_->result)) return;
  const bool exports = job_->exports, cancelled = job_->cancel;
  try {
    const Measurement result = job_->result.get();
    if (exports) {
      const std::string path = session->state.inspection.export_path.data();
      session->add_message(MessageLevel::warning, "written: " + path + " and its layers");
    } else {
      sweep_y_ = worst_of_steps(result, sweep_x_, sweep_of_ghost_);
    }
    worst_ = worst_rows(result);
  } catch (const std::exception& error) {
    if (!cancelled) session->add_message(MessageLevel::error, error.what());
    sweep_x_.clear();
  }
  job_.reset();
}

}  // namespace maquette
