#pragma once

#include <cstdint>
#include <vector>

#include "render/frame/frame_constants.h"
#include "render/gbuffer/tiles.h"
#include "render/gl/raster_state.h"
#include "render/scene_state/scene_state.h"

namespace maquette {

/// Which triangle each grid point shows, of all opaque surfaces of the frame.
class Raster {
 public:
  /// Makes the images anew where the size is another one. Throws Error when the picture is larger than the driver
  /// allows.
  void fit(const GridSize& size);
  const GridSize& size() const { return size_; }
  /// Draws the opaque items. `is_excluded(item)`: it is drawn otherwise, with the panes.
  template <typename Excluded>
  void draw(const SceneState& scene, const FrameConstants& constants, ProgramCache* programs,
            const Excluded& is_excluded) {
    begin_triangles(framebuffer_.get(), size_.grid_width(), size_.grid_height());
    for (const Mask mask : {Mask::none, Mask::factor, Mask::texture}) {
      if (mask != Mask::none && !scene.facts().has_mask) break;
      const Program& program = programs->get(variant(mask));
      glUseProgram(program.get());
      for (std::size_t i = 0; i < scene.geometry().items.size(); ++i)
        if (!is_excluded(i)) draw_item(scene, constants, program, i, mask);
    }
    end();
  }
  static std::vector<ShaderVariant> shader_variants();

  const Texture& triangle() const { return triangle_; }
  const Texture& depth_buffer() const { return depth_buffer_; }
  std::uint32_t revision() const { return revision_; }  ///< of what is drawn; grows
  std::size_t bytes() const { return triangle_.bytes() + depth_buffer_.bytes(); }

 private:
  /// What cuts an item out: nothing, its alpha factor and vertex alpha, or a texture's alpha as well.
  enum class Mask { none, factor, texture };
  static ShaderVariant variant(Mask mask);
  void draw_item(const SceneState& scene, const FrameConstants& constants, const Program& program, std::size_t item,
                 Mask mask) const;
  void end();

  GridSize size_;
  GlName<FramebufferTraits> framebuffer_;
  Texture triangle_;      ///< R32UI: number + 1, 0 for the sky
  Texture depth_buffer_;  ///< 1 at the near plane, 0 at infinity
  std::uint32_t revision_ = 0;
};

}  // namespace maquette
