#pragma once

#include "render/frame/frame.h"
#include "render/frame/frame_constants.h"
#include "render/frame/plan.h"
#include "render/frame/request.h"
#include "render/gbuffer/raster.h"
#include "render/gbuffer/surfaces.h"
#include "render/gl/context.h"
#include "render/gl/program_cache.h"
#include "render/scene_state/scene_state.h"
#include "render/shading/light_samples.h"
#include "render/technique/registry.h"

namespace maquette {

class SceneBakes;

/// The frame at hand, as every pass may see it. Passes know besides only their own resources and what they are handed.
struct FrameContext {
  const DeviceInfo& device;
  ProgramCache& programs;
  const Registry& registry;
  SceneState& scene;
  SceneBakes& bakes;
  LightSamples& light_samples;
  Frame& frame;
  const Raster& raster;
  const FrameRequest& request;
  const FramePlan& plan;
  const FrameConstants& constants;  ///< of the default mode's layer
  int accumulated = 0;              ///< frames in the picture before this one

  PassTimer& timer() const { return frame.timer(); }
  const GridSize& size() const { return raster.size(); }
};

/// One layer of it: what one shading mode shades.
struct LayerContext {
  const FrameContext& frame;
  const ShadingPlan& plan;
  int index = 0;  ///< in FramePlan::layers
  const Surfaces& surfaces;
  const Texture& radiance;  ///< RGBA32F, of the grid, cd/m2; alpha 1 where it is shaded
  const FrameConstants& constants;
};

}  // namespace maquette
