#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace maquette {

/// A JSON report as lines for people: `key: value`, nested objects indented, arrays one item a line.
std::string report_text(const nlohmann::ordered_json& report);
/// To standard output, as JSON or as those lines.
void print_report(bool json, const nlohmann::ordered_json& report);

}  // namespace maquette
