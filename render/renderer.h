#pragma once

#include <chrono>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/camera.h"
#include "render/geometry.h"
#include "render/plan.h"
#include "render/settings.h"
#include "scenes/brdf.h"
#include "scenes/environment.h"
#include "scenes/image.h"
#include "scenes/scene.h"

namespace maquette {

/// Everything one frame depends on besides scene, environment and materials.
struct FrameRequest {
  std::string mode = "bandwidth";
  CameraView camera;
  int width = 640;
  int height = 360;
  int msaa = 1;     ///< samples a pixel: 1, 4 or 16
  int samples = 0;  ///< shading samples a pixel before prediction scales it; 0: the mode's default
  std::uint32_t seed = 0;
  float env_rotation_rad = 0.0f;
  float env_scale = 1.0f;
  int variant = -1;
  std::string reflections = "off";      ///< reflector technique
  std::vector<std::string> reflectors;  ///< nodes that reflect; empty: those that the scene marks
  /// Seen by an eye only, through a tone curve: what cannot be told apart may be left out (`reflections.skip`).
  bool display = false;
  Settings settings;
  /// Mode reference stops tracing then, within a pass if need be.
  std::optional<std::chrono::steady_clock::time_point> deadline = {};
  bool operator==(const FrameRequest&) const = default;
};

struct PassTime {
  std::string name;
  double ms = 0.0;
  double cpu_ms = 0.0;  ///< processor time of the process, on a software device; else 0
};

struct FrameStats {
  double frame_ms = 0.0;
  std::vector<PassTime> passes;
  std::map<std::string, std::size_t> gpu_bytes;
  std::size_t visible_pixels = 0;
  std::size_t shaded_pixels = 0;
  std::size_t shading_samples = 0;
  int accumulated_frames = 1;  ///< frames averaged in the picture: grows while nothing moves
  std::map<std::string, double> technique;
  std::map<int, std::string> fits;  ///< by node: the patches that stand for a curved mirror, and how far they are off
  std::optional<double> estimated_error;  ///< relative RMSE of the picture so far, where the mode itself knows it
  FramePlan plan;
};

/// A background computation that a frame could use (the visibility bake): for the HUD.
struct BackgroundWork {
  std::string what;
  double fraction = 0.0;
};

/// Owns the GL resources of one scene and draws frames of it. Needs a current OpenGL 4.5 context for its whole life.
class Renderer {
 public:
  Renderer();
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  void set_scene(std::shared_ptr<const Scene> scene);
  void set_environment(std::shared_ptr<const Environment> environment);
  /// Replaces the BRDF of the material named so (`*`: all): a MERL path, `builtin:NAME`, `builtin:glass`; empty
  /// restores the file's own. Throws Error (unknown material: the names nearest) and then changes nothing.
  void set_material(const std::string& material_name, const std::string& source);
  /// New geometry of one mesh's primitive 0, same vertex count (dynamic geometry: dents).
  void update_mesh(int mesh, const std::vector<glm::vec3>& positions, const std::vector<glm::vec3>& normals);
  void set_node_visible(int node, bool visible);
  /// For a window: mode reference then traces on a thread of its own, `render` shows what there is so far and does not
  /// wait, and `accumulated_frames` counts the paths of a pixel.
  void set_interactive(bool interactive);

  /// Draws one frame into the radiance texture. With `accumulate`, averages with the frames before it
  /// while request, scene, materials and environment stay the same.
  FrameStats render(const FrameRequest& request, bool accumulate = false);
  /// Waits until background work that the plan of `request` wants is done (batch rendering). True when all is ready.
  bool finish_background_work(const FrameRequest& request);
  std::vector<BackgroundWork> background_work() const;

  /// The frame just drawn: linear RGBA, alpha 0 where only the sky is seen. Includes env_scale, no exposure.
  Image read_radiance() const;
  /// The same, tone mapped and display-encoded as `present` shows it.
  Image read_display(float exposure_ev, const std::string& tonemap) const;
  /// RGB variance of the picture's pixels, where the mode itself knows it (mode reference, not in a window).
  std::optional<Image> read_variance() const;
  /// One of debug_view_names() of the last frame: values in the unit of the view (the same in R, G, B for scalars),
  /// alpha 0 where only the sky is seen; at the shading grid's size. Throws Error when the frame's mode does not have
  /// it.
  Image read_debug_view(const std::string& name) const;
  static const std::vector<std::string>& debug_view_names();

  /// Draws the frame, or a debug view of it, tone mapped into the currently bound framebuffer's rectangle.
  void present(int x, int y, int width, int height, float exposure_ev, const std::string& tonemap,
               const std::string& debug_view = {});

  struct Pick {
    bool hit = false;
    int node = -1;
    int primitive = -1;
    int material = -1;
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f, 1.0f, 0.0f};
  };
  /// What the pixel (from the top left) of the last frame shows.
  Pick pick(int x, int y) const;

  const Scene& scene() const;
  const SceneFacts& facts() const;

  /// Copies of what the path tracer needs to see the scene as it is now, edits included: for a background thread.
  struct PathSnapshot {
    Scene scene;
    std::shared_ptr<const Environment> environment;
    FlatGeometry geometry;
  };
  PathSnapshot path_snapshot() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Display-encoded picture of a debug view's values: false colours, or the colours themselves for normals and base
/// colour.
Image debug_view_picture(const Image& values, const std::string& name);

/// `linear`, `reinhard`, `aces`, `agx`, `pbr-neutral`. Exposure first, then the curve, then the mean over the
/// `side` x `side` points of each pixel, then sRGB. Same formulas as the shader.
Image tone_map(const Image& points, float exposure_ev, const std::string& tonemap, int side = 1);
const std::vector<std::string>& tonemap_names();

}  // namespace maquette
