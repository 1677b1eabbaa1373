#include "render/reflections/mirrored_rays.h"

#include <algorithm>

#include "render/bake/scene_bakes.h"
#include "render/gbuffer/surfaces.h"
#include "render/gl/bindings.h"
#include "render/indirect/bind.h"
#include "render/reflections/pane_tint.h"
#include "render/shading/work_lists.h"

namespace maquette {

namespace {

ShaderVariant list_tiles_variant(bool rays) { return {"reflections/list_tiles.comp", "", {{"RAYS", flag(rays)}}}; }

ShaderVariant resolve_variant(bool textures, bool colors) {
  return {
      "gbuffer/resolve.comp",
      "",
      {{"REFLECTED", "1"}, {"TEXTURES", flag(textures)}, {"TEXTURE_BANDWIDTH", "0"}, {"VERTEX_COLORS", flag(colors)}}};
}

/// Of the light of reflected points.
struct Completion {
  bool layers = false, glossy = false, tint = false, shadows = false;
};
ShaderVariant compose_variant(const Completion& c) {
  return {"shading/compose.comp",
          "",
          {{"REFLECTED", "1"},
           {"STAGE", "1"},
           {"TEXTURES", "0"},
           {"INDIRECT", "0"},
           {"PANES", "0"},
           {"SHADOWS", flag(c.shadows)},
           {"LAYERS", flag(c.layers)},
           {"TINT", flag(c.tint)},
           {"GLOSSY", flag(c.glossy)}}};
}

const ShaderVariant kMean{"reflections/mean.comp", "", {}};

ShaderVariant layer_variant(bool add) { return {"reflections/blended_layer.comp", "", {{"ADD", flag(add)}}}; }

/// What the processor's rays may meet; null until that is of the geometry that is drawn.
const PathScene* path_scene_of(const FrameContext& frame) {
  const PathScene* scene = frame.bakes.shadow_scene().scene().get();
  return scene && scene->geometry.indices.size() == frame.scene.geometry().indices.size() ? scene : nullptr;
}

/// What the rays hit is known.
class GivenHits : public ReflectorTechnique {
  void trace(const ReflectionFrame&) override {}
};

}  // namespace

int reflection_divisor(const Settings& settings, bool at_rest) {
  const std::string& resolution = settings.get_string("reflections.resolution");
  if (resolution == "auto") return at_rest ? 1 : 2;
  return resolution == "full" ? 1 : resolution == "half" ? 2 : 4;
}

std::vector<ShaderVariant> MirroredRays::shader_variants() {
  std::vector<ShaderVariant> variants{list_tiles_variant(false), list_tiles_variant(true)};
  for (int k = 0; k < 4; ++k) variants.push_back(resolve_variant(k & 1, k & 2));
  for (const bool add : {false, true}) variants.push_back(layer_variant(add));
  variants.push_back(kMean);
  for (int k = 0; k < 16; ++k) {
    const Completion c{(k & 1) != 0, (k & 2) != 0, (k & 4) != 0, (k & 8) != 0};
    if (!(c.layers && c.shadows)) variants.push_back(compose_variant(c));
  }
  return variants;
}

void MirroredRays::fit(const GridSize& grid, int divisor) {
  const int width = grid.grid_width(), height = grid.grid_height();
  if (targets_ && targets_->divisor == divisor && targets_->width == group_count(width, divisor) &&
      targets_->height == group_count(height, divisor))
    return;
  targets_.emplace(make_reflection_targets(width, height, divisor));
}

void MirroredRays::bind_constants(const MirroredScene& scene, int samples) {
  const FrameContext& frame = scene.frame;
  const ReflectionTargets& t = *targets_;
  constants_ = frame.constants;
  constants_.size = glm::ivec4(t.width, t.height, 1, 0);
  constants_.forward.w = frame.constants.forward.w * static_cast<float>(t.divisor);
  constants_.sampling = glm::ivec4(samples, std::max(samples / kMostReflectedItems, 2),
                                   (frame.accumulated + 1) * samples, frame.constants.sampling.w ^ 0x5bd1e995);
  if (!block_) block_ = Buffer("reflection constants", sizeof(FrameConstants));
  block_.update(0, sizeof constants_, &constants_);
  glBindBufferBase(GL_UNIFORM_BUFFER, kBlockFrame, block_.get());
  glBindBufferBase(GL_UNIFORM_BUFFER, kBlockReflectors, scene.reflectors.block().get());
}

void MirroredRays::list_tiles(ProgramCache* programs, bool rays) {
  ReflectionTargets& t = *targets_;
  if (!tile_count_) tile_count_ = Buffer("reflected tile count", sizeof(unsigned));
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferTileCounts, tile_count_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPaneTiles, t.tiles.tiles.get());
  tile_count_.clear_to_zero();
  dispatch_list(programs->get(list_tiles_variant(rays)),
                group_count(t.width, kTileSide) * group_count(t.height, kTileSide));
  unsigned count = 0;
  tile_count_.read(0, sizeof count, &count);
  t.tiles.counts.assign(1, static_cast<int>(count));
}

ReflectionFrame MirroredRays::reflection_frame(const MirroredScene& scene, const FollowRule& rule,
                                               const std::vector<bool>& occluding) {
  const FrameContext& frame = scene.frame;
  const OctreeStore& octree = frame.bakes.octree();
  return {&constants_,
          &frame.scene.buffers(),
          &scene.reflectors.all(),
          &occluding,
          frame.scene.revisions().geometry,
          frame.scene.facts().has_mask ? path_scene_of(frame) : nullptr,
          octree.ready() ? &octree.buffers() : nullptr,
          octree.cells(),
          rule.ghost,
          rule.fits,
          &frame.request.settings,
          &*targets_,
          &frame.programs,
          &frame.timer(),
          [this](const Program& program) { dispatch_tiles(program, targets_->tiles, kPerPoint); }};
}

void MirroredRays::follow(const MirroredScene& scene, const FollowRule& rule) {
  const ReflectionTargets& t = *targets_;
  glBindTextureUnit(kUnitRayOrigin, t.ray_origin.get());
  glBindTextureUnit(kUnitRayDirection, t.ray_direction.get());
  const std::vector<bool> occluding = scene.frame.scene.occluding_items();
  const ReflectionFrame frame = reflection_frame(scene, rule, occluding);
  if (!rule.keeps_hits) {
    find_hits(scene, rule, frame);
    if (rule.finds_tint) find_tint(scene, rule);
  }
  glBindTextureUnit(kUnitTriangle, t.triangle.get());
  glBindTextureUnit(kUnitSurface, t.surface.get());
  if (t.details) glBindTextureUnit(kUnitDetails, t.details.get());
  glBindTextureUnit(kUnitDepth, t.depth.get());
  shade_hits(scene, rule);
  complete(scene, rule, frame);
  add_layers(scene, rule);
  average(scene, rule);
}

void MirroredRays::find_hits(const MirroredScene& scene, const FollowRule& rule, const ReflectionFrame& frame) {
  ReflectionTargets& t = *targets_;
  if (rule.lists_tiles) list_tiles(&scene.frame.programs, true);
  if (!scene.frame.plan.details)
    t.details = Texture();
  else if (!t.details)
    t.details = make_details(t.width, t.height);
  if (t.details) bind_details_for_writing(t.details);
  const float none = 0.0f;
  glClearTexImage(t.depth.get(), 0, GL_RED, GL_FLOAT, &none);
  rule.technique.trace(frame);
  if (rule.technique.resolves()) return;
  const SceneBuffers& buffers = scene.frame.scene.buffers();
  glBindTextureUnit(kUnitTriangle, t.triangle.get());
  glBindImageTexture(kImageSurface, t.surface.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
  glBindImageTexture(kImageDepth, t.depth.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  glBindImageTexture(kImageGuide, t.guide.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32UI);
  dispatch_tiles(scene.frame.programs.get(resolve_variant(buffers.has_textures(), buffers.has_colors())), t.tiles,
                 kPerPoint);
  scene.frame.timer().end("reflected gbuffer");
}

void MirroredRays::find_tint(const MirroredScene& scene, const FollowRule& rule) {
  ReflectionTargets& t = *targets_;
  const FrameContext& frame = scene.frame;
  const PathScene* panes = path_scene_of(frame);
  if (!panes || !frame.scene.facts().has_glass) {
    t.tint = Texture();
    layers_ = {};
    return;
  }
  if (!t.tint) t.tint = Texture::make_2d("tint of panes", GL_RGBA16, t.width, t.height);
  // A pane does not tint what it mirrors itself.
  std::vector<TriangleRange> own;
  for (std::size_t k = 0; !rule.glossy && k < scene.reflectors.all().size(); ++k) {
    const DrawItem& item = frame.scene.geometry().items[scene.reflectors.all()[k].item];
    own.push_back({item.first_index / 3, (item.first_index + item.index_count) / 3});
  }
  // Surfaces that blend are shaded with what glossy ones mirror by themselves alone.
  find_pane_tint(*panes, own, &t, rule.glossy ? nullptr : &layers_);
}

void MirroredRays::average(const MirroredScene& scene, const FollowRule& rule) {
  frames_ = rule.averages ? frames_in_mean(rule) : 0;
  if (!rule.averages) return;
  ReflectionTargets& t = *targets_;
  if (!t.mean) t.mean = Texture::make_2d("mean of mirrored light", GL_RGBA32F, t.width, t.height);
  const Program& program = scene.frame.programs.get(kMean);
  program.set("u_blend", 1.0f / static_cast<float>(frames_));
  glBindImageTexture(kImageRadiance, t.radiance.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(kImageMean, t.mean.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  dispatch_tiles(program, t.tiles, kPerPoint);
  scene.frame.timer().end("reflected shade");
}

void MirroredRays::add_layers(const MirroredScene& scene, const FollowRule& rule) {
  if (layers_[0].empty()) {
    layer_.reset();
    return;
  }
  const FrameContext& frame = scene.frame;
  if (!layer_) layer_ = std::make_unique<MirroredRays>();
  layer_->fit(frame.size(), targets_->divisor);
  ReflectionTargets &own = *targets_, &t = layer_->targets();
  if (!t.tint) t.tint = Texture::make_2d("tint of a layer", GL_RGBA16, t.width, t.height);
  GivenHits hits;
  frame.timer().count_all_as("reflected shade");
  for (const std::vector<MirroredLayer>& layer : layers_) {
    if (layer.empty()) break;
    const auto run = [&](bool add) {
      const Program& program = frame.programs.get(layer_variant(add));
      program.set("u_count", static_cast<int>(layer.size()));
      dispatch_list(program, static_cast<int>(layer.size()));
    };
    const Buffer list = Buffer::from("mirrored layer", layer);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferMirroredLayer, list.get());
    glBindTextureUnit(kUnitRayOrigin, own.ray_origin.get());
    glBindTextureUnit(kUnitRayDirection, own.ray_direction.get());
    const float none[4] = {};
    const GLuint no_triangle = 0;
    glClearTexImage(t.ray_direction.get(), 0, GL_RGBA, GL_FLOAT, none);
    glClearTexImage(t.triangle.get(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &no_triangle);
    glBindImageTexture(kImageRayOrigin, t.ray_origin.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(kImageRayDirection, t.ray_direction.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(kImageLayerTriangle, t.triangle.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32UI);
    glBindImageTexture(kImageLayerTint, t.tint.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA16);
    run(false);
    layer_->bind_constants(scene);
    layer_->follow(scene, {.technique = hits, .finds_tint = false, .shadow_rays = rule.shadow_rays});
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferMirroredLayer, list.get());
    glBindTextureUnit(kUnitRadiance, t.radiance.get());
    glBindImageTexture(kImageRadiance, own.radiance.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    run(true);
  }
  frame.timer().end("reflected shade");
  frame.timer().count_all_as("");
  bind_constants(scene);
}

bool MirroredRays::shadowed_by_rays(const ShadingPlan& plan, const FollowRule& rule) {
  return rule.shadow_rays && plan.shadow_rays && !rule.technique.resolves();
}

bool MirroredRays::rays_shadow_any(const MirroredScene& scene, const FollowRule& rule) {
  return std::any_of(scene.layers.begin(), scene.layers.end(),
                     [&](const DrawnLayer& layer) { return shadowed_by_rays(layer.context.plan, rule); });
}

void MirroredRays::shade_hits(const MirroredScene& scene, const FollowRule& rule) {
  ReflectionTargets& t = *targets_;
  const FrameContext& frame = scene.frame;
  int panes = 0;
  const std::vector<Reflector>& reflectors = scene.reflectors.all();
  for (std::size_t k = 0; !rule.glossy && k < reflectors.size(); ++k) panes |= reflectors[k].mirror ? 0 : 1 << k;
  if (rays_shadow_any(scene, rule))
    shadows_.begin(t);
  else
    shadows_.clear();
  for (const DrawnLayer& layer : scene.layers) {
    const ShadingPlan& plan = layer.context.plan;
    if (scene.parts.several()) {
      scene.parts.split_hits(t.triangle, t.depth, layer.context.index, &t.layer_depth, &frame.programs);
      glBindTextureUnit(kUnitDepth, t.layer_depth.get());
    }
    const bool by_rays = shadowed_by_rays(plan, rule);
    layer.mode.shade_hits({frame, plan, t, panes, by_rays && plan.sun_apart});
    if (by_rays) {
      glBindTextureUnit(kUnitTriangle, t.triangle.get());
      shadows_.add(frame,
                   {.plan = plan, .constants = constants_, .sky_frames = rule.averages ? frames_in_mean(rule) : 0}, t);
    }
    if (plan.indirect != "baked") continue;
    frame.timer().end("reflected shade");
    glBindTextureUnit(kUnitTriangle, t.triangle.get());
    glBindImageTexture(kImageRadiance, t.radiance.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    const Program& program = frame.programs.get(reflected_indirect_variant(frame.scene.facts().measured_count > 0));
    bind_indirect(program, frame.scene, nearest_bake(frame.bakes.indirect()));
    dispatch_tiles(program, t.tiles, kPerPoint);
  }
  glBindTextureUnit(kUnitTriangle, t.triangle.get());
  glBindTextureUnit(kUnitDepth, t.depth.get());
}

void MirroredRays::complete(const MirroredScene& scene, const FollowRule& rule, const ReflectionFrame& frame) {
  ReflectionTargets& t = *targets_;
  const DrawnLayer& first = scene.layers.front();
  const int samples = first.mode.samples_of_cells();
  const bool layers =
      rule.technique.shade_layers(frame, first.context.plan.visibility == "traced",
                                  samples > 0 ? samples : scene.frame.request.settings.get_int("reflections.samples"));
  glBindImageTexture(kImageRadiance, t.radiance.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  const bool shadows = rays_shadow_any(scene, rule);
  const Program& program =
      scene.frame.programs.get(compose_variant({layers, rule.glossy, static_cast<bool>(t.tint), shadows}));
  if (t.tint) glBindTextureUnit(kUnitPaneTint, t.tint.get());
  if (shadows) glBindTextureUnit(kUnitShadowLight, shadows_.light().get());
  program.set("u_least", rule.averages ? -1e30f : 0.0f);
  dispatch_tiles(program, t.tiles, kPerPoint);
  scene.frame.timer().end("reflected shade");
}

}  // namespace maquette
