#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "render/frame/camera.h"
#include "render/scene_state/geometry.h"
#include "scenes/environment.h"
#include "scenes/image.h"
#include "scenes/scene.h"

/// The reference path tracer: the same scene, materials, tables and formulas as the other modes, without their
/// approximations. Knows no OpenGL. Build a PathScene once, then ask for single radiances (estimate_radiance) or for
/// pictures (ReferencePicture).
namespace maquette {

/// Everything that rays need: ray tracing hierarchy, materials with their tables, textures, lights, environment.
/// Immutable and safe to share between threads.
struct PathScene;
/// Measured materials that were already loaded; keep one library while scenes are rebuilt. Not thread-safe.
struct MeasuredMaterial;
using MeasuredLibrary = std::map<std::string, std::shared_ptr<const MeasuredMaterial>>;  // by measured_name

struct PathSceneInput {
  const Scene& scene;  ///< materials after overrides (material_overrides.h); hidden nodes are not visible
  std::shared_ptr<const Environment> environment;
  int variant = -1;
  const FlatGeometry* geometry = nullptr;  ///< of `scene`, where it has been edited; else `scene` is flattened
  MeasuredLibrary* library = nullptr;
};
/// Throws Error. Cost: the hierarchy (about a second for a million triangles) and tables that are not cached.
std::shared_ptr<const PathScene> build_path_scene(const PathSceneInput& input);

enum class Transport {
  full,    ///< all light paths
  direct,  ///< what `uniform` with shading.visibility=none estimates: the environment and the scene's lights,
           ///< unshadowed
};

struct PathOptions {
  Transport transport = Transport::full;
  float env_rotation_rad = 0.0f;
  float env_scale = 1.0f;  ///< cd/m2 per stored unit
  int max_bounces = 64;    ///< Russian roulette ends nearly all paths earlier
};

/// One unbiased estimate of the radiance (cd/m2 per channel) that arrives at `origin` from `direction` (unit, away from
/// it). `seed` names the point, `index` counts its estimates: a low-discrepancy sequence, best in powers of two.
/// Deterministic; thread-safe. `origin` must not lie on a surface: see offset_from_surface.
glm::vec3 estimate_radiance(const PathScene& scene, const PathOptions& options, const glm::vec3& origin,
                            const glm::vec3& direction, std::uint32_t seed, std::uint32_t index);

/// A point moved off its surface along the unit geometric normal `normal`, far enough that a ray from there does not
/// hit the surface because of rounding. `error`: bound of the rounding error of each coordinate of `position`. Source:
/// Pharr et al. 2023, "Physically Based Rendering", 4th ed., Sec. 6.8.6.
glm::vec3 offset_from_surface(const glm::vec3& position, const glm::vec3& error, const glm::vec3& normal);

struct PictureRequest {
  CameraView camera;
  int width = 640, height = 360;
  int msaa = 1;  ///< 1: rays through pixel centres; more: rays over the pixel's area
  std::uint32_t seed = 0;
  /// More paths where the picture is noisy: after the first few, the number of a pixel follows the standard deviation
  /// of its neighbours (not its own, which would bias its mean).
  bool adaptive = true;
  float footprint = 1.0f;  ///< of a pixel, for texture filtering: below 1 where pixels stand for finer ones
  PathOptions paths;
};

/// Time limit; none: no limit.
using Deadline = std::optional<std::chrono::steady_clock::time_point>;

struct ReferenceCounts {
  std::size_t paths = 0, rays = 0;
  std::size_t covered_pixels = 0;  ///< that show a surface other than panes
};

/// Pixels of a tile share light (path_sharing.h) and have equal numbers of paths; their noise is correlated.
constexpr int kTileWidth = 4, kTileHeight = 2;

/// A progressive picture. The result depends only on the seed and on the number of paths, not on the number of threads
/// or on how the calls divide the paths.
class ReferencePicture {
 public:
  ReferencePicture(std::shared_ptr<const PathScene> scene, const PictureRequest& request);
  ~ReferencePicture();
  ReferencePicture(ReferencePicture&&) noexcept;
  ReferencePicture& operator=(ReferencePicture&&) noexcept;

  /// Adds `count` paths a pixel (on average, where `adaptive`) on all cores. False when `stop` or `deadline` ended it
  /// early; the next call continues from there. With a deadline, one pixel in 64 still gets a path, and stands for its
  /// neighbours until they have their own. A deadline does not end the training of the guides before the first path,
  /// because the result would then depend on timing. `progress` in [0, 1], called from any thread, at most about 100
  /// times.
  bool add(int count, const std::stop_token& stop = {}, const std::function<void(double)>& progress = {},
           const Deadline& deadline = {});

  const PictureRequest& request() const;
  /// Paths a pixel (on average) of the complete passes.
  int samples() const;
  ReferenceCounts counts() const;
  /// RGBA, linear, cd/m2; alpha is the share of the pixel that shows a surface other than panes.
  Image mean() const;
  /// RGB variance of the mean: sample variance over the number of paths. The true variance is smaller because the paths
  /// are stratified.
  Image variance() const;
  /// sqrt(mean variance of the mean) over the mean luminance, pixels of alpha 1 only, as `relative_rmse` is defined;
  /// `whole`: over all pixels, sky included. 0 with fewer than two paths.
  double relative_error(bool whole = false) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace maquette
