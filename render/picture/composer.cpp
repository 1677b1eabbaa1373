#include "render/picture/composer.h"

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"

namespace maquette {

namespace {

/// `bakes`: of indirect light that the picture lies between. `panes`: recorded ones.
ShaderVariant compose_variant(int stage, bool textures, std::size_t bakes, bool panes, bool glossy, bool shadows) {
  return {"shading/compose.comp",
          "",
          {{"STAGE", std::to_string(stage)},
           {"TEXTURES", flag(textures)},
           {"INDIRECT", std::to_string(bakes)},
           {"PANES", flag(panes)},
           {"GLOSSY", flag(glossy)},
           {"SHADOWS", flag(shadows)}}};
}

ShaderVariant listed(ShaderVariant compose) {
  compose.defines.emplace_back("QUADS", "1");
  return compose;
}

ShaderVariant sky_variant(bool panes) { return {"shading/sky.comp", "", {{"PANES", flag(panes)}}}; }

const ShaderVariant kFilter = compose_variant(2, false, 0, false, false, false),
                    kSpread = listed(compose_variant(4, false, 0, false, false, false));

}  // namespace

std::vector<ShaderVariant> Composer::shader_variants() {
  std::vector<ShaderVariant> variants{kFilter, kSpread, sky_variant(false), sky_variant(true)};
  for (const bool textures : {false, true})
    for (const std::size_t bakes : {0u, 1u, 2u})
      for (const bool panes : {false, true})
        for (const bool glossy : {false, true})
          for (const bool shadows : {false, true}) {
            for (const int stage : {0, 1})
              variants.push_back(compose_variant(stage, textures, bakes, panes, glossy, shadows));
            for (const int stage : {1, 3})
              variants.push_back(listed(compose_variant(stage, textures, bakes, panes, glossy, shadows)));
          }
  return variants;
}

void Composer::fit(const GridSize& size, bool several) {
  if (!picture_ || !(size == size_)) {
    size_ = size;
    picture_ = Texture::make_2d("picture", GL_RGBA32F, size.width, size.height);
    radiance_ = Texture();
    depth_ = Texture();
    sky_.reset();
  }
  if (several_ != several) sky_.reset();
  several_ = several;
  if (!several) {
    radiance_ = Texture();
    depth_ = Texture();
  } else if (!radiance_) {
    radiance_ = Texture::make_2d("radiance of all layers", GL_RGBA32F, size.grid_width(), size.grid_height());
    depth_ = Texture::make_2d("depth of all layers", GL_R32F, size.grid_width(), size.grid_height());
  }
}

void Composer::begin(const FramePlan& plan, const Texture& radiance, float blend) {
  if (grid_ != (several_ ? &radiance_ : &radiance)) sky_.reset();
  grid_ = several_ ? &radiance_ : &radiance;
  blend_ = blend;
  in_picture_ = !several_ && size_.side == 1 && (!plan.glass || blend >= 1.0f);
}

void Composer::draw_sky(const ComposeScene& scene) {
  const FrameContext& frame = scene.frame;
  const Key now = Key::of(frame.scene.revisions().sky, frame.request.env_rotation_rad, frame.request.env_scale,
                          in_picture_, scene.sky.revision);
  if (!frame.plan.glass && sky_ == now) return;
  sky_.reset();
  if (!frame.plan.glass) sky_ = now;  // panes are drawn over the very points
  glBindTextureUnit(kUnitTriangle, frame.raster.triangle().get());
  glBindImageTexture(kImageRadiance, behind_panes().get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const Program& program = frame.programs.get(sky_variant(scene.panes != nullptr));
  if (scene.panes) scene.panes->bind(program);
  dispatch_tiles(program, scene.sky.tiles, kPerPoint);
}

void Composer::compose(const ComposeScene& scene) {
  if (several_) {
    const float none = 0.0f;
    glClearTexImage(depth_.get(), 0, GL_RED, GL_FLOAT, &none);
  }
  draw_sky(scene);
  for (const ComposedLayer& composed : scene.layers) compose_layer(scene, composed);
}

const Program& Composer::program_of(const ComposeScene& scene, const ComposedLayer& composed, int stage,
                                    std::size_t bakes, bool quads, bool panes) const {
  const ComposeInfo info = composed.layer.mode.compose_info(scene.frame.scene);
  const bool glossy = scene.glossy_light && composed.layer.context.index == 0;
  const ShaderVariant variant =
      compose_variant(stage, info.without_base_factor, bakes, panes, glossy, composed.shadow_light);
  const Program& program = scene.frame.programs.get(quads ? listed(variant) : variant);
  if (panes) scene.panes->bind(program);
  // A frame that is averaged is not cut off at black: what rays take away in one would be missing from the mean.
  if (glossy || composed.shadow_light) program.set("u_least", blend_ < 1.0f ? -1e30f : 0.0f);
  if (bakes == 2) program.set("u_later", scene.frame.bakes.indirect().blend());
  return program;
}

void Composer::compose_layer(const ComposeScene& scene, const ComposedLayer& composed) {
  const LayerContext& layer = composed.layer.context;
  if (several_) layer.surfaces.bind();
  if (in_picture_) glBindTextureUnit(kUnitRadiance, layer.radiance.get());
  const std::size_t bakes = layer.plan.indirect == "baked" ? composed.bind_indirect() : 0;
  if (composed.shadow_light) glBindTextureUnit(kUnitShadowLight, composed.shadow_light->get());
  if (scene.glossy_light && layer.index == 0) glBindTextureUnit(kUnitGlossy, scene.glossy_light->get());
  glBindImageTexture(kImageRadiance, in_picture_ ? picture_.get() : layer.radiance.get(), 0, GL_FALSE, 0, GL_READ_WRITE,
                     GL_RGBA32F);
  if (composed.layer.mode.compose_info(scene.frame.scene).plain_quads)
    compose_quads(scene, composed, bakes);
  else
    compose_tiles(scene, composed, bakes);
  if (several_)
    Parts::merge(layer.surfaces.tiles(), layer.surfaces.depth(), layer.radiance, radiance_, depth_,
                 &scene.frame.programs);
}

void Composer::compose_quads(const ComposeScene& scene, const ComposedLayer& composed, std::size_t bakes) {
  const ComposeInfo info = composed.layer.mode.compose_info(scene.frame.scene);
  const bool panes = scene.panes, glossy = scene.glossy_light && composed.layer.context.index == 0;
  const Program& plain = program_of(scene, composed, 3, bakes, true, panes);
  plain.set("u_least_points",
            bakes > 0 || glossy || panes || composed.shadow_light || scene.frame.scene.buffers().has_colors() ? 4 : 1);
  dispatch_quads(plain, *info.plain_quads, 1);
  dispatch_quads(program_of(scene, composed, 1, bakes, true, panes), *info.mixed_quads, 4);
  dispatch_quads(scene.frame.programs.get(kSpread), *info.plain_quads, 1);
}

void Composer::compose_tiles(const ComposeScene& scene, const ComposedLayer& composed, std::size_t bakes) {
  const auto complete = [&](const TileList& tiles, bool panes) {
    const Program& program = program_of(scene, composed, in_picture_ ? 0 : 1, bakes, false, panes);
    if (in_picture_) program.set("u_blend", blend_);
    dispatch_tiles(program, tiles, kPerPoint);
  };
  const RecordedPanes* panes = scene.panes;
  complete(panes ? panes->bare_tiles : composed.layer.context.surfaces.tiles(), false);
  if (panes) complete(panes->covered_tiles, true);
}

void Composer::filter(ProgramCache* programs) {
  const Program& program = programs->get(kFilter);
  program.set("u_blend", blend_);
  glBindTextureUnit(kUnitRadiance, grid_->get());
  glBindImageTexture(kImagePicture, picture_.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  dispatch(program, group_count(size_.width, 8), group_count(size_.height, 8));
}

}  // namespace maquette
