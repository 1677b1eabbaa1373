#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "scenes/harmless.h"
#include "scenes/json_fault.h"

namespace maquette {

/// Puts all strings of a document, those that name members among them, through `change`.
template <typename Json, typename Change>
void change_strings(Json* json, const Change& change) {
  if (json->is_string()) {
    *json = change(json->template get_ref<const std::string&>());
  } else if (json->is_array()) {
    for (Json& item : *json) change_strings(&item, change);
  } else if (json->is_object()) {
    Json changed = Json::object();
    for (auto member = json->begin(); member != json->end(); ++member) {
      change_strings(&member.value(), change);
      changed[change(member.key())] = std::move(member.value());
    }
    *json = std::move(changed);
  }
}

/// JSON is UTF-8, and names of files need not be: their other bytes are written as private characters (as_utf8) and
/// read back as what they were.
template <typename Json>
std::string json_text(Json json, int indent = -1) {
  change_strings(&json, as_utf8);
  return json.dump(indent);
}
/// Throws nlohmann::json::exception, also for what is nested deeper, or has more values, than any document of ours.
template <typename Json = nlohmann::json>
Json json_from_text(const std::string& text) {
  constexpr int kDeepest = 64;
  constexpr std::ptrdiff_t kMostValues = 2'000'000;
  if (has_too_many_values(text, kMostValues))
    throw Json::other_error::create(599, "it has more values than any of its kind", static_cast<Json*>(nullptr));
  if (is_nested_deeper(text, kDeepest))
    throw Json::other_error::create(599, "it is nested deeper than any of its kind", static_cast<Json*>(nullptr));
  Json json = Json::parse(text);
  change_strings(&json, from_utf8);
  return json;
}

}  // namespace maquette
