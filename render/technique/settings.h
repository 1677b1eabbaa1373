#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace maquette {

using SettingValue = std::variant<bool, int, double, std::string>;

/// One declaration serves the command line, the panels, review files, the report and the manual.
/// The alternative held by `default_value` is the type; a string with `choices` is an enumeration.
struct SettingDeclaration {
  std::string name;  ///< `technique.setting`
  SettingValue default_value;
  double min = 0.0;  ///< numbers only; min == max means unbounded
  double max = 0.0;
  std::string unit = {};
  std::string help = {};
  std::vector<std::string> choices = {};
};

/// The declarations of every technique, in registration order.
const std::vector<SettingDeclaration>& setting_declarations();
const SettingDeclaration* find_setting(std::string_view name);

/// Values that differ from their declared default; unknown names and values out of range throw UsageError
/// ("did you mean ...").
class Settings {
 public:
  void set(const std::string& name, const SettingValue& value);
  /// Parses `text` by the declared type.
  void set_from_text(const std::string& name, const std::string& text);
  void reset(const std::string& name);
  const SettingValue& get(std::string_view name) const;
  bool get_bool(std::string_view name) const { return std::get<bool>(get(name)); }
  int get_int(std::string_view name) const { return std::get<int>(get(name)); }
  double get_double(std::string_view name) const { return std::get<double>(get(name)); }
  const std::string& get_string(std::string_view name) const { return std::get<std::string>(get(name)); }
  const std::map<std::string, SettingValue, std::less<>>& changed() const { return values_; }
  bool operator==(const Settings&) const = default;

 private:
  std::map<std::string, SettingValue, std::less<>> values_;
};

std::string to_text(const SettingValue& value);

}  // namespace maquette
