#pragma once

#include <string>

#include "viewer/measure/measurement.h"

namespace maquette {

/// One JSON object with every figure, assumption and what is not modelled; indented, with a final newline.
std::string measurement_json(const Measurement& measurement);
/// The same as CSV: comments with `#` for assumptions, then one line a region, eye and step, then one a probe.
std::string measurement_csv(const Measurement& measurement);
/// The main figures as lines for people.
std::string measurement_text(const Measurement& measurement);
/// EXR: the sum, and the layers reflected, transmitted, ghost (where drawn), `angles` (incidence of the nearest pane in
/// degrees, reflectance of front face and pane) of the last eye; the assumptions are attributes.
void write_layers(const std::string& path, const Measurement& measurement, const LastEye& last);

}  // namespace maquette
