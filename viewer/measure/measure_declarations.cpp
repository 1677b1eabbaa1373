#include "viewer/measure/measure_declarations.h"

#include <algorithm>
#include <cmath>

#include "scenes/error.h"
#include "scenes/suggest.h"
#include "viewer/measure/measure_options.h"
#include "viewer/option_values.h"

namespace maquette {

namespace {

OptionDeclaration option(std::string name, std::string argument, std::string help,
                         std::function<void(MeasureOptions*, const std::string&)> apply, bool repeatable = false) {
  return {std::move(name),
          std::move(argument),
          std::move(help),
          {"measure"},
          [apply = std::move(apply)](CommandLine* line, const std::string& text) { apply(&line->measure, text); },
          repeatable};
}

std::vector<double> whole_numbers(const std::string& text, const std::string& what, std::size_t count,
                                  const std::string& form) {
  std::vector<double> values = parse_list(text, what, count, form);
  for (const double value : values)
    if (value != std::floor(value) || std::abs(value) > 1e6)
      throw UsageError(what, "\"" + text + "\" holds a number that is no pixel", "write whole numbers: " + form);
  return values;
}

void parse_region(MeasureOptions* o, const std::string& text) {
  const auto [name, box] = parse_pair(text, "--region", "NAME=x,y,width,height", true);
  const std::vector<double> v = whole_numbers(box, "--region " + name, 4, "x,y,width,height");
  if (v[2] < 1 || v[3] < 1) throw UsageError("--region " + name, "it has no pixels", "width and height start at 1");
  o->regions.push_back(
      {name, static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2]), static_cast<int>(v[3])});
}

/// `NAME=a,b,c` or `NAME=FROM:TO:COUNT`.
void parse_sweep(MeasureOptions* o, const std::string& text) {
  constexpr int kMostValues = 1000;
  const auto [name, values] = parse_pair(text, "--sweep", "NAME=FROM:TO:COUNT or NAME=a,b,c");
  const std::vector<std::string>& names = sweep_names();
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw UsageError("--sweep", "\"" + name + "\" cannot be varied", did_you_mean(name, names));
  const std::string what = "--sweep " + name;
  Sweep sweep{name, {}};
  if (values.find(':') != std::string::npos) {
    std::string list = values;
    std::replace(list.begin(), list.end(), ':', ',');
    const std::vector<double> v = parse_list(list, what, 3, "FROM:TO:COUNT");
    if (v[2] != std::floor(v[2]) || v[2] < 1 || v[2] > kMostValues)
      throw UsageError(what, "its count is not a whole number from 1 to 1000");
    for (int i = 0; i < static_cast<int>(v[2]); ++i)
      sweep.values.push_back(v[2] > 1 ? v[0] + (v[1] - v[0]) * i / (v[2] - 1.0) : v[0]);
  } else {
    const auto count = static_cast<std::size_t>(std::count(values.begin(), values.end(), ',')) + 1;
    sweep.values = parse_list(values, what, count, "a,b,c");
  }
  for (const double value : sweep.values) check_sweep_value(name, value);
  for (const Sweep& other : o->sweeps)
    if (other.name == name) throw UsageError(what, "it is given twice");
  o->sweeps.push_back(std::move(sweep));
}

Polarisation parse_polarisation(const std::string& text) {
  const std::vector<std::string>& names = polarisation_names();
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == text) return static_cast<Polarisation>(i);
  throw UsageError("--polarisation", "there is no \"" + text + "\"", did_you_mean(text, names));
}

std::vector<OptionDeclaration> eye_options() {
  using O = MeasureOptions;
  return {
      option("--eye-point", "V1|V2|x,y,z",
             "eye from the R-point instead of the camera's: V1, V2 (78/318/EEC) or millimetres rearward, right, up; it "
             "looks where the camera looks",
             [](O* o, const std::string& t) {
               EyePlace place{t, false};
               eye_from_r_point({0.0, 0.0, 0.0}, {}, place);
               o->eye = place;
             }),
      option("--r-point", "x,y,z", "R-point in metres of the scene (its node r_point)",
             [](O* o, const std::string& t) {
               const std::vector<double> v = parse_list(t, "--r-point", 3, "x,y,z");
               o->r_point_m = glm::dvec3(v[0], v[1], v[2]);
             }),
      option("--vehicle-axes", "AXES", "the scene's axes of rearward, right and up (-z,-x,+y)",
             [](O* o, const std::string& t) {
               vehicle_axes(t);
               o->axes = t;
             }),
      option("--right-hand-drive", "", "V1 and V2 are on the other side of the R-point",
             [](O* o, const std::string&) { o->right_hand_drive = true; }),
      option("--both-eyes", "", "left and right eye, 65 mm apart, instead of their middle",
             [](O* o, const std::string&) { o->both_eyes = true; }),
      option("--eye-grid", "CxR", "measures from C x R eyes in the eye box, and names the worst",
             [](O* o, const std::string& t) {
               const std::size_t x = t.find('x');
               if (x == std::string::npos) throw UsageError("--eye-grid", "\"" + t + "\" is not of the form CxR");
               o->grid_columns = static_cast<int>(parse_in(t.substr(0, x), "--eye-grid", 1, 32));
               o->grid_rows = static_cast<int>(parse_in(t.substr(x + 1), "--eye-grid", 1, 32));
             }),
      option("--eye-box", "WxH", "size of the eye box in millimetres (100x50)",
             [](O* o, const std::string& t) {
               const std::size_t x = t.find('x');
               if (x == std::string::npos) throw UsageError("--eye-box", "\"" + t + "\" is not of the form WxH");
               o->eye_box_mm = {parse_in(t.substr(0, x), "--eye-box", 0, 1000),
                                parse_in(t.substr(x + 1), "--eye-box", 0, 1000)};
             }),
  };
}

std::vector<OptionDeclaration> place_options() {
  using O = MeasureOptions;
  return {
      option(
          "--probe", "x,y", "everything about one pixel, from the top left",
          [](O* o, const std::string& t) {
            const std::vector<double> v = whole_numbers(t, "--probe", 2, "x,y");
            o->probes.push_back({static_cast<int>(v[0]), static_cast<int>(v[1])});
          },
          true),
      option("--region", "NAME=x,y,w,h", "statistics of the pixels of a rectangle that show the pane (all that do)",
             parse_region, true),
      option("--pane", "NODE", "the pane (windshield, else the one that most pixels show)",
             [](O* o, const std::string& t) { o->pane = t; }),
      option("--threshold", "CDM2", "regions tell the share of pixels above it (100)",
             [](O* o, const std::string& t) { o->threshold_cdm2 = parse_in(t, "--threshold", 0.0, 1e12); }),
      option("--background", "CDM2",
             "luminance of what should be seen, for the contrast (what is seen through the pane)",
             [](O* o, const std::string& t) { o->background_cdm2 = parse_in(t, "--background", 0.0, 1e12); }),
      option("--polarisation", "NAME",
             "counts all light, what the pane does to s or p alone, or what polarised sunglasses let through (all)",
             [](O* o, const std::string& t) { o->polarisation = parse_polarisation(t); }),
  };
}

}  // namespace

void check_sweep_value(const std::string& name, double value) {
  struct Range {
    const char* name;
    double least, most;
    const char* unit;
  };
  static constexpr Range kRanges[] = {
      {"sun-elevation", 3.0, 87.0, "degrees"}, {"sun-azimuth", -36000.0, 36000.0, "degrees"},
      {"rake", 5.0, 85.0, "degrees"},          {"dash-reflectance", 0.0, 1.0, "a share"},
      {"wedge", -20.0, 20.0, "mrad"},          {"thickness", 0.0, 50.0, "mm"}};
  for (const Range& r : kRanges)
    if (r.name == name && (value < r.least || value > r.most))
      throw UsageError("--sweep " + name, to_text(SettingValue(value)) + " is out of range",
                       "it goes from " + to_text(SettingValue(r.least)) + " to " + to_text(SettingValue(r.most)) +
                           " (" + r.unit + ")");
}

std::vector<OptionDeclaration> measure_option_declarations() {
  using O = MeasureOptions;
  std::vector<OptionDeclaration> all = place_options();
  for (OptionDeclaration& eye : eye_options()) all.push_back(std::move(eye));
  const std::vector<OptionDeclaration> light = {
      option("--dash", "MATERIAL", "the material that --dash-reflectance changes (what the pane mirrors most)",
             [](O* o, const std::string& t) { o->dash = t; }),
      option("--dash-reflectance", "X", "makes that material Lambertian with this reflectance, 0 to 1",
             [](O* o, const std::string& t) { o->dash_reflectance = parse_in(t, "--dash-reflectance", 0.0, 1.0); }),
      option("--lux-on-glass", "LX", "scales the environment to this illuminance on the pane's outer face",
             [](O* o, const std::string& t) { o->lux_on_glass = parse_in(t, "--lux-on-glass", 0.0, 1e7); }),
      option("--night", "", "no light from outside: displays and lamps of the scene alone",
             [](O* o, const std::string&) { o->night = true; }),
      option("--sweep", "NAME=VALUES",
             "measures at FROM:TO:COUNT or a,b,c of " + join(sweep_names()) +
                 " (degrees, share, mrad, mm); several are combined",
             parse_sweep, true),
      option("--confidence", "PATHS",
             "adds path-traced means of the same pixels with their 95 % interval, of so many paths a pixel",
             [](O* o, const std::string& t) { o->paths = static_cast<int>(parse_in(t, "--confidence", 8, 65536)); }),
      option("--layers", "FILE.exr",
             "pictures of the last eye: sum, and as layers reflected, transmitted, ghost, incidence and reflectance",
             [](O* o, const std::string& t) { o->layers = t; }),
  };
  all.insert(all.end(), light.begin(), light.end());
  return all;
}

}  // namespace maquette
