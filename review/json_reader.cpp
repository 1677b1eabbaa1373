#include "review/json_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/suggest.h"

namespace maquette {

using Json = nlohmann::json;

std::string read_text_file(const std::string& file) {
  constexpr std::size_t kLargest = 64u << 20u;  // as a tree eight times that
  const std::vector<std::byte> bytes = read_file(file, kLargest);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Json shortest(float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  double wide = 0.0;
  std::from_chars(text, end, wide);
  return wide;
}

JsonReader::JsonReader(const Json& json, std::string where) : json_(json), where_(std::move(where)) {
  if (!json.is_object()) throw Error(where_, "an object in braces is expected here", "see docs/formats.md");
}

std::string JsonReader::where(const std::string& key) const {
  return where_ + (where_.ends_with(": ") ? "" : ".") + key;
}

bool JsonReader::has(const std::string& key) {
  known_.insert(key);
  return json_.contains(key);
}

const Json& JsonReader::member(const std::string& key) {
  if (!has(key)) throw Error(where(key), "it is missing", "add it, as docs/formats.md says");
  return json_.at(key);
}

std::string JsonReader::text(const std::string& key) {
  const Json& value = member(key);
  if (!value.is_string()) throw Error(where(key), "a text in quotes is expected");
  return value.get<std::string>();
}

bool JsonReader::flag(const std::string& key) {
  const Json& value = member(key);
  if (!value.is_boolean()) throw Error(where(key), "true or false is expected");
  return value.get<bool>();
}

double JsonReader::number(const std::string& key, double min, double max) {
  const Json& value = member(key);
  if (!value.is_number()) throw Error(where(key), "a number is expected");
  const double number = value.get<double>();
  if (!(number >= min && number <= max))
    throw Error(where(key), value.dump() + " is out of range",
                "it goes from " + Json(min).dump() + " to " + Json(max).dump());
  return number;
}

float JsonReader::real(const std::string& key, float min, float max) {
  return static_cast<float>(number(key, static_cast<double>(min), static_cast<double>(max)));
}

int JsonReader::count(const std::string& key, int min, int max) {
  const double value = number(key, min, max);
  if (value != std::floor(value)) throw Error(where(key), "a whole number is expected");
  return static_cast<int>(value);
}

std::vector<float> JsonReader::reals(const std::string& key, std::size_t size) {
  const Json& value = member(key);
  const bool fits = value.is_array() && value.size() == size &&
                    std::all_of(value.begin(), value.end(),
                                [](const Json& v) { return v.is_number() && std::abs(v.get<double>()) < 1e30; });
  if (!fits) throw Error(where(key), std::to_string(size) + " numbers in brackets are expected");
  return value.get<std::vector<float>>();
}

std::vector<std::string> JsonReader::texts(const std::string& key) {
  const Json& value = list(key);
  for (const Json& v : value)
    if (!v.is_string()) throw Error(where(key), "texts in quotes are expected");
  return value.get<std::vector<std::string>>();
}

std::string JsonReader::choice(const std::string& key, const std::vector<std::string>& names) {
  std::string value = text(key);
  if (std::find(names.begin(), names.end(), value) == names.end())
    throw Error(where(key), "there is no \"" + value + "\"", did_you_mean(value, names));
  return value;
}

const Json& JsonReader::list(const std::string& key) {
  const Json& value = member(key);
  if (!value.is_array()) throw Error(where(key), "a list in brackets is expected");
  return value;
}

const Json& JsonReader::object(const std::string& key) {
  const Json& value = member(key);
  if (!value.is_object()) throw Error(where(key), "an object in braces is expected");
  return value;
}

void JsonReader::finish() const {
  for (const auto& [key, value] : json_.items())
    if (!known_.contains(key))
      throw Error(where(key), "this version knows no such member", did_you_mean(key, {known_.begin(), known_.end()}));
}

}  // namespace maquette
