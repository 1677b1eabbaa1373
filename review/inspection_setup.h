#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace maquette {

/// Under what the panes are inspected: all of the tab Inspect that decides a figure, apart from the regions.
struct InspectionSetup {
  bool in_ev = false;     ///< the scale of the false colours is in EV100 instead of cd/m2
  float low_cdm2 = 1.0f;  ///< ends of the scale; beyond them are the out-of-range colours
  float high_cdm2 = 1e4f;
  float threshold_cdm2 = 100.0f;
  bool background_given = false;  ///< the contrast is that of an object of this luminance, not of what is seen
  float background_cdm2 = 1000.0f;
  int polarisation = 0;  ///< Polarisation
  std::array<float, 3> r_point_m{0.0f, 0.0f, 0.0f};
  bool right_hand_drive = false;
  std::array<float, 3> eye_mm{68.0f, -5.0f, 665.0f};  ///< own eye point: rearward, right, up from the R-point
  int which_eye = 0;                                  ///< of a head: 0 its middle, 1 left, 2 right
  /// Of sweeps and files: the light as it is, so many lux on the glass, or none from outside.
  enum class Light { as_is, given, night };
  Light light = Light::as_is;
  float lux_on_glass = 88900.0f;
  bool both_eyes = false;
  std::array<int, 2> grid{1, 1};                   ///< eyes across and down the eye box
  std::array<float, 2> eye_box_mm{100.0f, 50.0f};  ///< its width and height
  bool dash_given = false;                         ///< the dashboard is Lambertian with this reflectance
  float dash_reflectance = 0.13f;
  int sweep = 0;  ///< of sweep_names()
  std::array<float, 2> sweep_range{10.0f, 80.0f};
  int sweep_count = 8;
  bool operator==(const InspectionSetup&) const = default;
};

/// Limits of what a review holds and a panel offers.
inline constexpr float kMostLuminance_cdm2 = 1e9f, kMostEyeBox_mm = 1000.0f;
inline constexpr int kMostGrid = 8, kMostSweepSteps = 24;

/// The quantities that a sweep varies, in the order of `InspectionSetup::sweep`.
const std::vector<std::string>& sweep_names();
/// From and to, in the quantity's own unit, where nothing else was asked for.
std::array<float, 2> usual_range(int sweep);
/// In the order of Polarisation.
const std::vector<std::string>& polarisation_names();

nlohmann::json inspection_json(const InspectionSetup& setup);
/// Throws Error that names the member under `where`.
InspectionSetup inspection_from_json(const nlohmann::json& json, const std::string& where);

}  // namespace maquette
