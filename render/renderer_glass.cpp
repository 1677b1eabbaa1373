// Panes and blended surfaces over the finished opaque picture.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

#include "render/depth_order.h"
#include "render/environment/prefilter.h"
#include "render/material_overrides.h"
#include "render/renderer_impl.h"

namespace maquette {

namespace {

/// Latitude-longitude image as a filtered texture that wraps around.
Texture make_irradiance(const Environment& environment) {
  const Image map = prefilter_diffuse(environment);
  std::vector<float> texels;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      for (int c = 0; c < 3; ++c) texels.push_back(map.at(x, y, c));
      texels.push_back(1.0f);
    }
  Texture texture = Texture::make_2d("irradiance", GL_RGBA32F, map.width, map.height);
  texture.upload(0, map.width, map.height, GL_RGBA, GL_FLOAT, texels.data());
  texture.set_filter(GL_LINEAR, GL_LINEAR);
  texture.set_wrap(GL_REPEAT, GL_CLAMP_TO_EDGE);
  return texture;
}

ShaderVariant glass_variant(const FramePlan& plan, const GlassKind& kind) {
  return {"glass/glass.frag",
          "glass/glass.vert",
          {{"VISIBILITY", visibility_define(plan)},
           {"TEXTURES", flag(kind.texture)},
           {"SURFACE", flag(kind.surface)},
           {"PANE", flag(kind.pane)},
           {"RECORD", flag(kind.record)},
           {"MIRRORED", std::to_string(static_cast<int>(kind.reflected))},
           {"HATCHED", flag(kind.hatched)}}};
}

float squared_distance(const Bounds& bounds, const glm::vec3& eye) {
  const glm::vec3 d = bounds.center() - eye;
  return glm::dot(d, d);
}

}  // namespace

std::string visibility_define(const FramePlan& plan) {
  return plan.visibility == "traced" ? "2" : plan.visibility == "baked" ? "1" : "0";
}

std::vector<ShaderVariant> glass_shader_variants() {
  using Reflected = GlassKind::Reflected;
  std::vector<ShaderVariant> variants;
  for (const char* visibility : {"none", "baked", "traced"}) {
    FramePlan plan;
    plan.visibility = visibility;
    for (const bool textured : {false, true}) {
      for (int k = 0; k < 5; ++k) {
        const bool hatched = k > 2;
        const auto reflected = static_cast<Reflected>(hatched ? k - 2 : k);
        for (const int shares : {1, 2, 3})
          variants.push_back(
              glass_variant(plan, {textured, (shares & 1) != 0, (shares & 2) != 0, false, reflected, hatched}));
      }
      for (const bool hatched : {false, true})
        variants.push_back(glass_variant(plan, {textured, false, false, false, Reflected::mirror, hatched}));
      variants.push_back(glass_variant(plan, {.texture = textured, .pane = true, .record = true}));
    }
  }
  return variants;
}

void Renderer::Impl::order_panes(const std::vector<std::size_t>& items) {
  const glm::vec3 eye(constants.eye);
  if (pane_order && pane_order->eye == eye && pane_order->geometry_epoch == geometry_epoch &&
      pane_order->items == items)
    return;
  pane_order.emplace(
      PaneOrder{.eye = eye, .geometry_epoch = geometry_epoch, .items = items, .first = {}, .indices = {}});
  const FlatGeometry& geometry = buffers->geometry();
  std::vector<std::uint32_t> sorted;
  for (std::size_t i : items) {
    const DrawItem& item = geometry.items[i];
    const std::span<const std::uint32_t> indices(geometry.indices.data() + item.first_index, item.index_count);
    if (!faces_both_ways(geometry.positions, indices, eye)) continue;
    pane_order->first[i] = sorted.size();
    const std::vector<std::uint32_t> own = back_to_front(geometry.positions, indices, eye);
    sorted.insert(sorted.end(), own.begin(), own.end());
  }
  if (!sorted.empty()) pane_order->indices = Buffer::from("panes from back to front", sorted);
}

std::vector<std::size_t> Renderer::Impl::glass_items() const {
  std::vector<std::size_t> items;
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) {
    const Material& m = material_of_item(i);
    const bool drawn = buffers->visible(i) && (m.glass || m.alpha_mode == AlphaMode::blend || is_mirror(i));
    if (drawn && may_be_seen(constants.clip_from_world, buffers->bounds(i))) items.push_back(i);
  }
  const glm::vec3 eye(constants.eye);
  std::stable_sort(items.begin(), items.end(), [&](std::size_t a, std::size_t b) {
    return squared_distance(buffers->bounds(a), eye) > squared_distance(buffers->bounds(b), eye);
  });
  return items;
}

bool Renderer::Impl::keep_panes(const FramePlan& plan, const FrameRequest& request) {
  // Layers are listed in the order of the fragments, which only a software device promises to keep.
  if (!plan.glass || !device.software || !keeps_surfaces || !plan.reflections.empty()) return false;
  if (kept_panes && kept_panes->visibility == plan.visibility) return kept_panes->complete;
  const std::vector<std::size_t> items = glass_items();
  constexpr std::size_t kLayerBytes = 48, kHeaderBytes = 16, kMostBytes = std::size_t{1} << 27;
  const FrameTargets& t = *targets;
  const std::size_t points = static_cast<std::size_t>(t.grid_width()) * static_cast<std::size_t>(t.grid_height());
  kept_panes.emplace();
  KeptPanes& kept = *kept_panes;
  kept.visibility = plan.visibility;
  if (std::any_of(items.begin(), items.end(), [&](std::size_t i) { return pane_share(material_of_item(i)) < 1.0f; }))
    return false;
  kept.heads = Texture::make_2d("pane layers by point", GL_R32UI, t.grid_width(), t.grid_height());
  kept.layers = Buffer("pane layers", std::min(kHeaderBytes + points * kLayerBytes, kMostBytes));
  kept.layer_view = Texture::make_buffer("pane layers", GL_RGBA32UI, kept.layers);
  const GLuint none[4] = {};
  glClearTexImage(kept.heads.get(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, none);
  glClearNamedBufferSubData(kept.layers.get(), GL_R32UI, 0, kHeaderBytes, GL_RED_INTEGER, GL_UNSIGNED_INT, none);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, kept.layers.get());
  glBindImageTexture(1, kept.heads.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
  raster_glass(plan, request, items, true);
  std::uint32_t count = 0;
  kept.layers.read(0, sizeof count, &count);
  kept.complete = kHeaderBytes + count * kLayerBytes <= kept.layers.bytes();
  if (kept.complete) {
    kept.covered_tiles = t.make_tile_list();
    kept.bare_tiles = t.make_tile_list();
    glBindTextureUnit(50, kept.heads.get());
    const Program& split = begin_tile_lists("glass/tiles.comp", kept.covered_tiles, &kept.bare_tiles);
    dispatch_tiles(split, t.surface_tiles, 0);
    end_tile_lists(&kept.covered_tiles, &kept.bare_tiles);
  }
  return kept.complete;
}

void Renderer::Impl::bind_kept_panes(const Program& program, float rotation_rad) const {
  constexpr float kTurn_rad = 2.0f * std::numbers::pi_v<float>;
  glBindTextureUnit(50, kept_panes->heads.get());
  glBindTextureUnit(51, kept_panes->layer_view.get());
  program.set("u_turn", std::remainder(rotation_rad, kTurn_rad) / kTurn_rad);
}

int Renderer::Impl::base_color_texture(std::size_t item) const {
  return buffers->has_textures() ? buffers->base_color_texture(static_cast<std::size_t>(buffers->material(item))) : -1;
}

GlassKind Renderer::Impl::glass_kind(const FramePlan& plan, const FrameRequest& request, std::size_t item) const {
  using Reflected = GlassKind::Reflected;
  const float share = pane_share(material_of_item(item));
  GlassKind kind{.texture = base_color_texture(item) >= 0, .surface = (share < 1.0f), .pane = (share > 0.0f)};
  if (plan.reflections.empty() || reflector_of_item(item) < 0) return kind;
  if (is_mirror(item)) {
    kind.reflected = Reflected::mirror;
    kind.surface = kind.pane = false;
  } else {
    kind.reflected = ghost ? Reflected::both : Reflected::front;
  }
  const auto technique = reflector_techniques.find(plan.reflections);
  kind.hatched = technique != reflector_techniques.end() && technique->second && technique->second->doubts() &&
                 request.settings.get_string("reflections.mark") == "hatch";
  return kind;
}

void Renderer::Impl::raster_glass(const FramePlan& plan, const FrameRequest& request,
                                  const std::vector<std::size_t>& items, bool record) {
  FrameTargets& t = *targets;
  if (items.empty()) return;
  if (!irradiance) irradiance = make_irradiance(environment->environment());
  if (!glass_framebuffer) {
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    glass_framebuffer = GlName<FramebufferTraits>(name);
    glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, t.depth_buffer.get(), 0);
  }
  glNamedFramebufferTexture(glass_framebuffer.get(), GL_COLOR_ATTACHMENT0, under_panes().get(), 0);
  glBindFramebuffer(GL_FRAMEBUFFER, glass_framebuffer.get());
  glViewport(0, 0, t.grid_width(), t.grid_height());
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  record ? glDisable(GL_BLEND) : glEnable(GL_BLEND);
  if (record) glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glBlendFuncSeparate(GL_ONE, GL_SRC1_COLOR, GL_ZERO, GL_ONE);  // alpha stays: 0 where only the sky is behind
  glFrontFace(GL_CCW);
  glCullFace(GL_BACK);
  glBindTextureUnit(29, irradiance.get());
  std::vector<std::size_t> two_sided;
  std::copy_if(items.begin(), items.end(), std::back_inserter(two_sided),
               [&](std::size_t i) { return shows_both_sides(i) && !is_mirror(i); });
  order_panes(two_sided);
  glBindVertexArray(buffers->vertex_array());
  for (std::size_t i : items) {
    const DrawItem& item = buffers->geometry().items[i];
    const Material& m = material_of_item(i);
    shows_both_sides(i) ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
    GlassKind kind = glass_kind(plan, request, i);
    kind.record = record;
    const Program& program = programs.get(glass_variant(plan, kind));
    if (plan.visibility == "traced") octree.buffers().set_uniforms(program);
    glUseProgram(program.get());
    const float alpha = m.alpha_mode == AlphaMode::blend ? m.base_color.a : 1.0f;
    glUniform4f(program.location("u_base"), m.base_color.r, m.base_color.g, m.base_color.b, alpha);
    glUniform4f(program.location("u_emission"), m.emissive.r, m.emissive.g, m.emissive.b, m.unlit ? 1.0f : 0.0f);
    glUniform2f(program.location("u_pane"), pane_share(m), std::max(m.ior, 1.0f));
    if (kind.reflected != GlassKind::Reflected::none) program.set("u_reflector", reflector_of_item(i));
    if (kind.texture) program.set("u_texture", base_color_texture(i));
    const auto sorted = pane_order->first.find(i);
    const bool is_sorted = sorted != pane_order->first.end();
    glVertexArrayElementBuffer(buffers->vertex_array(), is_sorted ? pane_order->indices.get() : buffers->indices());
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(item.index_count), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>((is_sorted ? sorted->second : item.first_index) * std::uintptr_t{4}));
  }
  glVertexArrayElementBuffer(buffers->vertex_array(), buffers->indices());
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

}  // namespace maquette
