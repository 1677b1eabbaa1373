#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/inspection/eye_points.h"
#include "ui/inspection_state.h"
#include "viewer/measure/measurement.h"

namespace maquette {

/// Pixels of a region of a picture of this size: x, y from the top left, width, height, at least 1.
glm::ivec4 pixels_of(const InspectedRegion& region, int width, int height);

/// What the tab Inspect asks `measure` for, in sweeps and exports alike: light, eyes, dashboard, threshold,
/// polarisation.
MeasureOptions measure_options_of(const InspectionSetup& setup);

/// What the tab Inspect measures of the scene that a window shows, by paths; size and samples are still open. Parts and
/// materials are taken as changed already.
SceneOptions inspected_options(const Look& shown, const std::string& scene);

bool has_r_point(const Scene& scene);

/// What the options do not name is as the review has it.
MeasureOptions measure_options_of(const Review& review, const Scene& scene, const SceneOptions& asked,
                                  const MeasureOptions& options);

/// The regions of a review, named by their numbers.
std::vector<PictureRegion> picture_regions(const std::vector<InspectedRegion>& regions, int width, int height);

/// The eye that a button asks for: 1 V1, 2 V2, 3 the view's own point; of a head's eyes the one that the view names.
glm::dvec3 eye_of_button(int button, const InspectionView& view, const glm::dvec3& r_point_m, const VehicleAxes& axes);

/// The camera moved to an eye, metres; it keeps its direction, and up is the vehicle's. For the window and `measure`.
CameraView camera_at_eye(CameraView camera, const glm::dvec3& eye, const VehicleAxes& axes);

/// `3989 +- 110 cd/m2`: two digits of the half-width, never with an exponent.
std::string interval_text(const Interval& interval);

/// A sweep that leaves the veil as it is: its trend is that of the ghost.
bool changes_glass_alone(const std::string& sweep);
/// A value for each step of a sweep: the largest mean of the reflected light, cd/m2, or of the ghost angle, arc
/// minutes, over all eyes that look through the pane; NaN without any.
std::vector<float> worst_of_steps(const Measurement& result, const std::vector<float>& steps, bool ghost);

/// The worst eye and step, light on the glass, veil per lux, in words.
std::vector<std::pair<std::string, std::string>> worst_rows(const Measurement& result);

}  // namespace maquette
