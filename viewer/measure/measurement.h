#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/inspection/light_on_pane.h"
#include "render/inspection/sights.h"
#include "render/inspection/statistics.h"
#include "scenes/environment.h"
#include "scenes/image.h"
#include "scenes/scene.h"
#include "viewer/measure/measure_options.h"
#include "viewer/options.h"

/// What a pane adds to what an eye sees, as plain values; written by measure_files.h.
namespace maquette {

/// A path-traced mean over the same pixels.
struct TracedValue {
  Interval reflected, transmitted;  ///< cd/m2
  int paths = 0;                    ///< a pixel
};

struct RegionValues {
  std::string name;
  PictureRegion box;                             ///< of the pixels that were asked for
  std::size_t pane_pixels = 0;                   ///< of them, those that show the pane: what all values are of
  RegionStatistics reflected, transmitted, sum;  ///< cd/m2
  RegionStatistics incidence_deg, reflectance;   ///< of the pane
  double surface_reflectance = 0.0;              ///< mean of the front face alone
  double contrast = 1.0;                         ///< mean share that is kept
  std::optional<double> veil_per_lux;            ///< cd/m2/lx
  std::optional<double> flat_estimate_cdm2;      ///< E tau rho / pi R, mean over the pixels
  std::optional<RegionStatistics> ghost_arcmin;
  std::vector<std::pair<std::string, double>> mirrored;  ///< materials by share of the pixels, largest first
  std::optional<TracedValue> traced;
};

struct ProbeValues {
  glm::ivec2 pixel{0};
  Sight sight;
  double reflected = 0.0, transmitted = 0.0;  ///< cd/m2
  std::optional<double> ghost_arcmin;
  std::string pane, mirrored, behind;  ///< "node, material"
};

/// Of one eye at one step of the sweeps.
struct EyeValues {
  std::string eye;  ///< `camera`, `V1`, `left`, `row 1, column 2`, ...
  glm::dvec3 position{0.0};
  std::vector<std::pair<std::string, double>> step;  ///< of the sweeps
  /// The first region shows the pane, and nowhere its outer face: a sweep of rake may turn it past the eye, whose
  /// figures are then those of another sight.
  bool looks_through = true;
  std::optional<PaneLight> light;
  std::optional<SunPlace> sun;
  std::vector<RegionValues> regions;
  std::vector<ProbeValues> probes;
};

struct Measurement {
  std::vector<EyeValues> eyes;
  std::vector<std::pair<std::string, std::string>> assumptions;
  std::vector<std::string> not_modelled;
  /// Index in `eyes` of the largest mean veil of the first region, of those that look through the pane; of equal ones,
  /// of the largest mean ghost angle. Where none looks through it, it is none of them.
  std::size_t worst = 0;
};

/// Luminances of a picture's pixels, row by row from the top.
struct LayerPictures {
  Image reflected, transmitted;  ///< RGB(A), cd/m2
  std::optional<Image> ghost;
};

/// Where pictures come from: frames of a mode, or paths.
class LayerSource {
 public:
  virtual ~LayerSource() = default;
  virtual LayerPictures draw(const std::shared_ptr<const Scene>& scene,
                             const std::shared_ptr<const Environment>& environment, const SceneOptions& options,
                             bool with_ghost) = 0;
};
/// Frames of the options' mode by the renderer; needs a graphics context. For mode reference paths, without one.
std::unique_ptr<LayerSource> make_layer_source(const SceneOptions& options);

/// What was drawn for the last eye.
struct LastEye {
  LayerPictures pictures;
  std::vector<Sight> sights;
  SceneOptions options;
};
using MeasureProgress = std::function<void(double share)>;

/// Carries out what the options ask for. Both pointers may be null. Throws Error and UsageError.
Measurement measure(const SceneOptions& scene_options, const MeasureOptions& options,
                    const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Environment>& environment,
                    const MeasureProgress& progress = {}, LastEye* last = nullptr);

}  // namespace maquette
