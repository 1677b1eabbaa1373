#include "viewer/option_values.h"

#include <charconv>
#include <cmath>
#include <filesystem>

#include "render/technique/settings.h"
#include "scenes/error.h"

namespace maquette {

double parse_number(const std::string& text, const std::string& what) {
  double value = 0.0;
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value))
    throw UsageError(what, "\"" + text + "\" is not a number", "write one as 0.5 or 1e-3");
  return value;
}

double parse_in(const std::string& text, const std::string& what, double min, double max) {
  const double value = parse_number(text, what);
  if (value < min || value > max)
    throw UsageError(what, text + " is out of range", "it goes from " + to_text(min) + " to " + to_text(max));
  return value;
}

std::int64_t parse_count(const std::string& text, const std::string& what, std::int64_t min, std::int64_t max) {
  const double value = parse_in(text, what, static_cast<double>(min), static_cast<double>(max));
  if (value != std::floor(value)) throw UsageError(what, "\"" + text + "\" is not a whole number");
  return static_cast<std::int64_t>(value);
}

std::vector<double> parse_list(const std::string& text, const std::string& what, std::size_t count,
                               const std::string& form) {
  std::vector<double> values;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, comma - begin);
    values.push_back(part.empty() ? std::nan("") : parse_number(part, what));
    begin = comma + 1;
  }
  bool whole = values.size() == count;
  for (const double value : values) whole = whole && std::isfinite(value);
  if (!whole) throw UsageError(what, "\"" + text + "\" is not of the form " + form);
  return values;
}

std::pair<std::string, std::string> parse_pair(const std::string& text, const std::string& what,
                                               const std::string& form, bool last) {
  const std::size_t equals = last ? text.rfind('=') : text.find('=');
  if (equals == std::string::npos || equals == 0) throw UsageError(what, "\"" + text + "\" is not of the form " + form);
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::pair<std::string, std::string> parse_name_and_file(const std::string& text, const std::string& what,
                                                        const std::string& form) {
  for (std::size_t at = text.find('=', 1); at != std::string::npos; at = text.find('=', at + 1)) {
    const std::string file = text.substr(at + 1);
    std::error_code ignored;
    if (file.starts_with("builtin:") || (!file.empty() && std::filesystem::exists(file, ignored)))
      return {text.substr(0, at), file};
  }
  return parse_pair(text, what, form);
}

}  // namespace maquette
