#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "viewer/report/data.h"
#include "viewer/report/figures.h"

namespace maquette::report {

/// One log-log chart of error against time.
struct Chart {
  std::string name;    ///< of its files
  std::string camera;  ///< empty: the mean over all
  std::string title;   ///< of the page
  Metric metric = Metric::relative_rmse;
  std::vector<Curve> curves;
  std::vector<std::string> techniques;  ///< all of the report: a technique has one colour everywhere
  double noise = 0.0;                   ///< of the reference; 0: not drawn
};

/// Over all cameras, then camera by camera; those without points are left out.
std::vector<Chart> list_charts(const Report& report);

/// The gnuplot script that draws `svg_file`. Text and axes have the placeholder colour kChartInk.
std::string gnuplot_script(const Chart& chart, const std::string& svg_file);
inline constexpr const char* kChartInk = "#010203";

/// Writes NAME.gp and NAME.svg into `folder`. Returns the SVG, or nothing with `problem` set when gnuplot is absent or
/// fails. Throws Error when the folder cannot be written.
std::optional<std::string> draw_chart(const Chart& chart, const std::string& folder, std::string* problem);

/// The same for any script; the argument of `script_for` is the SVG file that it must draw.
std::optional<std::string> draw_script(const std::string& name, const std::string& folder,
                                       const std::function<std::string(const std::string& svg_file)>& script_for,
                                       std::string* problem);

/// A technique's colour, the same in charts and page.
std::string technique_color(const std::vector<std::string>& techniques, const std::string& name);

}  // namespace maquette::report
