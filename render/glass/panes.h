#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/glass/blended.h"
#include "render/parts/parts.h"
#include "render/reflections/reflected_picture.h"
#include "render/reflections/reflector_set.h"
#include "render/shading/layer.h"

namespace maquette {

/// What panes are drawn of in one frame.
struct PaneScene {
  const FrameContext& frame;
  const std::vector<DrawnLayer>& layers;
  const Parts& parts;
  const ReflectorSet& reflectors;
  ReflectedPicture reflected = {};
  const Blended* blended = nullptr;  ///< where something blends
};

/// Panes, blended surfaces and mirrors over the finished opaque picture, from back to front.
class Panes {
 public:
  /// Draws them over `behind`, an image of the grid's size.
  void draw(const PaneScene& scene, const Texture& behind);
  /// Records what each point shows of panes while the surfaces stay the same, so that composing can draw them. True when
  /// all of it is recorded; else they are drawn as ever.
  bool record(const PaneScene& scene, const Texture& behind);
  /// Binds what is recorded for shaders/glass/kept.glsl.
  void bind_recorded(const Program& program, float rotation_rad) const;
  const TileList& covered_tiles() const { return recorded_->covered_tiles; }
  const TileList& bare_tiles() const { return recorded_->bare_tiles; }
  std::size_t bytes() const;
  static std::vector<ShaderVariant> shader_variants();

 private:
  /// What each grid point shows of panes (shaders/glass/kept.glsl).
  struct Recorded {
    Key of;                 ///< surfaces and shadows that it was recorded with
    bool complete = false;  ///< false: there is more than fits
    Texture heads, layer_view;
    Buffer layers;
    TileList covered_tiles, bare_tiles;  ///< of surfaces: with a pane before them somewhere, and without
  };
  /// Triangles of panes that may cover themselves, from back to front.
  struct Order {
    Key of;                                    ///< eye, geometry and items
    std::map<std::size_t, std::size_t> first;  ///< item -> first entry in `indices`, for those that need it
    Buffer indices;
  };
  std::vector<std::size_t> items(const PaneScene& scene) const;
  void sort(const PaneScene& scene, const std::vector<std::size_t>& items);
  void draw_items(const PaneScene& scene, const std::vector<std::size_t>& items, const Texture& behind, bool record);
  void draw_item(const PaneScene& scene, std::size_t item, bool record) const;
  void bind_framebuffer(const PaneScene& scene, const Texture& behind);

  GlName<FramebufferTraits> framebuffer_;
  std::optional<Order> order_;
  std::optional<Recorded> recorded_;
  TileCounter counter_;
};

}  // namespace maquette
