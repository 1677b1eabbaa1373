#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/inspection/eye_points.h"
#include "render/inspection/sights.h"
#include "review/inspection_setup.h"
#include "review/look.h"

namespace maquette {

/// A rectangle of the picture in pixels, from the top left.
struct PictureRegion {
  std::string name;
  int x = 0, y = 0, width = 0, height = 0;
};

/// One quantity that a sweep varies, and its values.
struct Sweep {
  std::string name;  ///< one of sweep_names()
  std::vector<double> values;
};
/// Throws UsageError for a value that the quantity cannot have.
void check_sweep_value(const std::string& name, double value);

/// What `maquette measure` is asked for besides the shared options.
struct MeasureOptions {
  std::vector<glm::ivec2> probes;       ///< pixels from the top left
  std::vector<PictureRegion> regions;   ///< none: all pixels that show the pane
  std::string pane;                     ///< node; empty: `windshield`, or the pane that most pixels show
  std::optional<EyePlace> eye;          ///< absent: the camera's
  std::optional<glm::dvec3> r_point_m;  ///< in the scene; absent: the node `r_point`
  std::string axes = "-z,-x,+y";
  bool right_hand_drive = false;
  bool both_eyes = false;
  int grid_columns = 1, grid_rows = 1;
  glm::dvec2 eye_box_mm{100.0, 50.0};
  std::string dash;                        ///< material; empty: what the pane mirrors most
  std::optional<double> dash_reflectance;  ///< Lambertian, instead of the material's own
  std::optional<double> lux_on_glass;      ///< scales the environment
  std::optional<double> background_cdm2;   ///< for the contrast; absent: what is seen through the pane
  double threshold_cdm2 = 100.0;
  Polarisation polarisation = Polarisation::all;
  bool night = false;
  std::vector<Sweep> sweeps;
  int paths = 0;       ///< of the path-traced values with their intervals, a pixel; 0: none
  std::string layers;  ///< EXR file; empty: none
  /// What was done to the scene before it is measured, to be stated; absent: what the scene's options do.
  std::optional<Edits> edits;
};

}  // namespace maquette
