#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>

#include "scenes/error.h"
#include "scenes/harmless.h"
#include "viewer/bake_lines.h"
#include "viewer/budget_curve.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/interrupt.h"
#include "viewer/outputs.h"
#include "viewer/print.h"
#include "viewer/report/charts.h"
#include "viewer/report/conductor.h"
#include "viewer/report/machine.h"
#include "viewer/report/page.h"
#include "viewer/report/write_data.h"
#include "viewer/review_options.h"
#include "viewer/session.h"

namespace maquette {

namespace {

using namespace report;
namespace fs = std::filesystem;

/// One line that is overwritten on a terminal; elsewhere a new line every few seconds.
class Progress {
 public:
  explicit Progress(double budget_s) : budget_s_(budget_s) {}
  ~Progress() {
    if (terminal_ && written_) std::fputc('\n', stderr);
  }
  void say(const std::string& line) {
    const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
    if (!terminal_ && written_ && seconds - last_s_ < kQuiet_s) return;
    std::fprintf(stderr, terminal_ ? "\r\033[K%4.0f of %.0f s  %s" : "%4.0f of %.0f s  %s\n", seconds, budget_s_,
                 harmless(line).c_str());
    std::fflush(stderr);
    last_s_ = seconds;
    written_ = true;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kQuiet_s = 2.0;
  double budget_s_, last_s_ = 0.0;
  Clock::time_point begin_ = Clock::now();
  bool terminal_ = isatty(STDERR_FILENO) == 1, written_ = false;
};

void write_outputs(const std::string& folder, const Report& report, std::string* chart_problem) {
  write_text(folder + "/report.json", report_json_text(report));
  write_text(folder + "/report.csv", report_csv_text(report));
  PageInput page{report, folder, {}, {}};
  for (const Chart& chart : list_charts(report)) {
    const std::optional<std::string> svg = draw_chart(chart, folder + "/charts", &page.chart_problem);
    if (!svg) break;
    page.charts[chart.name] = *svg;
  }
  *chart_problem = page.chart_problem;
  write_text(folder + "/report.html", page_html(page));
}

/// Error curves for the window's error budget.
BudgetCurves budget_curves(const Report& report) {
  BudgetCurves curves;
  for (const Scope scope : {Scope::estimator, Scope::model}) {
    for (const Curve& curve : mean_curves(report, scope, Metric::relative_rmse)) {
      BudgetCurve& stored = curves[curve_name(curve.technique, scope == Scope::model)];
      stored.source = "the report of " + report.machine.front().value;
      for (const CurvePoint& point : curve.points) stored.points.push_back({point.samples, point.time_ms, point.error});
    }
  }
  return curves;
}

std::string command_text(const SceneOptions& options) {
  std::string text = "maquette report " + options.scene + " -o " + options.output + " --env " + options.environment +
                     " --size " + std::to_string(options.width) + "x" + std::to_string(options.height) + " --budget " +
                     to_text(options.budget_s) + " --repeats " + std::to_string(options.repeats);
  for (const auto& [name, source] : options.materials) text += " --material '" + name + "=" + source + "'";
  if (!options.scene_of_file.empty()) text += " --scene '" + options.scene_of_file + "'";
  if (!options.variant.empty()) text += " --variant '" + options.variant + "'";
  for (const std::string& node : options.reflectors) text += " --reflector '" + node + "'";
  for (const auto& [name, value] : options.settings.changed()) text += " --set " + name + "=" + to_text(value);
  return text;
}

}  // namespace

int run_report(const CommandLine& line) {
  SceneOptions options = line.options;
  const std::optional<Look> look = take_review(&options);
  const std::string& folder = options.output;
  prepare_folder("--output", folder);
  const InterruptGuard stop;
  Report report;
  report.scene = options.scene;
  report.environment = options.environment;
  report.command = command_text(options);
  report.width = options.width;
  report.height = options.height;
  report.budget_s = options.budget_s;
  {
    Progress progress(options.budget_s);
    Journal journal(folder);
    if (!journal.note().empty()) print_line(stderr, "warning: %s\n", journal.note().c_str());
    Studio studio(options);
    if (look)
      warn_of_bakes(options, {options.look}, options.look, *look, [&](const std::string& bake) {
        return studio.renderer().bake_key(make_request(*studio.scene(), options), bake);
      });
    report.machine = describe_machine(studio.device());
    Conductor conductor(&studio, &journal, folder, [&](const std::string& text) { progress.say(text); });
    conductor.run(&report);
    store_curves(studio.appearance_key(), budget_curves(report));
  }
  std::string chart_problem;
  write_outputs(folder, report, &chart_problem);
  if (!chart_problem.empty()) print_line(stderr, "warning: %s\n", chart_problem.c_str());
  print_line(stdout, "%s/report.html: %zu points (%d of this run, %d of earlier ones), %.0f s\n", folder.c_str(),
             report.points.size(), report.measured_now, report.reused, report.seconds);
  if (report.interrupted)
    throw Error("maquette report", "interrupted after " + std::to_string(report.points.size()) + " points",
                "the same command continues from there");
  return 0;
}

}  // namespace maquette
