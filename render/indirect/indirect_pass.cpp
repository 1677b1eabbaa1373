#include "render/indirect/indirect_pass.h"

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"
#include "render/indirect/bind.h"

namespace maquette {

namespace {

ShaderVariant indirect_variant(bool measured) { return {"shading/indirect.comp", "", {{"MEASURED", flag(measured)}}}; }

}  // namespace

std::vector<ShaderVariant> IndirectPass::shader_variants() {
  return {indirect_variant(false), indirect_variant(true), reflected_indirect_variant(false),
          reflected_indirect_variant(true)};
}

IndirectPass::Drawn IndirectPass::drawn_of(const LayerContext& layer, const IndirectKey& key) {
  const Revisions& revisions = layer.frame.scene.revisions();
  return {Key::of(revisions.without_tables(), layer.frame.bakes.without_indirect(), layer.surfaces.revision()),
          revisions.tables, key.serial};
}

bool IndirectPass::is_current(const LayerContext& layer) const {
  for (const IndirectKey& key : layer.frame.bakes.indirect().keys())
    if (drawn_[key.serial & 1u] != drawn_of(layer, key)) return false;
  return true;
}

void IndirectPass::run(const LayerContext& layer, const TileList* changed) {
  const FrameContext& frame = layer.frame;
  for (const IndirectKey& key : frame.bakes.indirect().keys()) {
    const std::size_t k = key.serial & 1u;
    if (!light_[k]) {
      light_[k] = Texture::make_2d("indirect light", GL_RGBA32F, frame.size().grid_width(), frame.size().grid_height());
      drawn_[k].reset();
    }
    const Drawn now = drawn_of(layer, key);
    if (drawn_[k] == now) continue;
    const bool but_for_tables = drawn_[k] && drawn_[k]->points == now.points && drawn_[k]->serial == now.serial;
    drawn_[k] = now;
    const Program& program = frame.programs.get(indirect_variant(frame.scene.facts().measured_count > 0));
    bind_indirect(program, frame.scene, key);
    glBindTextureUnit(kUnitTriangle, layer.surfaces.triangle().get());
    glBindImageTexture(kImageIndirect, light_[k].get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    dispatch_tiles(program, but_for_tables && changed ? *changed : layer.surfaces.tiles(), kPerPoint);
  }
}

std::size_t IndirectPass::bind(const FrameContext& frame) const {
  const std::vector<IndirectKey>& keys = frame.bakes.indirect().keys();
  for (std::size_t k = 0; k < keys.size(); ++k)
    glBindTextureUnit(static_cast<GLuint>(kUnitIndirectLight) + static_cast<GLuint>(k),
                      light_[keys[k].serial & 1u].get());
  return keys.size();
}

}  // namespace maquette
