#include "render/technique/settings.h"

#include <charconv>
#include <cmath>
#include <sstream>

#include "render/technique/registry.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

const std::vector<SettingDeclaration>& setting_declarations() {
  static const std::vector<SettingDeclaration> kDeclarations = [] {
    std::vector<SettingDeclaration> all;
    for (const Technique& technique : builtin_registry().techniques)
      all.insert(all.end(), technique.settings.begin(), technique.settings.end());
    return all;
  }();
  return kDeclarations;
}

const SettingDeclaration* find_setting(std::string_view name) {
  for (const SettingDeclaration& declaration : setting_declarations())
    if (declaration.name == name) return &declaration;
  return nullptr;
}

namespace {

const SettingDeclaration& require_setting(std::string_view name) {
  if (const SettingDeclaration* declaration = find_setting(name)) return *declaration;
  for (const LaterName& later : builtin_registry().later_settings) {
    if (later.name == name)
      throw Error(later.name, "this setting (" + later.help + ") is not available in this version", "leave it out");
  }
  std::vector<std::string> names;
  for (const SettingDeclaration& declaration : setting_declarations()) names.push_back(declaration.name);
  throw UsageError(std::string(name), "there is no such setting", did_you_mean(name, names));
}

std::string number_text(double value) { return to_text(SettingValue(value)); }

void check_range(const SettingDeclaration& declaration, double value) {
  if (!std::isfinite(value)) throw UsageError(declaration.name, "the value is not a finite number");
  if (declaration.min == declaration.max) return;
  if (value < declaration.min || value > declaration.max) {
    throw UsageError(declaration.name, number_text(value) + " is out of range",
                     "it goes from " + number_text(declaration.min) + " to " + number_text(declaration.max));
  }
}

void check_choice(const SettingDeclaration& declaration, const std::string& value) {
  if (declaration.choices.empty()) return;
  for (const std::string& choice : declaration.choices)
    if (choice == value) return;
  throw UsageError(declaration.name, "\"" + value + "\" is not one of its values",
                   did_you_mean(value, declaration.choices));
}

template <typename T>
T parse_number(const SettingDeclaration& declaration, const std::string& text, const char* kind) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end)
    throw UsageError(declaration.name, "\"" + text + "\" is not " + kind,
                     "for example " + to_text(declaration.default_value));
  return value;
}

bool parse_bool(const SettingDeclaration& declaration, const std::string& text) {
  if (text == "true" || text == "on" || text == "yes" || text == "1") return true;
  if (text == "false" || text == "off" || text == "no" || text == "0") return false;
  throw UsageError(declaration.name, "\"" + text + "\" is neither true nor false");
}

}  // namespace

std::string to_text(const SettingValue& value) {
  if (const bool* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const std::string* text = std::get_if<std::string>(&value)) return *text;
  char buffer[64];
  const auto result = std::holds_alternative<int>(value)
                          ? std::to_chars(buffer, buffer + sizeof(buffer), std::get<int>(value))
                          : std::to_chars(buffer, buffer + sizeof(buffer), std::get<double>(value));
  return std::string(buffer, result.ptr);
}

void Settings::set(const std::string& name, const SettingValue& value) {
  const SettingDeclaration& declaration = require_setting(name);
  SettingValue typed = value;
  // A whole number is a fine value for a real setting.
  if (std::holds_alternative<double>(declaration.default_value) && std::holds_alternative<int>(value))
    typed = static_cast<double>(std::get<int>(value));
  if (typed.index() != declaration.default_value.index())
    throw UsageError(name, "the value " + to_text(value) + " has the wrong type",
                     "the default is " + to_text(declaration.default_value));
  if (const int* whole = std::get_if<int>(&typed)) check_range(declaration, *whole);
  if (const double* real = std::get_if<double>(&typed)) check_range(declaration, *real);
  if (const std::string* text = std::get_if<std::string>(&typed)) check_choice(declaration, *text);
  if (typed == declaration.default_value)
    values_.erase(name);
  else
    values_[name] = typed;
}

void Settings::set_from_text(const std::string& name, const std::string& text) {
  const SettingDeclaration& declaration = require_setting(name);
  if (std::holds_alternative<bool>(declaration.default_value))
    set(name, parse_bool(declaration, text));
  else if (std::holds_alternative<int>(declaration.default_value))
    set(name, parse_number<int>(declaration, text, "a whole number"));
  else if (std::holds_alternative<double>(declaration.default_value))
    set(name, parse_number<double>(declaration, text, "a number"));
  else
    set(name, text);
}

void Settings::reset(const std::string& name) {
  require_setting(name);
  values_.erase(name);
}

const SettingValue& Settings::get(std::string_view name) const {
  if (const auto found = values_.find(name); found != values_.end()) return found->second;
  return require_setting(name).default_value;
}

}  // namespace maquette
