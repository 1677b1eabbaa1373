#pragma once

#include <optional>
#include <string>
#include <vector>

#include "viewer/report/figures.h"
#include "viewer/report/page.h"

/// Sections of the page; each returns HTML.
namespace maquette::report {

std::string escape(const std::string& text);
/// `12 ms`, `1.4 s`.
std::string time_text(double ms);
/// `4.1 %` of a relative error, `0.083` of FLIP.
std::string error_text(double error, Metric metric);

/// Of the best point that was measured; "≈" and the floor where the reference's noise hides it.
std::string best_error_text(const Curve& curve, Metric metric, double floor);
/// What the errors of the report are measured against, in a sentence each.
std::string explain_errors(const Report& report);

/// `data:` address of a file; nothing when it cannot be read.
std::optional<std::string> data_address(const std::string& path, const std::string& type);
/// An SVG of gnuplot's as an image that follows the reader's light or dark theme.
std::string chart_figure(const std::string& svg, const std::string& title);

std::string summary_section(const PageInput& input);
std::string chart_grid(const PageInput& input, const std::string& camera);
/// Time to each error by technique; all cameras when `camera` is empty.
std::string time_table(const Report& report, const std::string& camera, Scope scope, Metric metric);
/// Scope model or reflection; empty without a point of scope reflection.
std::string gallery(const PageInput& input, const std::string& camera, Scope scope);
std::string points_table(const Report& report, const std::string& camera);
std::string left_out_section(const Report& report);
std::string references_section(const Report& report);
std::string machine_section(const Report& report);
std::string reading_section();

}  // namespace maquette::report
