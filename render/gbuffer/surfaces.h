#pragma once

#include <cstdint>

#include "render/gbuffer/tiles.h"
#include "render/gl/program_cache.h"
#include "render/scene_state/scene_state.h"

namespace maquette {

/// What a frame lists of tiles besides those of one layer's surfaces.
struct SkyTiles {
  TileList tiles;
  std::uint32_t revision = 0;  ///< grows when they are listed anew
};

/// What all shaders are compiled with for a scene.
ShaderDefines shader_defines(const MaterialDetails& details);

/// The second part of a G-buffer (shaders/shared/gbuffer.glsl): RGBA32UI, two layers.
Texture make_details(int width, int height);
void bind_details_for_writing(const Texture& details);

/// The G-buffer of one layer: the surfaces that its shading mode shades. Points of other layers look like sky.
class Surfaces {
 public:
  /// Makes the images anew where size, bands, texture bandwidth or details are others: then everything is to be found anew.
  void fit(const GridSize& size, int band_rows, bool texture_bandwidth, bool details);
  /// Finds the surfaces of what `triangles` shows, and, where `sky` is not null, the tiles that show the sky.
  void find(const SceneState& scene, const Texture& triangles, SkyTiles* sky, ProgramCache* programs);
  /// Lists the tiles of `triangles` that show the sky, where several layers share them.
  void list_sky(const Texture& triangles, SkyTiles* sky, ProgramCache* programs);
  /// Binds what points are loaded from (shaders/shading/point.glsl).
  void bind() const;
  static std::vector<ShaderVariant> shader_variants();

  const GridSize& size() const { return size_; }
  int band_rows() const { return band_rows_; }
  const TileList& tiles() const { return tiles_; }  ///< that show a surface of the layer
  const Texture& triangle() const { return *triangle_; }
  const Texture& surface() const { return surface_; }
  const Texture& depth() const { return depth_; }
  const Texture& texture_bandwidth() const { return texture_nu_; }
  bool has_texture_bandwidth() const { return has_texture_bandwidth_; }
  bool has_details() const { return static_cast<bool>(details_); }
  std::uint32_t revision() const { return revision_; }  ///< of what was found; grows
  /// The surfaces of this frame are those of the one before.
  bool kept() const { return kept_; }
  void begin_frame() { kept_ = true; }
  std::size_t bytes() const { return surface_.bytes() + details_.bytes() + depth_.bytes() + guide_.bytes(); }

 private:
  void list_tiles(const Texture& triangles, TileList* surface, TileList* sky, ProgramCache* programs);

  GridSize size_;
  int band_rows_ = 0;
  bool has_texture_bandwidth_ = false, kept_ = false;
  TileList tiles_;
  TileCounter counter_;
  TileList unused_;                    ///< of a shader that lists two kinds
  const Texture* triangle_ = nullptr;  ///< of the frame's raster, or of this layer alone
  Texture surface_;                    ///< RGBA32UI (shaders/shared/gbuffer.glsl)
  Texture details_;                    ///< RGBA32UI, two layers; only where materials need them
  Texture depth_;                      ///< R32F, m along the viewing axis; 0: no surface
  Texture guide_;                      ///< RG32UI: what upsampling compares
  Texture texture_nu_;                 ///< R32F, cycles/m
  std::uint32_t revision_ = 0;
};

}  // namespace maquette
