// What is seen through each grid point: raster, surfaces, curvature. Kept from frame to frame while it holds.
#include <algorithm>
#include <utility>
#include <vector>

#include "render/renderer_impl.h"

namespace maquette {

namespace {

int groups(int count, int size) { return (count + size - 1) / size; }

void order_tiles(TileList& list, int band_tiles) {
  for (std::size_t band = 0; band < list.counts.size(); ++band) {
    std::vector<unsigned> tiles(static_cast<std::size_t>(list.counts[band]));
    if (tiles.empty()) continue;
    const std::size_t offset = band * static_cast<std::size_t>(band_tiles) * sizeof(unsigned);
    list.tiles.read(offset, tiles.size() * sizeof(unsigned), tiles.data());
    tiles = ordered_tiles(std::move(tiles));
    list.tiles.update(offset, tiles.size() * sizeof(unsigned), tiles.data());
  }
}

}  // namespace

ShaderVariant resolve_variant(bool textures, bool texture_bandwidth, bool colors) {
  return {
      "gbuffer/resolve.comp",
      "",
      {{"TEXTURES", flag(textures)}, {"TEXTURE_BANDWIDTH", flag(texture_bandwidth)}, {"VERTEX_COLORS", flag(colors)}}};
}

bool Renderer::Impl::needs_gbuffer(const FrameRequest& request, FramePlan* plan) {
  const SurfaceKey key{request.camera, surface_epoch, plan->texture_bandwidth};
  const bool kept = request.settings.get_bool("shading.reuse") && drawn_surfaces == key;
  drawn_surfaces = key;
  if (!kept) return true;
  for (const char* pass : {"raster", "gbuffer"}) {
    std::erase_if(plan->passes, [&](const PlannedPass& p) { return p.name == pass; });
    plan->left_out.push_back({pass, "kept from the frame before: neither camera nor surfaces changed"});
  }
  return false;
}

void Renderer::Impl::raster() {
  FrameTargets& t = *targets;
  const GLuint framebuffer = t.framebuffer.get();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, t.grid_width(), t.grid_height());
  const GLuint no_triangle[4] = {0, 0, 0, 0};
  const float far_depth = 0.0f;
  glClearNamedFramebufferuiv(framebuffer, GL_COLOR, 0, no_triangle);
  glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &far_depth);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glFrontFace(GL_CCW);  // GL_UPPER_LEFT keeps the winding of the file
  glCullFace(GL_BACK);
  glBindVertexArray(buffers->vertex_array());
  const Program& opaque = programs.get({"gbuffer/visibility.frag", "gbuffer/visibility.vert", {{"ALPHA_MASK", "0"}}});
  for (int masked = 0; masked < 2; ++masked) {
    const Program* program = &opaque;
    if (masked) {
      if (!facts.has_mask) break;
      program = &programs.get({"gbuffer/visibility.frag", "gbuffer/visibility.vert", {{"ALPHA_MASK", "1"}}});
    }
    glUseProgram(program->get());
    for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) {
      const DrawItem& item = buffers->geometry().items[i];
      const Material& m = material_of_item(i);
      const bool is_masked = m.alpha_mode == AlphaMode::mask && m.base_color_texture;
      if (!buffers->visible(i) || m.glass || m.alpha_mode == AlphaMode::blend || is_masked != (masked == 1)) continue;
      if (is_mirror(i)) continue;
      if (!may_be_seen(constants.clip_from_world, buffers->bounds(i))) continue;
      shows_both_sides(i) ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
      program->set("u_first_triangle", static_cast<int>(item.first_index / 3));
      if (masked) {
        program->set("u_texture", buffers->base_color_texture(static_cast<std::size_t>(buffers->material(i))));
        program->set("u_alpha", m.base_color.a);
        program->set("u_cutoff", m.alpha_cutoff);
      }
      glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(item.index_count), GL_UNSIGNED_INT,
                     reinterpret_cast<const void*>(static_cast<std::uintptr_t>(item.first_index) * 4));
    }
  }
  glBindVertexArray(0);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

const Program& Renderer::Impl::begin_tile_lists(const char* shader, const TileList& first, const TileList* second) {
  FrameTargets& t = *targets;
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, t.tile_counts.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, first.tiles.get());
  if (second) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, second->tiles.get());
  t.tile_counts.clear_to_zero();
  const Program& program = programs.get({shader, "", {}});
  program.set("u_band_rows", t.band_rows / FrameTargets::kTile);
  return program;
}

void Renderer::Impl::end_tile_lists(TileList* first, TileList* second) {
  const FrameTargets& t = *targets;
  std::vector<unsigned> counts(2 * first->counts.size());
  t.tile_counts.read(0, t.tile_counts.bytes(), counts.data());
  for (std::size_t band = 0; band < first->counts.size(); ++band) {
    first->counts[band] = static_cast<int>(counts[2 * band]);
    if (second) second->counts[band] = static_cast<int>(counts[2 * band + 1]);
  }
}

void Renderer::Impl::find_tiles() {
  FrameTargets& t = *targets;
  const Program& program = begin_tile_lists("gbuffer/tiles.comp", t.surface_tiles, &t.sky_tiles);
  dispatch_list(program, groups(t.grid_width(), FrameTargets::kTile) * groups(t.grid_height(), FrameTargets::kTile));
  end_tile_lists(&t.surface_tiles, &t.sky_tiles);
  order_tiles(t.surface_tiles, t.band_tiles());
  const float none[4] = {};
  const GLuint nothing[4] = {};
  glClearTexImage(t.depth.get(), 0, GL_RED, GL_FLOAT, none);
  glClearTexImage(t.guide.get(), 0, GL_RG_INTEGER, GL_UNSIGNED_INT, nothing);
  if (!t.bandwidth) return;
  glClearTexImage(t.energy.get(), 0, GL_RGBA, GL_FLOAT, none);
  glClearTexImage(t.pyramid.get(), 0, GL_RGBA, GL_FLOAT, none);
  if (t.whole_blocks()) glClearTexImage(t.pyramid.get(), 1, GL_RGBA, GL_FLOAT, none);
}

void Renderer::Impl::find_repainted(bool painted, PassTimer* timer) {
  FrameTargets& t = *targets;
  t.repainted_tiles.counts.assign(t.repainted_tiles.counts.size(), 0);
  if (!painted) return;  // the flags are those of an earlier swap
  dispatch_tiles(begin_tile_lists("gbuffer/repainted.comp", t.repainted_tiles, nullptr), t.surface_tiles, 0);
  end_tile_lists(&t.repainted_tiles, nullptr);
  if (progressive) {
    glBindImageTexture(0, progressive->mean.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(1, progressive->spread.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glBindImageTexture(2, progressive->deviation.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glBindImageTexture(3, progressive->residual.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    dispatch_tiles(programs.get({"bandwidth/forget.comp", "", {}}), t.repainted_tiles, 6);
    progressive->rate = 0.0;
  }
  timer->end("mark");
}

void Renderer::Impl::draw_gbuffer(const FramePlan& plan, PassTimer* timer) {
  raster();
  timer->end("raster");
  find_tiles();
  drawn_sky.reset();
  keeps_surfaces = false;
  weights_levels = -1;
  open_found = false;
  kept_panes.reset();
  for (auto& drawn : indirect_drawn) drawn.reset();
  FrameTargets& t = *targets;
  glBindImageTexture(0, t.surface.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
  glBindImageTexture(1, t.depth.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  glBindImageTexture(3, t.guide.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32UI);
  if (plan.texture_bandwidth) glBindImageTexture(2, t.texture_nu.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  dispatch_tiles(programs.get(resolve_variant(buffers->has_textures(), plan.texture_bandwidth, buffers->has_colors())),
                 t.surface_tiles, 6);
  if (t.bandwidth) {
    glBindImageTexture(0, t.bend.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
    dispatch_tiles(programs.get({"gbuffer/curvature.comp", "", {}}), t.surface_tiles, 4);
  }
  timer->end("gbuffer");
}

}  // namespace maquette
