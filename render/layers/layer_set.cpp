#include "render/layers/layer_set.h"

#include "render/gl/bindings.h"

namespace maquette {

void Layer::bind() const {
  glBindBufferBase(GL_UNIFORM_BUFFER, kBlockFrame, block.get());
  surfaces.bind();
}

void Layer::add_bytes(std::map<std::string, std::size_t>* bytes) const {
  (*bytes)["gbuffer"] += surfaces.bytes() + own_triangles.bytes();
  (*bytes)["shading"] += surfaces.tiles().tiles.bytes() + radiance.bytes() + indirect.bytes() + shadows.bytes();
  if (surfaces.has_texture_bandwidth()) (*bytes)["texture_bandwidth"] += surfaces.texture_bandwidth().bytes();
  mode->add_bytes(bytes);
}

bool LayerSet::fit(const FramePlan& wanted, const GridSize& size, const Registry& registry,
                   const std::function<void(int)>& made) try {
  bool any = layers_.size() != wanted.layers.size();
  for (std::size_t k = wanted.layers.size(); k < layers_.size(); ++k) rest(&layers_[k]);
  layers_.resize(wanted.layers.size());
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    const ShadingPlan& shading = wanted.layers[k];
    std::unique_ptr<Layer>& layer = layers_[k];
    if (layer && layer->mode_name == shading.mode && layer->surfaces.size() == size &&
        layer->surfaces.has_texture_bandwidth() == shading.texture_bandwidth &&
        layer->surfaces.has_details() == wanted.details)
      continue;
    any = true;
    rest(&layer);  // both at once may not fit
    layer = std::make_unique<Layer>();
    layer->mode_name = shading.mode;
    const auto rested = at_rest_.find(shading.mode);
    layer->mode = rested == at_rest_.end() ? registry.find_mode(shading.mode).make_mode() : std::move(rested->second);
    if (rested != at_rest_.end()) at_rest_.erase(rested);
    layer->surfaces.fit(size, layer->mode->band_rows(size), shading.texture_bandwidth, wanted.details);
    layer->radiance = Texture::make_2d("radiance", GL_RGBA32F, size.grid_width(), size.grid_height());
    layer->mode->fit(size);
    made(static_cast<int>(k));
  }
  return any;
} catch (...) {
  layers_.clear();  // none half made
  throw;
}

void LayerSet::rest(std::unique_ptr<Layer>* layer) {
  if (*layer && (*layer)->mode && (*layer)->mode->keeps_tables())
    at_rest_[(*layer)->mode_name] = std::move((*layer)->mode);
  layer->reset();
}

void LayerSet::clear() {
  for (std::unique_ptr<Layer>& layer : layers_) rest(&layer);
  layers_.clear();
}

void LayerSet::add_bytes_at_rest(std::map<std::string, std::size_t>* bytes) const {
  for (const auto& [name, mode] : at_rest_) mode->add_bytes(bytes);
}

Continuation LayerSet::compare(const FrameChange& change) const {
  Continuation all{true, true};
  for (const auto& layer : layers_) {
    const Continuation one = layer->mode->compare(change);
    all.accumulates = all.accumulates && one.accumulates;
    all.keeps_points = all.keeps_points && one.keeps_points;
  }
  return all;
}

void LayerSet::begin(const FrameStart& start, FrameStatus* status) {
  for (const auto& layer : layers_) {
    layer->surfaces.begin_frame();
    layer->mode->begin(start, status);
  }
}

void LayerSet::set_constants(const FrameConstants& base, const FrameStart& start, const FramePlan& plan) {
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    Layer& layer = *layers_[k];
    layer.constants = base;
    layer.constants.quality.z = plan.layers[k].texture_bandwidth ? 1.0f : 0.0f;
    layer.mode->set_constants(start, plan.layers[k], &layer.constants);
    layer.block.update(0, sizeof layer.constants, &layer.constants);
  }
}

ShadingCounts LayerSet::counts() const {
  ShadingCounts sum;
  for (const auto& layer : layers_) {
    const ShadingCounts one = layer->mode->counts();
    sum.visible += one.visible;
    sum.shaded += one.shaded;
    sum.samples += one.samples;
  }
  return sum;
}

std::vector<Pass> surface_passes(const LayerContext& context, Layer* layer, const Parts& parts, SkyTiles* sky) {
  Pass pass{.names = {"gbuffer"}, .layer = context.index};
  pass.key = [&context, &parts] { return Key::of(context.frame.raster.revision(), parts.revision()); };
  pass.run = [&context, layer, &parts, sky] {
    ProgramCache* programs = &context.frame.programs;
    const Texture& all = context.frame.raster.triangle();
    if (!parts.several()) {
      layer->surfaces.find(context.frame.scene, all, sky, programs);
      return;
    }
    parts.split(all, context.index, &layer->own_triangles, programs);
    layer->surfaces.find(context.frame.scene, layer->own_triangles, nullptr, programs);
    if (context.index == 0) layer->surfaces.list_sky(all, sky, programs);
  };
  return {pass};
}

Pass shadow_pass(const LayerContext& context, Layer* layer, bool averages) {
  return {.names = {"draw_rays", "trace_rays"}, .layer = context.index, .run = [&context, layer, averages] {
            layer->shadows.run(context, averages);
          }};
}

Pass indirect_pass(const LayerContext& context, Layer* layer) {
  Pass pass{.names = {"indirect"}, .layer = context.index};
  pass.skip = [&context, layer] {
    return layer->indirect.is_current(context) ? std::string("its bake and the surfaces are those of before") : "";
  };
  pass.run = [&context, layer] { layer->indirect.run(context, layer->mode->changed_tiles()); };
  return pass;
}

}  // namespace maquette
