#include "render/glass/blended.h"

#include <algorithm>

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"
#include "render/gl/raster_state.h"
#include "render/scene_state/material_overrides.h"
#include "render/shading/shading_mode.h"

namespace maquette {

namespace {

/// Its rays are those of the eye, and what they hit is drawn before.
class PeeledHits : public ReflectorTechnique {
  void trace(const ReflectionFrame&) override {}
};

ShaderVariant peel_variant(bool textured) {
  return {"gbuffer/visibility.frag", "gbuffer/visibility.vert", {{"ALPHA_MASK", textured ? "2" : "1"}, {"PEEL", "1"}}};
}

const ShaderVariant kRays{"glass/eye_rays.comp", "", {}}, kStore{"glass/store_layer.comp", "", {}};

}  // namespace

bool is_blended(const SceneState& scene, std::size_t item) {
  const Material& m = scene.material_of_item(item);
  return scene.is_transparent(item) && is_partly_surface(m);
}

std::vector<ShaderVariant> Blended::shader_variants() {
  return {peel_variant(false), peel_variant(true), kRays, kStore};
}

void Blended::fit(const GridSize& size) {
  const int w = size.grid_width(), h = size.grid_height();
  rays_.fit(size, 1);
  if (depth_buffer_ && depth_buffer_.width() == w && depth_buffer_.height() == h) return;
  depth_buffer_ = Texture::make_2d("blended depth buffer", GL_DEPTH_COMPONENT32F, w, h);
  for (Texture& depth : depth_) depth = Texture::make_2d("blended depth", GL_R32F, w, h);
  radiance_ = Texture();
  depths_ = Texture();
  kept_layers_ = 0;
  GLuint framebuffer = 0;
  glCreateFramebuffers(1, &framebuffer);
  framebuffer_ = GlName<FramebufferTraits>(framebuffer);
  glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, rays_.targets().triangle.get(), 0);
  glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, depth_buffer_.get(), 0);
  const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glNamedFramebufferDrawBuffers(framebuffer, 2, buffers);
}

/// What the layers before show is kept.
void Blended::fit_layers(int count) {
  if (count <= kept_layers_) return;
  const int w = depth_buffer_.width(), h = depth_buffer_.height();
  const auto grow = [&](Texture* texture, const char* name, GLenum format) {
    Texture larger = Texture::make_2d_array(name, format, w, h, count);
    if (kept_layers_ > 0)
      glCopyImageSubData(texture->get(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, larger.get(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0,
                         w, h, kept_layers_);
    *texture = std::move(larger);
  };
  grow(&radiance_, "blended radiance", GL_RGBA32F);
  grow(&depths_, "blended depths", GL_R32F);
  const float none[4] = {};
  glClearTexSubImage(depths_.get(), 0, 0, 0, kept_layers_, w, h, count - kept_layers_, GL_RED, GL_FLOAT, none);
  kept_layers_ = count;
}

std::vector<std::size_t> Blended::items(const MirroredScene& scene) const {
  const SceneState& state = scene.frame.scene;
  const SceneBuffers& buffers = state.buffers();
  std::vector<std::size_t> items;
  for (std::size_t i = 0; i < state.geometry().items.size(); ++i)
    if (buffers.visible(i) && is_blended(state, i) && !scene.reflectors.is_mirror(i) &&
        may_be_seen(scene.frame.constants.clip_from_world, buffers.bounds(i)))
      items.push_back(i);
  return items;
}

void Blended::run(const MirroredScene& scene, const Key& surfaces, bool averages_points) {
  PassTimer& timer = scene.frame.timer();
  timer.count_all_as("blended");
  count_ = 0;
  const std::vector<std::size_t> drawn = items(scene);
  if (drawn.empty()) {
    clear();
    timer.end("blended");
    timer.count_all_as("");
    return;
  }
  fit(scene.frame.size());
  if (!technique_) technique_ = std::make_unique<PeeledHits>();
  const FrameContext& frame = scene.frame;
  const Key now = Key::of(surfaces, frame.scene.revisions().all(), frame.bakes.all(), frame.request.settings);
  frames_ = averages_points && frame.accumulated > 0 && mean_of_ == now ? frames_ + 1 : 1;
  mean_of_ = now;
  const float blend = 1.0f / static_cast<float>(frames_);
  const float none[4] = {};
  if (depths_) glClearTexImage(depths_.get(), 0, GL_RED, GL_FLOAT, none);
  for (; count_ < kMostBlendedLayers && peel(scene, drawn, count_); ++count_) {
    fit_layers(count_ + 1);
    shade(scene, count_, blend);
  }
  scene.bind_layer(0);
  timer.end("blended");
  timer.count_all_as("");
}

bool Blended::peel(const MirroredScene& scene, const std::vector<std::size_t>& items, int layer) {
  const SceneState& state = scene.frame.scene;
  const SceneBuffers& buffers = state.buffers();
  const Texture &own = depth_[static_cast<std::size_t>(layer % 2)],
                &nearer = depth_[static_cast<std::size_t>(1 - layer % 2)];
  glNamedFramebufferTexture(framebuffer_.get(), GL_COLOR_ATTACHMENT1, own.get(), 0);
  begin_triangles(framebuffer_.get(), own.width(), own.height());
  const float none[4] = {};
  glClearNamedFramebufferfv(framebuffer_.get(), GL_COLOR, 1, none);
  glBindTextureUnit(kUnitOpaqueDepth, scene.frame.raster.depth_buffer().get());
  glBindTextureUnit(kUnitBlendedDepth, nearer.get());
  glBindVertexArray(buffers.vertex_array());
  for (const std::size_t i : items) {
    const Material& m = state.material_of_item(i);
    const DrawItem& item = state.geometry().items[i];
    // What covers nothing is not shaded; the alpha of an opaque pane means nothing.
    const bool reads_alpha = m.alpha_mode != AlphaMode::opaque, textured = reads_alpha && m.base_color_texture;
    const float cutoff = m.alpha_mode == AlphaMode::mask ? m.alpha_cutoff : reads_alpha ? 1e-3f : -1.0f;
    const Program& program = scene.frame.programs.get(peel_variant(textured));
    glUseProgram(program.get());
    state.shows_both_sides(i) ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
    program.set("u_first_triangle", static_cast<int>(item.first_index / 3));
    program.set("u_alpha", m.base_color.a);
    program.set("u_cutoff", cutoff);
    program.set("u_peel", layer);
    if (textured) program.set("u_texture", buffers.texture(i, TextureRole::base_color));
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(item.index_count), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(static_cast<std::uintptr_t>(item.first_index) * 4));
  }
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  end_triangles();
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  const ReflectionTargets& t = rays_.targets();
  glBindTextureUnit(kUnitTriangle, t.triangle.get());
  glBindImageTexture(kImageRayOrigin, t.ray_origin.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageRayDirection, t.ray_direction.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  dispatch_list(scene.frame.programs.get(kRays), own.width() * own.height());
  glBindTextureUnit(kUnitRayDirection, t.ray_direction.get());
  rays_.list_tiles(&scene.frame.programs, true);
  return t.tiles.counts[0] > 0;
}

void Blended::shade(const MirroredScene& scene, int layer, float blend) {
  const ReflectionTargets& t = rays_.targets();
  // Samples of the frame's own points: what blends is no reflection, which may be coarser.
  const int samples =
      std::max(scene.frame.constants.sampling.x, scene.frame.request.settings.get_int("reflections.samples"));
  rays_.bind_constants(scene, samples);
  rays_.follow(scene, {.technique = *technique_, .lists_tiles = false, .finds_tint = false, .shadow_rays = true});
  const Program& store = scene.frame.programs.get(kStore);
  store.set("u_layer", layer);
  store.set("u_blend", blend);
  glBindTextureUnit(kUnitRadiance, t.radiance.get());
  glBindTextureUnit(kUnitBlendedDepth, depth_[static_cast<std::size_t>(layer % 2)].get());
  glBindImageTexture(kImageBlendedRadiance, radiance_.get(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(kImageBlendedDepths, depths_.get(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
  dispatch_tiles(store, t.tiles, kPerPoint);
  // The frame's own constants again.
  scene.bind_layer(0);
}

void Blended::bind(const Program& program) const {
  program.set("u_blended_layers", count_);
  glBindTextureUnit(kUnitBlendedRadiance, radiance_.get());
  glBindTextureUnit(kUnitBlendedDepths, depths_.get());
}

std::size_t Blended::bytes() const {
  return rays_.bytes() + depth_buffer_.bytes() + depth_[0].bytes() + depth_[1].bytes() + radiance_.bytes() +
         depths_.bytes();
}

}  // namespace maquette
