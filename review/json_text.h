#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "scenes/harmless.h"

namespace maquette {

/// All strings of a document, those that name members among them, through `change`; deeper ones than any of ours stay.
template <typename Json, typename Change>
Json with_strings(const Json& json, const Change& change, int depth = 0) {
  constexpr int kDeepest = 64;
  if (json.is_string()) return change(json.template get_ref<const std::string&>());
  if (!json.is_structured() || depth > kDeepest) return json;
  Json changed = json.is_array() ? Json::array() : Json::object();
  for (auto member = json.begin(); member != json.end(); ++member) {
    if (json.is_array())
      changed.push_back(with_strings(*member, change, depth + 1));
    else
      changed[change(member.key())] = with_strings(member.value(), change, depth + 1);
  }
  return changed;
}

/// JSON is UTF-8, and names of files need not be: their other bytes are written as private characters (as_utf8) and
/// read back as what they were.
template <typename Json>
std::string json_text(const Json& json, int indent = -1) {
  return with_strings(json, [](const std::string& text) { return as_utf8(text); }).dump(indent);
}
/// Throws nlohmann::json::exception.
template <typename Json = nlohmann::json>
Json json_from_text(const std::string& text) {
  return with_strings(Json::parse(text), [](const std::string& string) { return from_utf8(string); });
}

}  // namespace maquette
