#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/technique/compression_table.h"
#include "review/review.h"

/// The inspection of panes in the window, as plain values.
namespace maquette {

/// Settings of the inspection tab.
struct InspectionView {
  bool open = false;  ///< the tab is visible: only then is anything measured. Set by the panel in each frame
  bool false_color = false;
  bool in_ev = false;     ///< the scale of the false colours is in EV100 instead of cd/m2
  float low_cdm2 = 1.0f;  ///< ends of the scale; beyond them are the out-of-range colours
  float high_cdm2 = 1e4f;
  float threshold_cdm2 = 100.0f;
  int polarisation = 0;  ///< Polarisation
  std::vector<InspectedRegion> regions;
  std::array<float, 3> r_point_m{0.0f, 0.0f, 0.0f};
  bool right_hand_drive = false;
  std::array<float, 3> eye_mm{68.0f, -5.0f, 665.0f};  ///< own eye point: rearward, right, up from the R-point
  int which_eye = 0;                                  ///< of a head: 0 its middle, 1 left, 2 right
  /// Of sweeps and files: the light as it is, so many lux on the glass, or none from outside.
  enum class Light { as_is, given, night };
  Light light = Light::as_is;
  float lux_on_glass = 88900.0f;
  bool both_eyes = false;
  std::array<int, 2> grid{1, 1};  ///< eyes across and down the eye box of 100 x 50 mm
  bool dash_given = false;        ///< the dashboard is Lambertian with this reflectance
  float dash_reflectance = 0.13f;
  int sweep = 0;  ///< of sweep_names()
  std::array<float, 2> sweep_range{10.0f, 80.0f};
  int sweep_count = 8;
  std::array<char, 256> export_path{"inspection.csv"};
  std::optional<glm::vec2> stored_at;  ///< point whose stored light is shown: of the picture, 0 to 1 from the top left
};

/// What a bake has stored for a point.
struct StoredLightFacts {
  bool any = false;    ///< the picture is drawn with a bake of its mode
  std::string status;  ///< why nothing is shown; empty: nothing is wrong
  std::vector<std::pair<std::string, std::string>> values;
  struct Picture {
    std::string name;
    unsigned texture = 0;
  };
  std::vector<Picture> pictures;
  bool can_tabulate = false;              ///< the bake is compressed
  std::optional<double> tabulating;       ///< share that is done, while its table is computed
  std::optional<CompressionTable> table;  ///< of the bake, whatever point is shown
};

/// What was measured.
struct InspectionFacts {
  std::string status;  ///< what it waits for; empty: nothing
  std::string sun;     ///< where the sun is; empty: there is none
  struct Region {
    std::vector<std::pair<std::string, std::string>> values;
  };
  std::vector<Region> regions;
  std::vector<std::string> sweep_names;
  std::string sweep_unit;
  std::vector<float> sweep_x, sweep_y;  ///< mean reflected luminance, cd/m2
  std::string sweep_title, job;         ///< what is being computed
  float job_share = 0.0f;
  std::vector<std::pair<std::string, std::string>> worst;  ///< of the last sweep or export
  bool has_r_point = false;                                ///< the scene has a node r_point
};

/// What its buttons ask for.
struct InspectionActions {
  int eye_point = 0;  ///< 1: V1, 2: V2, 3: the own one
  bool run_sweep = false;
  bool export_files = false;
  bool cancel = false;
  bool tabulate_stored = false, stop_tabulating = false;
};

/// Display colour of a luminance between the ends of a logarithmic scale; blue below it, magenta above, black for none.
std::array<float, 3> luminance_color(float cdm2, float low_cdm2, float high_cdm2);
/// Exposure value at ISO 100 that a luminance meter shows: log2(L S / K) with K = 12.5 cd s/m2. Source: ISO 2720:1974.
float ev100_of(float cdm2);
/// Four significant digits, never with an exponent where a person reads a luminance: `0.03162`, `561.2`, `88900`.
std::string plain_number(double value);

}  // namespace maquette
