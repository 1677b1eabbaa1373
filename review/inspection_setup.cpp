#include "review/inspection_setup.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "review/json_reader.h"

namespace maquette {

using Json = nlohmann::json;

namespace {

const std::vector<std::string> kEyes = {"middle", "left", "right"};
const std::vector<std::string> kLights = {"as it is", "lux on the glass", "night"};

const std::string& name_at(const std::vector<std::string>& names, int index) {
  return names[static_cast<std::size_t>(std::clamp(index, 0, static_cast<int>(names.size()) - 1))];
}

int index_of(JsonReader* reader, const std::string& key, const std::vector<std::string>& names) {
  return static_cast<int>(std::ranges::find(names, reader->choice(key, names)) - names.begin());
}

template <std::size_t kSize>
Json list_json(const std::array<float, kSize>& values) {
  Json json = Json::array();
  for (const float value : values) json.push_back(shortest(value));
  return json;
}

template <std::size_t kSize>
std::array<float, kSize> list_from(JsonReader* reader, const std::string& key) {
  std::array<float, kSize> values{};
  std::ranges::copy(reader->reals(key, kSize), values.begin());
  return values;
}

}  // namespace

const std::vector<std::string>& sweep_names() {
  static const std::vector<std::string> kNames = {"sun-elevation",    "sun-azimuth", "rake",
                                                  "dash-reflectance", "wedge",       "thickness"};
  return kNames;
}

std::array<float, 2> usual_range(int sweep) {
  // Degrees, degrees, degrees, a share, mrad, mm.
  static constexpr std::array<std::array<float, 2>, 6> kRanges = {
      {{10.0f, 80.0f}, {-90.0f, 90.0f}, {20.0f, 70.0f}, {0.0f, 0.2f}, {0.0f, 1.0f}, {3.0f, 7.0f}}};
  return kRanges[static_cast<std::size_t>(std::clamp(sweep, 0, static_cast<int>(kRanges.size()) - 1))];
}

const std::vector<std::string>& polarisation_names() {
  static const std::vector<std::string> kNames = {"all", "s", "p", "sunglasses"};
  return kNames;
}

Json inspection_json(const InspectionSetup& s) {
  return {{"colors", {{"from_cdm2", shortest(s.low_cdm2)}, {"to_cdm2", shortest(s.high_cdm2)}, {"in_ev", s.in_ev}}},
          {"threshold_cdm2", shortest(s.threshold_cdm2)},
          {"background_given", s.background_given},
          {"background_cdm2", shortest(s.background_cdm2)},
          {"polarisation", name_at(polarisation_names(), s.polarisation)},
          {"r_point_m", list_json(s.r_point_m)},
          {"right_hand_drive", s.right_hand_drive},
          {"eye_mm", list_json(s.eye_mm)},
          {"eye", name_at(kEyes, s.which_eye)},
          {"light", name_at(kLights, static_cast<int>(s.light))},
          {"lux_on_glass", shortest(s.lux_on_glass)},
          {"both_eyes", s.both_eyes},
          {"eye_grid", {s.grid[0], s.grid[1]}},
          {"eye_box_mm", list_json(s.eye_box_mm)},
          {"dash_given", s.dash_given},
          {"dash_reflectance", shortest(s.dash_reflectance)},
          {"sweep",
           {{"name", name_at(sweep_names(), s.sweep)}, {"range", list_json(s.sweep_range)}, {"steps", s.sweep_count}}}};
}

InspectionSetup inspection_from_json(const Json& json, const std::string& where) {
  JsonReader reader(json, where);
  InspectionSetup s;
  JsonReader colors(reader.member("colors"), reader.where("colors"));
  s.low_cdm2 = colors.real("from_cdm2", 1e-9f, kMostLuminance_cdm2);
  s.high_cdm2 = colors.real("to_cdm2", 1e-9f, 2.0f * kMostLuminance_cdm2);
  s.in_ev = colors.flag("in_ev");
  colors.finish();
  s.threshold_cdm2 = reader.real("threshold_cdm2", 0.0f, kMostLuminance_cdm2);
  s.background_given = reader.flag("background_given");
  s.background_cdm2 = reader.real("background_cdm2", 0.0f, kMostLuminance_cdm2);
  s.polarisation = index_of(&reader, "polarisation", polarisation_names());
  s.r_point_m = list_from<3>(&reader, "r_point_m");
  s.right_hand_drive = reader.flag("right_hand_drive");
  s.eye_mm = list_from<3>(&reader, "eye_mm");
  s.which_eye = index_of(&reader, "eye", kEyes);
  s.light = static_cast<InspectionSetup::Light>(index_of(&reader, "light", kLights));
  s.lux_on_glass = reader.real("lux_on_glass", 0.0f, 1e7f);
  s.both_eyes = reader.flag("both_eyes");
  const std::array<float, 2> grid = list_from<2>(&reader, "eye_grid");
  for (std::size_t i = 0; i < 2; ++i) s.grid[i] = std::clamp(static_cast<int>(grid[i]), 1, kMostGrid);
  s.eye_box_mm = list_from<2>(&reader, "eye_box_mm");
  for (float& side : s.eye_box_mm) side = std::clamp(side, 0.0f, kMostEyeBox_mm);
  s.dash_given = reader.flag("dash_given");
  s.dash_reflectance = reader.real("dash_reflectance", 0.0f, 1.0f);
  JsonReader sweep(reader.member("sweep"), reader.where("sweep"));
  s.sweep = index_of(&sweep, "name", sweep_names());
  s.sweep_range = list_from<2>(&sweep, "range");
  s.sweep_count = sweep.count("steps", 2, kMostSweepSteps);
  sweep.finish();
  reader.finish();
  return s;
}

}  // namespace maquette
