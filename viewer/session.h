#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/renderer.h"
#include "scenes/ground.h"
#include "scenes/scene.h"
#include "viewer/options.h"

namespace maquette {

/// Loads the scene of the options, presses its dents, and moves its nodes as animation and turns say. Throws Error, and
/// UsageError when a name of the options (camera, variant, material) is not in the scene.
std::shared_ptr<Scene> load_session_scene(const SceneOptions& options);

/// The scene with the ground that the settings ask for, in the light of an environment that is rotated so; the same
/// scene where they ask for none.
std::shared_ptr<const Scene> with_ground(std::shared_ptr<const Scene> scene, const Environment& environment,
                                         const Settings& settings, float env_rotation_rad);
/// Of the settings `ground.height` and `ground.roughness`.
GroundOptions ground_options(const Settings& settings);
/// World bounds of what a view should show: all but an added ground.
Bounds framed_bounds(const Scene& scene);

/// Camera names of the scene (the camera's, else its node's), in node order.
std::vector<std::string> camera_names(const Scene& scene);
/// View of a camera by name. Throws UsageError with the nearest names.
CameraView camera_by_name(const Scene& scene, const std::string& name);
/// What the options ask for: camera, eye, target, up, field of view; without any, the scene's first camera, or a view
/// from the front and above that shows all of it.
CameraView camera_of_options(const Scene& scene, const SceneOptions& options);
/// Index of the variant; -1 for an empty name. Throws UsageError with the nearest names.
int find_variant(const Scene& scene, const std::string& name);
/// Throws UsageError with the nearest names when the scene has no material `name` (`*` is all).
void check_material_name(const Scene& scene, const std::string& name);

/// A line for the user where the scene's own lamps outshine an environment that is no brighter than a street at night:
/// most files are in units of their own. Empty otherwise. `remedy` is what to change, before the figure: "--env-scale".
/// `suited_env_scale`: the one at which the environment is as bright as a hall, where the line is not empty.
std::string units_warning(const Scene& scene, const Environment& environment, float env_scale,
                          const std::string& remedy, float* suited_env_scale = nullptr);
/// A line for the user where a scene's materials have neither gloss nor glass, as files have that know colours only.
/// Empty otherwise. `remedy`: what to do, the end of the line.
std::string gloss_warning(const Scene& scene, const std::string& remedy = "take measured ones from the library");

/// `--exposure`, or the one at which the environment looks right at once.
float exposure_of(const SceneOptions& options, const Environment& environment);

/// The state that the options ask for. Throws UsageError for a camera, a variant and a node that are not there.
Look look_of_options(const Scene& scene, const SceneOptions& options);

/// The options without what moves or changes the scene's geometry: a look has that.
SceneOptions without_edits(SceneOptions options);

/// With absolute paths, as reviews have them.
Look absolute_sources(Look look);

/// What a look leaves open of a frame.
struct FrameSize {
  int width = 640, height = 360;
  int msaa = 1;
  int samples = 0;  ///< 0: as the settings say
  std::uint32_t seed = 0;
  bool operator==(const FrameSize&) const = default;
};
/// The one place that derives what is drawn from a look. Variants and parts that the scene does not have are left out.
FrameRequest make_request(const Scene& scene, const Look& look, const FrameSize& size);
FrameRequest make_request(const Scene& scene, const SceneOptions& options);

}  // namespace maquette
