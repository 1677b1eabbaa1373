#include "render/gbuffer/raster.h"

#include <string>

#include "render/frame/camera.h"
#include "scenes/error.h"

namespace maquette {

void Raster::fit(const GridSize& size) {
  if (size == size_ && triangle_) return;
  const int w = size.grid_width(), h = size.grid_height();
  GLint max_size = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_size);
  if (w > max_size || h > max_size)
    throw Error("--size",
                std::to_string(size.width) + "x" + std::to_string(size.height) + " with " +
                    std::to_string(size.side * size.side) + " samples a pixel exceeds this driver's largest image (" +
                    std::to_string(max_size) + ")",
                "ask for a smaller picture or fewer samples a pixel");
  size_ = size;
  triangle_ = Texture::make_2d("triangle numbers", GL_R32UI, w, h);
  depth_buffer_ = Texture::make_2d("depth buffer", GL_DEPTH_COMPONENT32F, w, h);
  GLuint framebuffer = 0;
  glCreateFramebuffers(1, &framebuffer);
  framebuffer_ = GlName<FramebufferTraits>(framebuffer);
  glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, triangle_.get(), 0);
  glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, depth_buffer_.get(), 0);
  ++revision_;
}

ShaderVariant Raster::variant(Mask mask) {
  return {"gbuffer/visibility.frag",
          "gbuffer/visibility.vert",
          {{"ALPHA_MASK", std::to_string(static_cast<int>(mask))}}};
}

std::vector<ShaderVariant> Raster::shader_variants() {
  return {variant(Mask::none), variant(Mask::factor), variant(Mask::texture)};
}

void Raster::draw_item(const SceneState& scene, const FrameConstants& constants, const Program& program, std::size_t i,
                       Mask mask) const {
  const SceneBuffers& buffers = scene.buffers();
  const DrawItem& item = scene.geometry().items[i];
  const Material& m = scene.material_of_item(i);
  const Mask own = m.alpha_mode != AlphaMode::mask ? Mask::none
                   : m.base_color_texture          ? Mask::texture
                                                   : Mask::factor;
  if (!buffers.visible(i) || scene.is_transparent(i) || own != mask) return;
  if (!may_be_seen(constants.clip_from_world, buffers.bounds(i))) return;
  glBindVertexArray(buffers.vertex_array());
  scene.shows_both_sides(i) ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
  program.set("u_first_triangle", static_cast<int>(item.first_index / 3));
  if (mask != Mask::none) {
    program.set("u_alpha", m.base_color.a);
    program.set("u_cutoff", m.alpha_cutoff);
  }
  if (mask == Mask::texture)
    program.set("u_texture", buffers.texture(i, TextureRole::base_color));
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(item.index_count), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(static_cast<std::uintptr_t>(item.first_index) * 4));
}

void Raster::end() {
  glBindVertexArray(0);
  end_triangles();
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  ++revision_;
}

}  // namespace maquette
