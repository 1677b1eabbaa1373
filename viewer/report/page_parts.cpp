#include "viewer/report/page_parts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "render/technique/settings.h"
#include "scenes/files.h"
#include "scenes/harmless.h"
#include "scenes/percent.h"
#include "viewer/report/charts.h"

namespace maquette::report {

namespace {

std::string base64(const std::vector<std::byte>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? std::to_integer<unsigned>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[word >> (18 - 6 * k) & 63u];
  }
  return text;
}

std::string replace_all(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

std::vector<std::string> technique_names(const Report& report) {
  std::vector<std::string> names;
  for (const TechniqueEntry& technique : report.techniques) names.push_back(technique.name);
  return names;
}

std::string dot(const Report& report, const std::string& technique) {
  return "<span class=\"dot\" style=\"background:" + technique_color(technique_names(report), technique) +
         "\"></span>" + escape(technique);
}

std::string reference_light(Scope scope) {
  static constexpr const char* kLight[] = {"direct light, unshadowed", "all light paths", "all reflection rays"};
  return kLight[static_cast<std::size_t>(scope)];
}

std::string row(const std::vector<std::string>& cells, const char* tag = "td") {
  std::string html = "<tr>";
  for (const std::string& cell : cells) html += std::string("<") + tag + ">" + cell + "</" + tag + ">";
  return html + "</tr>\n";
}

}  // namespace

std::string escape(const std::string& text) {
  std::string html;
  for (const char c : harmless(text, true))
    html += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  return html;
}

std::string time_text(double ms) {
  char text[32];
  if (ms >= 999.5)
    std::snprintf(text, sizeof text, "%.3g s", 1e-3 * ms);
  else
    std::snprintf(text, sizeof text, ms >= 99.5 ? "%.0f ms" : "%.2g ms", ms);
  return text;
}

std::string error_text(double error, Metric metric) {
  if (metric != Metric::flip) return percent_text(error);
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", error);
  return text;
}

std::string best_error_text(const Curve& curve, Metric metric, double floor) {
  const double error = best_error(curve);
  return error > floor ? error_text(error, metric) : "≈ " + error_text(floor, metric) + " or less";
}

std::string explain_errors(const Report& report) {
  static constexpr const char* kMeaning[] = {
      "against direct light without shadows, which the technique itself computes; more time makes it smaller",
      ("against all light paths: shadows and indirect light that a technique leaves out stay in it, however long it "
       "runs"),
      "of a reflector technique, against a ray for every pixel of every reflector"};
  std::string html = "<p class=\"small\">Errors: ";
  bool first = true;
  for (const Scope scope : kScopes) {
    if (!report.has(scope)) continue;
    html += std::string(first ? "" : "; ") + "<b>" + (first ? error_title(scope) : scope_name(scope) + " error") +
            "</b> " + kMeaning[static_cast<std::size_t>(scope)];
    first = false;
  }
  return first ? std::string() : html + ". How to read it, below, says more.</p>\n";
}

std::optional<std::string> data_address(const std::string& path, const std::string& type) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  return "data:" + type + ";base64," + base64(read_file(path));
}

std::string chart_figure(const std::string& svg, const std::string& title) {
  // Embedded as an image, so that its ids cannot clash with those of other charts; it still follows the theme.
  std::string themed = svg;
  for (const char* ink : {"rgb(  1,   2,   3)", "#010203", "rgb(1,2,3)"})
    themed = replace_all(themed, ink, "currentColor");
  // gnuplot's groups set their own value of currentColor.
  for (const char* own : {" color=\"black\"", " color=\"gray\""}) themed = replace_all(themed, own, "");
  const std::size_t tag_end = themed.find('>', themed.find("<svg"));
  themed.insert(tag_end + 1,
                "<style>:root{color:#1d2127}@media (prefers-color-scheme:dark){:root{color:#e4e7eb}}</style>");
  std::vector<std::byte> bytes(themed.size());
  std::transform(themed.begin(), themed.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return "<figure><figcaption>" + escape(title) + "</figcaption><img alt=\"" + escape(title) +
         "\" src=\"data:image/svg+xml;base64," + base64(bytes) + "\"></figure>\n";
}

std::string chart_grid(const PageInput& input, const std::string& camera) {
  std::string html;
  for (const Chart& chart : list_charts(input.report)) {
    const bool mine = camera.empty() ? chart.name.starts_with("all-cameras-") : chart.camera == camera;
    const auto svg = input.charts.find(chart.name);
    if (mine && svg != input.charts.end()) html += chart_figure(svg->second, chart.title);
  }
  return html.empty() ? std::string() : "<div class=\"charts\">\n" + html + "</div>\n";
}

std::string time_table(const Report& report, const std::string& camera, Scope scope, Metric metric) {
  const std::vector<Curve> curves =
      camera.empty() ? mean_curves(report, scope, metric) : curves_of(report, camera, scope, metric);
  if (curves.empty()) return "<p class=\"note\">Nothing was measured.</p>\n";
  std::vector<double> targets = metric == Metric::flip ? std::vector<double>{0.3, 0.2, 0.1, 0.05, 0.02}
                                                       : std::vector<double>{0.5, 0.2, 0.1, 0.05, 0.02, 0.01};
  const double floor = noise_floor(curves);
  // Columns without any entry are left out.
  std::erase_if(targets, [&](double target) {
    return std::none_of(curves.begin(), curves.end(),
                        [&](const Curve& c) { return time_to_error(c, target, floor).has_value(); });
  });
  std::string html = "<div class=\"wide\"><table>\n<tr><th>technique</th>";
  for (const double target : targets)
    html += "<th class=\"n\">" + (metric == Metric::flip ? to_text(SettingValue(target)) : error_text(target, metric)) +
            "</th>";
  html += "<th class=\"n\">best error measured</th></tr>\n";
  for (const Curve& curve : curves) {
    html += "<tr><td>" + dot(report, curve.technique) + "</td>";
    for (const double target : targets) {
      const std::optional<double> time = time_to_error(curve, target);
      const bool best = time && std::all_of(curves.begin(), curves.end(), [&](const Curve& other) {
                          return time_to_error(other, target).value_or(INFINITY) >= *time;
                        });
      html += std::string("<td class=\"n") + (best ? " best" : "") + "\">" + (time ? time_text(*time) : "–") + "</td>";
    }
    html += "<td class=\"n\">" + best_error_text(curve, metric, floor) + "</td></tr>\n";
  }
  html += "</table></div>\n";
  if (floor > 0.0)
    html += "<p class=\"note\">Errors up to " + error_text(floor, metric) +
            " are within the reference's own noise: they are marked ≈ and not ranked.</p>\n";
  return html;
}

std::string points_table(const Report& report, const std::string& camera) {
  std::string html =
      "<div class=\"wide\"><table>\n" + row({"technique", "quality", "against", "time", "repeats from – to",
                                             "relative RMSE", "FLIP", "SSIM", "graphics memory", "shading samples"},
                                            "th");
  for (const TechniqueEntry& technique : report.techniques) {
    for (const Point& p : report.points) {
      if (p.camera != camera || p.technique != technique.name) continue;
      char ssim[32];
      std::snprintf(ssim, sizeof ssim, "%.3f", p.figures.ssim.value_or(0.0));
      html += row({dot(report, p.technique), escape(p.quality), reference_light(p.scope), time_text(p.time_ms.median),
                   time_text(p.time_ms.low) + " – " + time_text(p.time_ms.high),
                   p.relative_rmse
                       ? (p.below_noise ? "≈ " : "") + error_text(p.relative_rmse->median, Metric::relative_rmse)
                       : "none",
                   p.figures.flip ? error_text(*p.figures.flip, Metric::flip) : "none", p.figures.ssim ? ssim : "none",
                   std::to_string(p.gpu_bytes >> 20) + " MiB", std::to_string(p.shading_samples)});
    }
  }
  return html + "</table></div>\n<p class=\"note\">≈: within 1.5 times the reference's own noise.</p>\n";
}

std::string references_section(const Report& report) {
  std::string html =
      "<h2>References</h2>\n<div class=\"wide\"><table>\n" +
      row({"camera", "light", "made by", "paths or samples a pixel", "own noise (relative RMSE)", "took"}, "th");
  for (const ReferenceEntry& entry : report.references)
    html +=
        row({escape(entry.camera), reference_light(entry.scope), escape(entry.made_by), std::to_string(entry.samples),
             error_text(entry.noise, Metric::relative_rmse), time_text(1e3 * entry.seconds)});
  return html + "</table></div>\n";
}

std::string machine_section(const Report& report) {
  std::string html = "<h2>Machine and versions</h2>\n<div class=\"wide\"><table>\n";
  for (const NamedValue& entry : report.machine) html += row({escape(entry.name), escape(entry.value)});
  return html + "</table></div>\n<p>Made by <code>" + escape(report.command) + "</code></p>\n";
}

std::string left_out_section(const Report& report) {
  // One row for each reason, with all techniques that give it.
  std::vector<LeftOutEntry> rows;
  for (const LeftOutEntry& entry : report.left_out) {
    const auto known = std::find_if(rows.begin(), rows.end(),
                                    [&](const LeftOutEntry& r) { return r.what == entry.what && r.why == entry.why; });
    if (known == rows.end())
      rows.push_back(entry);
    else
      known->technique += ", " + entry.technique;
  }
  std::string html =
      "<h2>What was left out, and why</h2>\n<div class=\"wide\"><table>\n" + row({"what", "why", "by"}, "th");
  std::size_t all = report.techniques.size();
  for (const LeftOutEntry& entry : rows) {
    const auto count = static_cast<std::size_t>(std::count(entry.technique.begin(), entry.technique.end(), ',')) + 1;
    html += row({"<code>" + escape(entry.what) + "</code>", escape(entry.why),
                 all > 1 && count == all ? "all" : escape(entry.technique)});
  }
  html += "</table></div>\n";
  if (report.skipped.empty()) return html;
  html += "<h3>Not measured</h3>\n<ul class=\"small\">\n";
  for (const std::string& line : report.skipped) html += "<li>" + escape(line) + "</li>\n";
  return html + "</ul>\n";
}

std::string reading_section() {
  return R"html(<h2>How to read it</h2>
<p><b>Estimator error</b> compares a technique with a reference that computes the same thing: light straight from the sky and
the lamps, without shadows. It is the technique's own error, and more time makes it smaller. <b>Model error</b> compares the
picture as a user gets it with all light paths: effects that the technique leaves out (shadows, indirect light) remain errors,
however long it runs. <b>Reflection error</b> compares a reflector technique with a ray for every pixel of every reflector, both in
mode splitsum, which has no noise: what is wrong or missing in the mirrored picture, over the whole picture, sky included.</p>
<p><b>Relative RMSE</b> is the root of the mean square difference over R, G and B, divided by the mean luminance of the
reference, over the pixels that show a surface. The reference is traced in two halves of independent seeds, and the square is the product of the
differences to both, so that its noise does not count as error. A few pixels that mirror
the sun can be nearly all of it. <b>FLIP</b> (Andersson et al. 2021, HDR) is the difference that a person sees who alternates between both pictures at 67 pixels a degree: 0
none, 1 the largest; a single bright pixel counts little. <b>SSIM</b>: Wang et al. 2004, on the picture as displayed.</p>
<p>A <b>time</b> is that of one frame, the median of the repeats after a warm-up; bars show the smallest and largest. The grey steps are
the <b>Pareto front</b>: no other point there is both faster and better. A dashed line is the reference's own noise: errors near it are
not to be trusted. Times to an error are read between two points, log-log.</p>
<p><b>Two runs</b> with the same seed draw the same pictures of a technique and count the same samples. They differ in their times, and in what
follows from times: how many paths the references have got (their pictures, their noise, and the errors by as much as that noise), which
points fit the budget, fronts and times to an error. A run that was stopped goes on with what it has measured.</p>
)html";
}

}  // namespace maquette::report
