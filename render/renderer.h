#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/bake/bake_keys.h"
#include "render/frame/camera.h"
#include "render/frame/request.h"
#include "render/frame/stats.h"
#include "render/picture/tonemap.h"
#include "render/scene_state/geometry.h"
#include "render/technique/compression_table.h"
#include "render/technique/point_report.h"
#include "render/technique/registry.h"
#include "render/views/pick.h"
#include "scenes/brdf.h"
#include "scenes/environment.h"
#include "scenes/image.h"
#include "scenes/scene.h"

namespace maquette {

/// A background computation that a frame could use (the visibility bake): for the HUD.
struct BackgroundWork {
  std::string what;
  double fraction = 0.0;
};

/// Owns the GL resources of one scene and draws frames of it. Needs a current OpenGL 4.5 context for its whole life.
class Renderer {
 public:
  /// `registry`: the techniques that it draws with; it must outlive the renderer.
  explicit Renderer(const Registry& registry = builtin_registry());
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
  /// The same scene with nodes elsewhere: materials, textures and what is hidden stay, meshes are as `scene` has them.
  /// False, and nothing is changed, where its geometry is no longer the same triangles: `set_scene` is for that.
  bool move_nodes(std::shared_ptr<const Scene> scene);
  /// Moves the base colour texture of the last material named so, in its UV coordinates, until the next scene.
  void set_texture_offset(const std::string& material_name, const glm::vec2& offset);
  /// For a window: modes that draw whole pictures then work on a thread of their own, `render` shows what there is so
  /// far and does not wait, and `accumulated_frames` counts the paths of a pixel.
  void set_interactive(bool interactive);

  /// Draws one frame into the radiance texture. With `accumulate`, averages with the frames before it
  /// while request, scene, materials and environment stay the same.
  FrameStats render(const FrameRequest& request, bool accumulate = false);
  /// The next frame is drawn as if it were the first: nothing of earlier ones is reused, averaged or compared with.
  /// Scene and bakes stay.
  void forget_frames();
  /// Waits until the bakes that the plan of `request` wants are done (batch rendering). False when one cannot be made
  /// (its `run` is hold): the others are there, and FrameStatus says which one is not.
  bool finish_background_work(const FrameRequest& request);
  std::vector<BackgroundWork> background_work() const;
  /// Keys of the bakes that `request` wants, for the scene as it is now; nothing is made for them. Nothing while it is
  /// not known which are wanted. Throws Error.
  std::optional<BakeKeys> bake_keys(const FrameRequest& request);
  /// Of one of them, whether it is known to be wanted or not; empty: no mode of the request draws with it, or nothing
  /// keeps it.
  std::string bake_key(const FrameRequest& request, const std::string& bake);

  /// The frame just drawn: linear RGBA, alpha 0 where only the sky is seen. Includes env_scale, no exposure.
  Image read_radiance() const;
  /// The same, tone mapped and display-encoded as `present` shows it.
  Image read_display(float exposure_ev, const std::string& tonemap) const;
  /// RGB variance of the picture's pixels, where the mode itself knows it.
  std::optional<Image> read_variance() const;
  /// One of debug_view_names() of the last frame: values in the unit of the view (the same in R, G, B for scalars),
  /// alpha 0 where only the sky is seen; at the shading grid's size. Throws Error when the frame's mode does not have
  /// it.
  Image read_debug_view(const std::string& name) const;
  /// Of the program's own registry.
  static const std::vector<std::string>& debug_view_names();

  /// Draws the frame, or a debug view of it, tone mapped into the currently bound framebuffer's rectangle.
  void present(int x, int y, int width, int height, float exposure_ev, const std::string& tonemap,
               const std::string& debug_view = {});

  using Pick = maquette::Pick;
  /// What the pixel (from the top left) of the last frame shows.
  Pick pick(int x, int y) const;
  /// What the bake that a point is drawn with has stored there; nothing where it is drawn with none. Throws Error.
  std::optional<PointReport> describe(const Pick& pick) const;
  /// Of the first bake of the last frame that is compressed; null where there is none.
  CompressionTableJob compression_table() const;

  const Scene& scene() const;
  const SceneFacts& facts() const;
  const Registry& registry() const;

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

/// Display-encoded picture of a debug view's values, of the program's own registry: false colours, or the colours
/// themselves for normals and base colour.
Image debug_view_picture(const Image& values, const std::string& name);

/// Every combination of shader and defines that some plan of the registry's techniques asks for.
std::vector<ShaderVariant> all_shader_variants(const Registry& registry = builtin_registry());

}  // namespace maquette
