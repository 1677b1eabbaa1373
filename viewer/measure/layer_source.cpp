#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "viewer/bake_lines.h"
#include "viewer/measure/measure_run.h"
#include "viewer/session.h"

namespace maquette {

namespace {

/// Layers as frames of a mode that rasterises.
class FrameLayers : public LayerSource {
 public:
  LayerPictures draw(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Environment>& environment,
                     const SceneOptions& options, bool with_ghost) override {
    if (scene != scene_) {
      renderer_.set_scene(scene);
      for (const auto& [name, source] : options.materials) renderer_.set_material(name, source);
      scene_ = scene;
    }
    if (environment != environment_) renderer_.set_environment(environment);
    environment_ = environment;
    FrameRequest request = make_request(*scene, options);
    prepare(request);
    LayerPictures out;
    out.transmitted = frame(request, "transmitted", options.frames);
    out.reflected = frame(request, "reflected", options.frames);
    if (!with_ghost) return out;
    request.settings.set("reflections.ghost", true);
    out.ghost = frame(request, "ghost", options.frames);
    return out;
  }

 private:
  Image frame(FrameRequest request, const std::string& layer, int frames) {
    request.settings.set("reflections.layer", layer);
    for (int i = 0; i < (frames > 0 ? frames : kFramesOfLayer); ++i) renderer_.render(request, true);
    return renderer_.read_radiance();
  }
  /// Figures without a bake would be those of another picture. Throws Error.
  void prepare(const FrameRequest& request) {
    if (renderer_.finish_background_work(request)) return;
    for (const std::string& line : missing_bake_lines(renderer_.render(request).status))
      throw Error("mode " + request.mode, line, "nothing was measured");
  }

  const GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Environment> environment_;
};

}  // namespace

std::unique_ptr<LayerSource> make_layer_source(const SceneOptions& options) {
  if (builtin_registry().find_mode(options.mode).can.traces_picture) return nullptr;
  return std::make_unique<FrameLayers>();
}

}  // namespace maquette
