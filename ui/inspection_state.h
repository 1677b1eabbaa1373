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
struct InspectionView : InspectionSetup {
  bool open = false;  ///< the tab is visible: only then is anything measured. Set by the panel in each frame
  bool false_color = false;
  std::vector<InspectedRegion> regions;
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
  std::string sweep_unit, sweep_measure;  ///< of `sweep_x` and `sweep_y`
  std::vector<float> sweep_x, sweep_y;    ///< mean reflected luminance, or ghost angle
  std::string sweep_title, job;           ///< what is being computed
  float job_share = 0.0f;
  double job_seconds_left = -1.0;                          ///< negative: not known yet
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
