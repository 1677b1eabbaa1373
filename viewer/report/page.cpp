#include "viewer/report/page.h"

#include "viewer/report/page_parts.h"
#include "viewer/report/page_style.h"

namespace maquette::report {

namespace {

std::string camera_section(const PageInput& input, const CameraEntry& camera) {
  std::string html = "<h2>Camera " + escape(camera.name) + "</h2>\n" + chart_grid(input, camera.name);
  html += "<h3>Pictures at about equal time, and where they differ from the reference</h3>\n";
  html += gallery(input, camera.name, Scope::model);
  const std::string reflections = gallery(input, camera.name, Scope::reflection);
  if (!reflections.empty()) html += "<h3>Reflections</h3>\n" + reflections;
  html += "<details><summary>All measured points of " + escape(camera.name) + "</summary>\n" +
          points_table(input.report, camera.name) + "</details>\n";
  return html;
}

std::string overview(const PageInput& input) {
  const Report& report = input.report;
  const bool many = report.cameras.size() > 1;
  std::string html = "<h2>" + std::string(many ? "Over all cameras" : "Time to an error") + "</h2>\n";
  if (many)
    html +=
        "<p class=\"lead\">Geometric means of time and error over the cameras; what follows shows them one by "
        "one.</p>\n" +
        chart_grid(input, {});
  const std::string camera = many ? std::string() : report.cameras.empty() ? std::string() : report.cameras[0].name;
  for (const auto& [scope, metric, title] :
       {std::tuple{Scope::estimator, Metric::relative_rmse,
                   "Time of a frame to a given estimator error (relative RMSE)"},
        std::tuple{Scope::estimator, Metric::flip, "Time of a frame to a given estimator error (FLIP)"},
        std::tuple{Scope::model, Metric::flip, "Time of a frame to a given model error (FLIP)"},
        std::tuple{Scope::reflection, Metric::flip, "Time of a frame to a given reflection error (FLIP)"}})
    if (scope != Scope::reflection || report.has(scope))
      html += "<h3>" + std::string(title) + "</h3>\n" + time_table(report, camera, scope, metric);
  return html;
}

}  // namespace

std::string page_html(const PageInput& input) {
  const Report& report = input.report;
  std::string html =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Error against run "
      "time: " +
      escape(report.scene) + "</title>\n<style>" + kPageStyle + "</style>\n</head>\n<body>\n";
  html += "<h1>Error against run time</h1>\n<p class=\"lead\">" + escape(report.scene) + ", light " +
          escape(report.environment) + ", " + std::to_string(report.width) + " × " + std::to_string(report.height) +
          " pixels";
  for (const NamedValue& entry : report.machine)
    if (entry.name == "date" || entry.name == "processor") html += ", " + escape(entry.value);
  html += "</p>\n" + summary_section(input) + overview(input);
  for (const CameraEntry& camera : report.cameras) html += camera_section(input, camera);
  html += left_out_section(report) + references_section(report) + machine_section(report) + reading_section();
  return html + "</body>\n</html>\n";
}

}  // namespace maquette::report
