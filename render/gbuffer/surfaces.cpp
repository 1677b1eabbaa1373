// What is seen through each grid point, found on screen. Kept from frame to frame while it holds.
#include "render/gbuffer/surfaces.h"

#include "render/gl/bindings.h"

namespace maquette {

namespace {

ShaderVariant resolve_variant(bool textures, bool texture_bandwidth, bool colors) {
  return {
      "gbuffer/resolve.comp",
      "",
      {{"TEXTURES", flag(textures)}, {"TEXTURE_BANDWIDTH", flag(texture_bandwidth)}, {"VERTEX_COLORS", flag(colors)}}};
}

const ShaderVariant kTiles{"gbuffer/tiles.comp", "", {}};

}  // namespace

std::vector<ShaderVariant> Surfaces::shader_variants() {
  std::vector<ShaderVariant> variants{kTiles};
  for (int k = 0; k < 8; ++k) {
    if ((k & 2) && !(k & 1)) continue;  // texture bandwidth without textures
    variants.push_back(resolve_variant(k & 1, k & 2, k & 4));
  }
  return variants;
}

ShaderDefines shader_defines(const MaterialDetails& details) {
  return {{"DETAILS", flag(details.any)},
          {"ANALYTIC_ANISOTROPY", flag(details.anisotropy)},
          {"ANALYTIC_COAT_NORMAL", flag(details.coat_normal)},
          {"ANALYTIC_FILM", flag(details.film)}};
}

Texture make_details(int width, int height) {
  return Texture::make_2d_array("surface details", GL_RGBA32UI, width, height, 2);
}

void bind_details_for_writing(const Texture& details) {
  glBindImageTexture(kImageDetails, details.get(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
}

void Surfaces::fit(const GridSize& size, int band_rows, bool texture_bandwidth, bool details) {
  if (surface_ && size == size_ && band_rows == band_rows_ && texture_bandwidth == has_texture_bandwidth_ &&
      details == has_details())
    return;
  size_ = size;
  band_rows_ = band_rows;
  has_texture_bandwidth_ = texture_bandwidth;
  const int w = size.grid_width(), h = size.grid_height();
  surface_ = Texture::make_2d("surface", GL_RGBA32UI, w, h);
  details_ = details ? make_details(w, h) : Texture();
  depth_ = Texture::make_2d("depth", GL_R32F, w, h);
  guide_ = Texture::make_2d("guide", GL_RG32UI, w, h);
  texture_nu_ = texture_bandwidth ? Texture::make_2d("texture bandwidth", GL_R32F, w, h) : Texture();
  tiles_ = make_tile_list(size, band_rows);
  counter_ = TileCounter(tiles_.counts.size());
  ++revision_;
}

void Surfaces::list_tiles(const Texture& triangles, TileList* surface, TileList* sky, ProgramCache* programs) {
  for (TileList* list : {surface, sky})
    if (list->counts.size() != tiles_.counts.size() || list->tiles.bytes() != tiles_.tiles.bytes() ||
        list->band_tiles != tiles_.band_tiles)
      *list = make_tile_list(size_, band_rows_);
  glBindTextureUnit(kUnitTriangle, triangles.get());
  const Program& program = counter_.begin(programs, kTiles, band_rows_, *surface, sky);
  dispatch_list(program, group_count(size_.grid_width(), kTileSide) * group_count(size_.grid_height(), kTileSide));
  counter_.end(surface, sky);
}

void Surfaces::list_sky(const Texture& triangles, SkyTiles* sky, ProgramCache* programs) {
  list_tiles(triangles, &unused_, &sky->tiles, programs);
  ++sky->revision;
}

void Surfaces::find(const SceneState& scene, const Texture& triangles, SkyTiles* sky, ProgramCache* programs) {
  triangle_ = &triangles;
  kept_ = false;
  ++revision_;
  list_tiles(triangles, &tiles_, sky ? &sky->tiles : &unused_, programs);
  if (sky) ++sky->revision;
  order_tiles(&tiles_);
  const float none[4] = {};
  const GLuint nothing[4] = {};
  glClearTexImage(depth_.get(), 0, GL_RED, GL_FLOAT, none);
  glClearTexImage(guide_.get(), 0, GL_RG_INTEGER, GL_UNSIGNED_INT, nothing);
  glBindImageTexture(kImageSurface, surface_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
  if (details_) bind_details_for_writing(details_);
  glBindImageTexture(kImageDepth, depth_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  glBindImageTexture(kImageGuide, guide_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32UI);
  if (has_texture_bandwidth_)
    glBindImageTexture(kImageTextureBandwidth, texture_nu_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  const SceneBuffers& buffers = scene.buffers();
  dispatch_tiles(programs->get(resolve_variant(buffers.has_textures(), has_texture_bandwidth_, buffers.has_colors())),
                 tiles_, kPerPoint);
}

void Surfaces::bind() const {
  if (triangle_) glBindTextureUnit(kUnitTriangle, triangle_->get());
  glBindTextureUnit(kUnitSurface, surface_.get());
  if (details_) glBindTextureUnit(kUnitDetails, details_.get());
  glBindTextureUnit(kUnitDepth, depth_.get());
  glBindTextureUnit(kUnitGuide, guide_.get());
}

}  // namespace maquette
