#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/bake/scene_bakes.h"
#include "render/frame/constants.h"
#include "render/glass/panes.h"
#include "render/glossy/glossy.h"
#include "render/layers/layer_set.h"
#include "render/picture/composer.h"
#include "render/reflections/reflections.h"
#include "render/renderer.h"
#include "render/shading/picture_mode.h"

namespace maquette {

/// What panes and mirrors show, and what draws it.
struct Mirrors {
  ReflectorSet reflectors;
  Reflections reflections;
  Glossy glossy;
  Blended blended;
  Panes panes;
};

/// Images of the frame that no layer owns.
struct Targets {
  Raster raster;
  SkyTiles sky;
  Composer composer;
  TextureSlots slots;
};

/// The picture of a mode that draws whole pictures.
struct WholePicture {
  std::string mode_name;
  std::unique_ptr<PictureMode> mode;
  Texture texture;  ///< of the picture, made when it is shown
  bool texture_stale = true;
};

/// The frame before, or the one at hand.
struct LastFrame {
  FrameRequest request;
  FramePlan plan;
  std::optional<Key> scene;  ///< all of scene, materials, environment and bakes
  FrameConstants constants{};
  int accumulated = 0;  ///< frames in its picture
  bool is_whole_picture = false;
};

/// What the renderer owns, and the steps of a frame. Included by renderer.cpp and renderer_views.cpp only.
struct Renderer::Impl {
  explicit Impl(const Registry& techniques) : registry(techniques), bakes(techniques) {}

  const Registry& registry;
  DeviceInfo device = query_device();
  ProgramCache programs;
  SceneState scene;
  SceneBakes bakes;
  LightSamples light_samples;
  Parts parts;
  LayerSet layers;
  Targets targets;
  Mirrors mirrors;
  WholePicture whole;
  Frame frame;
  LastFrame last;
  bool interactive = false;

  FrameRequest with_defaults(FrameRequest request) const {
    if (request.mode.empty()) request.mode = registry.default_mode;
    return request;
  }
  bool shows_whole_picture() const { return last.is_whole_picture && whole.mode && whole.mode->picture().width > 0; }
  glm::mat4 clip_of(const FrameRequest& request) const {
    return clip_from_world(make_camera_frame(request.camera, request.width, request.height, scene.bounds()));
  }
  /// Facts, reflectors and parts of what is asked.
  ViewInfo look_at(const FrameRequest& request);
  /// Brings up to date what `wanted` needs; says in the status what of it is there.
  FrameStatus prepare(const FrameRequest& request, const FramePlan& wanted);
  /// What this frame continues of the one before.
  FrameStart start(const FrameRequest& request, bool accumulate, bool layers_made, FrameStatus* status);
  void bind_layer(int layer);
  void carry_out(const FrameRequest& request, const FramePlan& plan, const FrameStart& start);
  std::vector<Pass> picture_passes(const MirroredScene& scene, const std::vector<ComposedLayer>& composed);
  FrameStats stats_of(const FramePlan& plan, const FrameStatus& status);
  FrameStats draw_whole_picture(const FrameRequest& request, const FramePlan& plan, bool accumulate);
  const Texture& picture();
  Image read_view(const std::string& name);
};

}  // namespace maquette
