#pragma once

#include <map>
#include <string>

#include "viewer/report/data.h"

namespace maquette::report {

struct PageInput {
  const Report& report;
  std::string folder;                         ///< where the pictures are
  std::map<std::string, std::string> charts;  ///< SVG by Chart::name
  std::string chart_problem;                  ///< why there are none; empty: all is well
};

/// One self-contained HTML page with its pictures, charts and style, which can be mailed. Pictures that cannot be read
/// are left out with a note.
std::string page_html(const PageInput& input);

}  // namespace maquette::report
