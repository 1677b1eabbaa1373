#include "render/bandwidth/upsampling.h"

#include "render/gl/bindings.h"

namespace maquette {

namespace {

/// Levels up to this one are filled by tiles: cells of the coarser ones are larger than a tile, and few.
constexpr int kLastTileLevel = 2;
const ShaderVariant kQuads{"bandwidth/quads.comp", "", {}};

}  // namespace

ShaderVariant Upsampling::variant(const Rule& rule) {
  return {"bandwidth/fill.comp",
          "",
          {{"TEXTURES", flag(rule.textures)},
           {"CUBIC", flag(rule.cubic)},
           {"TILES", flag(rule.tiles)},
           {"OWN", flag(rule.own)},
           {"FIND", flag(rule.step == Step::find)},
           {"KEPT", flag(rule.step == Step::kept)},
           {"MIDDLE", flag(rule.middle)}}};
}

/// The finest level with several points a pixel, by listed quads.
ShaderVariant Upsampling::quads_variant(bool textures, bool own) {
  ShaderVariant quads = variant({.textures = textures, .own = own});
  quads.defines.emplace_back("QUADS", "1");
  return quads;
}

std::vector<ShaderVariant> Upsampling::shader_variants() {
  std::vector<ShaderVariant> variants{kQuads};
  for (const bool textures : {false, true})
    for (const bool own : {false, true}) {
      variants.push_back(quads_variant(textures, own));
      for (const Step step : {Step::once, Step::find, Step::kept})
        for (int place = 0; place < 6; ++place)
          if (step != Step::find || (!textures && !own))
            variants.push_back(variant({textures, own, place / 2 > 0, place / 2 < 2, step, place % 2 == 1}));
    }
  return variants;
}

void Upsampling::fit(const GridSize& size) {
  size_ = size;
  const int w = size.grid_width(), h = size.grid_height();
  weights_ = Texture::make_2d("upsampling weights", GL_RG32UI, w, h);
  weights_of_.reset();
  plain_quads_ = QuadList();
  mixed_quads_ = QuadList();
  quad_counts_ = Buffer();
  if (size.side == 1) return;
  const std::size_t quads = static_cast<std::size_t>(w / 2) * static_cast<std::size_t>(h / 2);
  plain_quads_.quads = Buffer("plain quads", quads * sizeof(unsigned));
  mixed_quads_.quads = Buffer("mixed quads", quads * sizeof(unsigned));
  quad_counts_ = Buffer("quad counts", 2 * sizeof(unsigned));
}

void Upsampling::list_quads(const LayerContext& layer) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferQuadCounts, quad_counts_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPlainQuads, plain_quads_.quads.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferMixedQuads, mixed_quads_.quads.get());
  quad_counts_.clear_to_zero();
  dispatch_tiles(layer.frame.programs.get(kQuads), layer.surfaces.tiles(), kPerBlock);
  unsigned counts[2];
  quad_counts_.read(0, sizeof counts, counts);
  plain_quads_.count = static_cast<int>(counts[0]);
  mixed_quads_.count = static_cast<int>(counts[1]);
}

void Upsampling::fill_levels(const LayerContext& layer, Step step, bool own, const TileList& tiles, int levels) const {
  const bool find = step == Step::find;
  for (int level = levels - 1; level >= (size_.side > 1 ? 1 : 0); --level) {
    const bool by_tiles = level <= kLastTileLevel;
    const int side = 1 << level;
    for (int middle = 0; middle < 2; ++middle) {
      const Program& program =
          layer.frame.programs.get(variant({.textures = !find && layer.frame.scene.buffers().has_textures(),
                                            .own = !find && own,
                                            .cubic = level > 0,
                                            .tiles = by_tiles,
                                            .step = step,
                                            .middle = middle == 1}));
      program.set("u_level", level);
      const int cells = group_count(size_.grid_width(), 2 * side) * group_count(size_.grid_height(), 2 * side);
      if (by_tiles)
        dispatch_tiles(program, find ? layer.surfaces.tiles() : tiles, 2 * (2 - level) + 1 - middle);
      else
        dispatch_list(program, middle ? cells : 2 * cells);
    }
  }
}

void Upsampling::fill(const LayerContext& layer, const Texture& axes, const Texture& marks,
                      const std::function<void()>& bind_own, const TileList& tiles, int levels) {
  glBindTextureUnit(kUnitScreenAxes, axes.get());
  glBindTextureUnit(kUnitMarks, marks.get());
  glBindImageTexture(kImageRadiance, layer.radiance.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(kImageWeights, weights_.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RG32UI);
  const bool own = static_cast<bool>(bind_own);
  if (own) bind_own();
  // From the second frame on that shows the same surfaces.
  const bool kept = layer.surfaces.kept();
  const std::pair now(layer.surfaces.revision(), levels);
  if (kept && weights_of_ != now) {
    fill_levels(layer, Step::find, own, tiles, levels);
    weights_of_ = now;
  }
  fill_levels(layer, kept ? Step::kept : Step::once, own, tiles, levels);
  if (size_.side == 1) return;
  list_quads(layer);
  const Program& program = layer.frame.programs.get(quads_variant(layer.frame.scene.buffers().has_textures(), own));
  program.set("u_level", 0);
  dispatch_quads(program, mixed_quads_, 1);
}

}  // namespace maquette
