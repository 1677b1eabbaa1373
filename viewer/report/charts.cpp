#include "viewer/report/charts.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "scenes/file_name.h"
#include "scenes/files.h"
#include "viewer/outputs.h"

namespace maquette::report {

namespace {

/// Distinguishable for colour-blind people, on white and on black, and from the grey front. Source: Okabe and Ito 2008,
/// some lightened or darkened for both backgrounds, three added.
constexpr const char* kColors[] = {"#e06c1f", "#2f86d0", "#18a076", "#c267a0", "#b8930f",
                                   "#7a5cc9", "#56b4e9", "#c0392b", "#7f9a2e", "#a0674b"};
constexpr double kMargin = 1.35;

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

struct Range {
  double low = 1e300, high = 0.0;
  void add(double value) {
    if (!(value > 0.0)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// `("1" 1, "2" 2, ...)`: finer over less than a decade, 1-2-5 over up to three, else powers of ten. `scale` and `unit`
/// apply to the labels. Labels are format strings, so a percent sign must be doubled.
std::string tics(const Range& range, double scale, const std::string& unit) {
  const double decades = std::log10(range.high / range.low);
  std::vector<double> digits = {1.0, 2.0, 5.0};
  if (decades < 1.0) digits = {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0};
  if (decades > 3.0) digits = {1.0};
  std::string list;
  for (double power = std::floor(std::log10(range.low)); power <= std::ceil(std::log10(range.high)); ++power) {
    for (const double digit : digits) {
      const double value = digit * std::pow(10.0, power);
      if (value < range.low || value > range.high) continue;
      list += (list.empty() ? "" : ", ") + ("\"" + text("%g", value * scale) + unit + "\" ") + text("%.6g", value);
    }
  }
  return "(" + list + ")";
}

std::string quoted(const std::string& value) {
  std::string result = "\"";
  for (const char c : value) result += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return result + "\"";
}

int run_gnuplot(const std::string& script_file) {
  const pid_t child = fork();
  if (child == 0) {
    const int null = open("/dev/null", O_WRONLY);
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
    execlp("gnuplot", "gnuplot", script_file.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

std::string technique_color(const std::vector<std::string>& techniques, const std::string& name) {
  const auto found = std::find(techniques.begin(), techniques.end(), name);
  return kColors[static_cast<std::size_t>(found - techniques.begin()) % std::size(kColors)];
}

std::vector<Chart> list_charts(const Report& report) {
  std::vector<Chart> charts;
  std::vector<std::string> names;
  for (const TechniqueEntry& technique : report.techniques) names.push_back(technique.name);
  const auto add = [&](const std::string& camera, Scope scope, Metric metric) {
    Chart chart;
    chart.camera = camera;
    chart.name = (camera.empty() ? "all-cameras" : "camera-" + file_name_of(camera)) + "-" + scope_name(scope) + "-" +
                 metric_name(metric);
    chart.title = error_title(scope) + (metric == Metric::flip ? ", FLIP" : ", relative RMSE");
    chart.metric = metric;
    chart.techniques = names;
    chart.curves = camera.empty() ? mean_curves(report, scope, metric) : curves_of(report, camera, scope, metric);
    for (const ReferenceEntry& entry : report.references)
      if (entry.camera == camera && entry.scope == scope && metric == Metric::relative_rmse) chart.noise = entry.noise;
    if (!chart.curves.empty()) charts.push_back(std::move(chart));
  };
  if (report.cameras.size() > 1)
    for (const Scope scope : kScopes)
      for (const Metric metric : {Metric::relative_rmse, Metric::flip}) add({}, scope, metric);
  for (const CameraEntry& camera : report.cameras)
    for (const Scope scope : kScopes)
      for (const Metric metric : {Metric::relative_rmse, Metric::flip}) add(camera.name, scope, metric);
  return charts;
}

std::string gnuplot_script(const Chart& chart, const std::string& svg_file) {
  Range time, error;
  for (const Curve& curve : chart.curves) {
    for (const CurvePoint& point : curve.points) {
      for (const double value : {point.time_low_ms, point.time_high_ms}) time.add(value);
      for (const double value : {point.error_low, point.error_high}) error.add(value);
    }
  }
  if (chart.noise > error.low / 3.0) error.add(chart.noise);
  for (Range* range : {&time, &error}) {
    range->low /= kMargin;
    range->high *= kMargin;
  }
  const bool percent = chart.metric == Metric::relative_rmse;
  const std::string ink = quoted(kChartInk);
  std::string script = "set terminal svg size 640,430 dynamic font \"Helvetica,Arial,sans-serif,15\" fontscale 1\n";
  script += "set output " + quoted(svg_file) + "\nset logscale xy\nset border 3 linecolor rgb " + ink + "\n";
  script += "set grid xtics ytics linecolor rgb \"#888888\" linewidth 0.4 dashtype 3\n";
  script += "set key outside bottom center horizontal Left reverse samplen 1.5 spacing 1.2 height 1 textcolor rgb " +
            ink + "\n";
  script += "set xlabel \"time of a frame (ms)\" offset 0,0.4 textcolor rgb " + ink + "\n";
  script += "set ylabel " + quoted(percent ? "relative RMSE" : "FLIP") + " textcolor rgb " + ink + "\n";
  script += "set xtics nomirror textcolor rgb " + ink + " " + tics(time, 1.0, "") + "\n";
  script +=
      "set ytics nomirror textcolor rgb " + ink + " " + tics(error, percent ? 100.0 : 1.0, percent ? " %%" : "") + "\n";
  script += "set xrange [" + text("%.6g", time.low) + ":" + text("%.6g", time.high) + "]\n";
  script += "set yrange [" + text("%.6g", error.low) + ":" + text("%.6g", error.high) + "]\n";
  std::string plots;
  const auto add = [&](const std::string& plot) { plots += (plots.empty() ? "plot " : ", \\\n     ") + plot; };
  script += "$front << EOD\n";
  for (const FrontPoint& point : pareto_front(chart.curves))
    script += text("%.6g", point.time_ms) + " " + text("%.6g", point.error) + "\n";
  script += "EOD\n";
  add("$front using 1:2 with steps linecolor rgb \"#999999\" linewidth 3.5 title \"Pareto front\"");
  int index = 0;
  for (const Curve& curve : chart.curves) {
    const std::string block = "$curve" + std::to_string(index++);
    script += block + " << EOD\n";
    for (const CurvePoint& p : curve.points) {
      for (const double v : {p.time_ms, p.error, p.time_low_ms, p.time_high_ms, p.error_low, p.error_high})
        script += text("%.6g", v) + " ";
      script += "\n";
    }
    script += "EOD\n";
    const std::string color = " linecolor rgb " + quoted(technique_color(chart.techniques, curve.technique));
    add(block + " using 1:2:3:4:5:6 with xyerrorbars pointtype 7 pointsize 0.1 linewidth 0.8" + color + " notitle");
    add(block + " using 1:2 with linespoints pointtype 7 pointsize 0.6 linewidth 2" + color + " title " +
        quoted(curve.technique) + " noenhanced");
  }
  if (chart.noise > error.low)
    add(text("%.6g", chart.noise) + " with lines dashtype 2 linewidth 1.2 linecolor rgb " + ink +
        " title \"noise of the reference\"");
  return script + plots + "\n";
}

std::optional<std::string> draw_chart(const Chart& chart, const std::string& folder, std::string* problem) {
  return draw_script(
      chart.name, folder, [&](const std::string& svg_file) { return gnuplot_script(chart, svg_file); }, problem);
}

std::optional<std::string> draw_script(const std::string& name, const std::string& folder,
                                       const std::function<std::string(const std::string& svg_file)>& script_for,
                                       std::string* problem) {
  std::filesystem::create_directories(folder);
  const std::string script_file = folder + "/" + name + ".gp", svg_file = folder + "/" + name + ".svg";
  const std::string part = svg_file + ".part";
  write_text(script_file, script_for(part));
  const int code = run_gnuplot(script_file);
  std::error_code error;
  std::string svg;
  if (code == 0) {
    const std::vector<std::byte> bytes = read_file(part);
    svg.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  std::filesystem::remove(part, error);
  if (code == 0 && svg.find("</svg>") != std::string::npos) {
    // The script stored in the folder draws the file of that folder.
    write_text(script_file, script_for(name + ".svg"));
    write_text(svg_file, svg);
    return svg;
  }
  *problem = code == 127 ? "gnuplot is not installed: no charts; install gnuplot-nox and run the same command again"
                         : "gnuplot failed on " + script_file + ": no chart " + name;
  return std::nullopt;
}

}  // namespace maquette::report
