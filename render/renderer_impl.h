#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/environment_buffers.h"
#include "render/frame_constants.h"
#include "render/frame_targets.h"
#include "render/gl/context.h"
#include "render/material_store.h"
#include "render/pass_timer.h"
#include "render/program_cache.h"
#include "render/renderer.h"
#include "render/scene_buffers.h"

namespace maquette {

/// A point light list, a visibility bake, prefiltered maps: made when a plan first needs them (render/*_resources.h).
struct Renderer::Impl {
  DeviceInfo device = query_device();
  ProgramCache programs;
  Buffer frame_block = Buffer("frame constants", sizeof(FrameConstants));
  std::shared_ptr<const Scene> scene;
  std::optional<SceneBuffers> buffers;
  SceneFacts facts;
  int facts_variant = -2;
  MaterialStore materials;
  std::map<std::string, std::string> overrides;  ///< material name (or `*`) -> source
  std::vector<Material> effective;               ///< the scene's materials with the overrides
  std::vector<int> slots;                        ///< BRDF slot of each effective material, and of the default one
  std::optional<EnvironmentBuffers> environment;
  std::optional<FrameTargets> targets;
  FrameConstants constants{};
  FrameRequest last_request;
  int accumulated = 0;
  std::uint32_t epoch = 0;  ///< raised by every change of scene, materials or environment
  std::uint32_t drawn_epoch = 0;
  FramePlan last_plan;
  std::size_t shaded_points = 0, shading_samples = 0, visible_points = 0;

  void require_ready() const;
  std::vector<Material> effective_materials(const std::map<std::string, std::string>& sources) const;
  void upload_materials();
  void prepare_constants(const FrameRequest& request, const FramePlan& plan, int samples, int chunk);
  void draw_gbuffer(const FramePlan& plan, PassTimer* timer);
  void predict(const FramePlan& plan, PassTimer* timer);
  void shade(const FramePlan& plan, int chunk, PassTimer* timer);
  void shade_band(const FramePlan& plan, int first_row, int rows, int chunk, PassTimer* timer);
  void fill(PassTimer* timer);
  void compose(float blend);
  void dispatch(const Program& program, int x, int y);
  void bind_frame() const;
};

}  // namespace maquette
