#include "viewer/report_text.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "scenes/harmless.h"
#include "viewer/print.h"

namespace maquette {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestText = 1000;

bool is_scalar(const Json& value) { return !value.is_structured(); }

std::string scalar_text(const Json& value) {
  if (value.is_null()) return "-";
  if (value.is_string()) return harmless(without_middle(value.get<std::string>(), kLongestText));
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (!value.is_number_float()) return value.dump();
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.5g", value.get<double>());
  return buffer;
}

std::string readable(std::string key) {
  std::replace(key.begin(), key.end(), '_', ' ');
  return harmless(without_middle(key, kLongestText));
}

void append(const Json& value, std::size_t indent, std::string* text);

void append_item(const std::string& key, const Json& value, std::size_t indent, std::string* text) {
  const std::string margin(indent, ' ');
  const bool short_array = value.is_array() && !value.empty() && value.size() <= 4 &&
                           std::all_of(value.begin(), value.end(), [](const Json& v) { return v.is_number(); });
  if (is_scalar(value)) {
    *text += margin + readable(key) + ": " + scalar_text(value) + "\n";
  } else if (value.empty()) {
    *text += margin + readable(key) + ": none\n";
  } else if (short_array) {
    *text += margin + readable(key) + ":";
    for (const Json& part : value) *text += " " + scalar_text(part);
    *text += "\n";
  } else {
    *text += margin + readable(key) + ":\n";
    append(value, indent + 2, text);
  }
}

/// Of a number whose name is not written.
const char* unit_of(const std::string& key) { return key.ends_with("_deg") ? " deg" : key.ends_with("_m") ? " m" : ""; }

/// An object in a list is one line: its first value, a colon, the others, lists with their names.
std::string object_line(const Json& object) {
  std::string line;
  std::size_t i = 0;
  for (const auto& [key, part] : object.items()) {
    if (i > 0) line += i == 1 ? ": " : "; ";
    if (is_scalar(part)) {
      line += scalar_text(part) + unit_of(key);
    } else {
      line += readable(key);
      for (const Json& value : part) line += (&value == &part.front() ? " " : ", ") + scalar_text(value);
    }
    ++i;
  }
  return line;
}

void append(const Json& value, std::size_t indent, std::string* text) {
  if (value.is_object()) {
    for (const auto& [key, item] : value.items()) append_item(key, item, indent, text);
    return;
  }
  for (const Json& item : value)
    *text += std::string(indent, ' ') + (item.is_object() ? object_line(item) : scalar_text(item)) + "\n";
}

}  // namespace

std::string report_text(const Json& report) {
  std::string text;
  append(report, 0, &text);
  return text;
}

void print_report(bool json, const nlohmann::ordered_json& report) {
  if (!json) return print_text(stdout, report_text(report));
  std::fputs((harmless_json(report.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n").c_str(), stdout);
}

}  // namespace maquette
