#include <algorithm>
#include <cmath>

#include "viewer/report/charts.h"
#include "viewer/report/page_parts.h"

namespace maquette::report {

namespace {

/// A frame time that every technique can meet: 2.5 times the fastest point of the slowest technique.
double common_time_ms(const std::vector<const Point*>& points, const Report& report) {
  double time = 0.0;
  for (const TechniqueEntry& technique : report.techniques) {
    double fastest = INFINITY;
    for (const Point* point : points)
      if (point->technique == technique.name) fastest = std::min(fastest, point->time_ms.median);
    // The path tracer is slower by orders of magnitude, and is ignored here.
    if (std::isfinite(fastest) && !technique.traces_picture) time = std::max(time, 2.5 * fastest);
  }
  return time;
}

/// The best picture within the time, or the fastest.
const Point* best_within(const std::vector<const Point*>& points, const std::string& technique, double time_ms) {
  const Point* best = nullptr;
  for (const Point* point : points) {
    if (point->technique != technique) continue;
    const bool within = point->time_ms.median <= time_ms, best_is = best != nullptr && best->time_ms.median <= time_ms;
    const bool better =
        best == nullptr || (within && !best_is) ||
        (within == best_is && (within ? point->figures.flip.value_or(1.0) < best->figures.flip.value_or(1.0)
                                      : point->time_ms.median < best->time_ms.median));
    if (better) best = point;
  }
  return best;
}

std::string image(const PageInput& input, const std::string& file, const std::string& what) {
  const std::optional<std::string> address = data_address(input.folder + "/" + file, "image/png");
  return address ? "<img alt=\"" + escape(what) + "\" src=\"" + *address + "\">"
                 : "<p class=\"note\">" + escape(file) + " is missing</p>";
}

}  // namespace

std::string gallery(const PageInput& input, const std::string& camera, Scope scope) {
  std::vector<const Point*> points;
  for (const Point& point : input.report.points)
    if (point.camera == camera && point.scope == scope && !point.picture.empty()) points.push_back(&point);
  if (points.empty()) return scope == Scope::model ? "<p class=\"note\">No picture was measured.</p>\n" : "";
  std::string html = "<div class=\"gallery\">\n";
  for (const CameraEntry& entry : input.report.cameras)
    if (scope == Scope::model && entry.name == camera && !entry.reference_picture.empty())
      html += "<figure>" + image(input, entry.reference_picture, "all light paths") +
              "<figcaption><b>reference</b>, all light paths</figcaption></figure>\n";
  const double time = common_time_ms(points, input.report);
  for (const TechniqueEntry& technique : input.report.techniques) {
    const Point* point = best_within(points, technique.name, time);
    if (point == nullptr) continue;
    html += "<figure>" + image(input, point->picture, technique.name) +
            image(input, point->difference, technique.name + ", FLIP") + "<figcaption><b>" + escape(technique.name) +
            "</b>, " + escape(point->quality) + ", " + time_text(point->time_ms.median);
    if (point->relative_rmse)
      html += "<br>relative RMSE " + error_text(point->relative_rmse->median, Metric::relative_rmse);
    if (point->figures.flip) html += ", FLIP " + error_text(*point->figures.flip, Metric::flip);
    html += "</figcaption></figure>\n";
  }
  return html + "</div>\n<p class=\"note\">Lower pictures: " + scope_name(scope) +
         " error, FLIP <span>0</span><span class=\"scale\" "
         "style=\"background:linear-gradient(90deg,#30123b,#4662d7,#36aaf9,#1ae4b6,#72fe5e,#c8ef34,#faba39,#f66b19,#"
         "ca2a04,"
         "#7a0403)\"></span>1</p>\n";
}

namespace {

const Curve* find_curve(const std::vector<Curve>& curves, const std::string& technique) {
  for (const Curve& curve : curves)
    if (curve.technique == technique) return &curve;
  return nullptr;
}

std::string times_text(double ratio) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", ratio);
  return text;
}

/// The fastest technique at the smallest target that at least two of them reach.
std::string fastest_line(const Report& report, Scope scope, Metric metric) {
  const bool many = report.cameras.size() > 1;
  const std::vector<Curve> curves = many                     ? mean_curves(report, scope, metric)
                                    : report.cameras.empty() ? std::vector<Curve>()
                                                             : curves_of(report, report.cameras[0].name, scope, metric);
  const std::vector<double> targets = metric == Metric::flip ? std::vector<double>{0.02, 0.05, 0.1, 0.2, 0.3}
                                                             : std::vector<double>{0.01, 0.02, 0.05, 0.1, 0.2, 0.5};
  const double floor = noise_floor(curves);
  for (const double target : targets) {
    std::vector<std::pair<double, std::string>> reached;
    for (const Curve& curve : curves)
      if (const std::optional<double> time = time_to_error(curve, target, floor))
        reached.emplace_back(*time, curve.technique);
    if (reached.size() < 2) continue;
    std::sort(reached.begin(), reached.end());
    std::string line = "To a" + std::string(scope == Scope::estimator ? "n " : " ") + scope_name(scope) + " error of " +
                       error_text(target, metric) + (metric == Metric::flip ? " FLIP" : " relative RMSE") + ", <b>" +
                       escape(reached[0].second) + "</b> is the fastest: " + time_text(reached[0].first) + " a frame";
    for (std::size_t i = 1; i < reached.size(); ++i)
      line += ", " + escape(reached[i].second) + " " + time_text(reached[i].first) + " (" +
              times_text(reached[i].first / reached[0].first) + " times)";
    return line + ".";
  }
  return {};
}

}  // namespace

std::string summary_section(const PageInput& input) {
  const Report& report = input.report;
  std::vector<std::string> lines;
  for (const auto& [scope, metric] :
       {std::pair{Scope::estimator, Metric::relative_rmse}, std::pair{Scope::estimator, Metric::flip},
        std::pair{Scope::model, Metric::flip}, std::pair{Scope::reflection, Metric::flip}}) {
    std::string line = fastest_line(report, scope, metric);
    if (!line.empty()) lines.push_back(std::move(line));
  }
  const bool many = report.cameras.size() > 1;
  const std::string camera = report.cameras.empty() ? "" : report.cameras[0].name;
  const std::vector<Curve> model =
      many ? mean_curves(report, Scope::model, Metric::flip) : curves_of(report, camera, Scope::model, Metric::flip);
  std::string smallest;
  for (const TechniqueEntry& technique : report.techniques)
    if (const Curve* curve = find_curve(model, technique.name))
      smallest += (smallest.empty() ? "" : ", ") + escape(technique.name) + " " +
                  best_error_text(*curve, Metric::flip, noise_floor(model));
  if (!smallest.empty()) lines.push_back("Smallest model error that was reached (FLIP): " + smallest + ".");
  std::string html = "<div class=\"summary\">\n" + explain_errors(report) + "<ul>\n";
  for (const std::string& line : lines) html += "<li>" + line + "</li>\n";
  if (lines.empty()) html += "<li>Too little was measured for a comparison.</li>\n";
  html += "</ul>\n<p class=\"small\">" + std::to_string(report.points.size()) + " points on " +
          std::to_string(report.cameras.size()) + (many ? " cameras" : " camera") + ", " +
          time_text(1e3 * report.seconds) + " of a budget of " + time_text(1e3 * report.budget_s) + " in this run; " +
          std::to_string(report.reused) + " points are of earlier runs.";
  html += "</p>\n";
  if (report.interrupted)
    html += "<p class=\"warn\">The run was interrupted: the same command continues from here.</p>\n";
  else if (!report.skipped.empty())
    html += "<p class=\"warn\">Not everything was measured, see below; the same command continues from here.</p>\n";
  if (!input.chart_problem.empty()) html += "<p class=\"warn\">" + escape(input.chart_problem) + "</p>\n";
  return html + "</div>\n";
}

}  // namespace maquette::report
