#pragma once

#include <numbers>

#include "scenes/error.h"
#include "viewer/measure/measurement.h"
#include "viewer/measure/traced_layers.h"

/// The steps of measure(); the window's probe takes them one by one.
namespace maquette {

/// What the settings say of the panes as sheets of glass.
struct GlassSheet {
  glm::dvec3 eye{0.0};
  double thickness_m = 0.0, wedge_rad = 0.0;
};

/// What all values of one eye depend on.
struct EyeContext {
  const Scene& scene;
  const MeasureOptions& options;
  int width, height;
  int pane;  ///< node
  GlassSheet sheet;
  std::optional<PaneLight> light;
  PathOptions paths;
  std::uint32_t seed = 0;
};

/// Of mode reference, unless --samples says otherwise.
constexpr int kPathsOfAPixel = 16;
/// In the mean of other modes' pictures, unless --frames says otherwise.
constexpr int kFramesOfLayer = 4;

/// Adds what the figures rest on, and what is not modelled.
void add_assumptions(const SceneOptions& scene_options, const MeasureOptions& options, const Scene& scene, int pane,
                     const std::string& dash, Measurement* measurement);

/// For a region without a pixel that shows the pane.
Error no_pane_in(const PictureRegion& region, const Scene& scene, int pane);

/// The R-point of the options, else the place of the node `r_point`. Throws Error where there is neither.
glm::dvec3 r_point_of(const Scene& scene, const MeasureOptions& options);
EyeRays eye_rays(const CameraView& camera, int width, int height, const Bounds& bounds);
std::vector<Sight> look_at_all(const PathScene& scene, const EyeRays& rays, const glm::dvec3& up);
/// The node of the options' pane. Throws where no pixel shows it, or any pane.
int pane_of(const Scene& scene, const std::string& name, const std::vector<Sight>& sights);
/// Throws UsageError for a region that reaches outside; without any, the whole picture.
std::vector<PictureRegion> checked_regions(const std::vector<PictureRegion>& asked, int width, int height);
/// Pixels of a region that show the pane.
std::vector<std::size_t> pane_pixels(const PictureRegion& region, int width, int pane,
                                     const std::vector<Sight>& sights);
/// Angle between both images of what a pixel mirrors, arc minutes.
double ghost_arcmin(const PaneSight& pane, const GlassSheet& sheet);
/// Luminance of the options' background through the pane of a pixel, cd/m2; nothing where none is given.
std::optional<double> background_through(const MeasureOptions& options, const Sight& sight);
/// Throws Error for a region without the pane.
RegionValues region_values(const EyeContext& context, const PictureRegion& region, const LayerPictures& pictures,
                           const std::vector<Sight>& sights);
TracedValue traced_value(const EyeContext& context, const PathScene& scene, const EyeRays& rays,
                         const std::vector<std::size_t>& pixels, const std::vector<Sight>& sights);
/// Throws UsageError for a pixel outside the picture.
ProbeValues probe_values(const EyeContext& context, glm::ivec2 pixel, const LayerPictures& pictures,
                         const std::vector<Sight>& sights);

}  // namespace maquette
