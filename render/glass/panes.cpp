#include "render/glass/panes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"
#include "render/glass/depth_order.h"
#include "render/scene_state/material_overrides.h"
#include "render/shading/sampled_shading.h"

namespace maquette {

namespace {

/// What an item is made of.
struct PaneKind {
  bool texture = false, surface = false, pane = false;
  bool specular = false;  ///< of a pane: its faces reflect otherwise than their index says
  bool record = false;
  /// What of a reflector it shows besides the sky; `both`: a second image too.
  enum class Reflected { none, front, both, mirror } reflected = Reflected::none;
  bool hatched = false;  ///< where the technique's confidence is low
};

ShaderVariant pane_variant(const ShadingPlan& plan, const PaneKind& kind) {
  return {"glass/glass.frag",
          "glass/glass.vert",
          {{"VISIBILITY", visibility_define(plan)},
           {"TEXTURES", flag(kind.texture)},
           {"SURFACE", flag(kind.surface)},
           {"PANE", kind.specular ? "2" : flag(kind.pane)},
           {"RECORD", flag(kind.record)},
           {"MIRRORED", std::to_string(static_cast<int>(kind.reflected))},
           {"HATCHED", flag(kind.hatched)}}};
}

/// Weights of the first image, the second one, and of what is no reflection of a pane (`reflections.layer`).
glm::vec3 layer_weights(const std::string& layer) {
  if (layer == "transmitted") return {0.0f, 0.0f, 1.0f};
  if (layer == "reflected") return {1.0f, 1.0f, 0.0f};
  if (layer == "ghost") return {0.0f, 1.0f, 0.0f};
  return {1.0f, 1.0f, 1.0f};
}

/// Empties what panes are drawn over, but for its alpha.
void clear_colors(GLuint framebuffer) {
  constexpr float kBlack[] = {0.0f, 0.0f, 0.0f, 0.0f};
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
  glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, kBlack);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

const ShaderVariant kPaneTiles{"glass/tiles.comp", "", {}};

/// Of an orthographic camera far behind, as no point of its rays is the eye of all.
glm::vec3 eye_for_order(const FrameContext& frame) {
  const glm::vec3 eye(frame.constants.eye);
  if (frame.constants.eye.w > 0.0f) return eye;
  return eye - 1e3f * frame.scene.bounds().radius() * glm::vec3(frame.constants.forward);
}

float squared_distance(const Bounds& bounds, const glm::vec3& eye) {
  const glm::vec3 d = bounds.center() - eye;
  return glm::dot(d, d);
}

/// In the order of shaders/glass/pane_textures.glsl, -1: none.
using PaneTextures = std::array<int, 8>;
PaneTextures textures_of(const SceneState& scene, std::size_t item) {
  const Material& m = scene.material_of_item(item);
  const auto texture = [&](TextureRole role) { return texture_of(m, role) ? scene.buffers().texture(item, role) : -1; };
  const bool pane = pane_share(m) > 0.0f;
  return {texture(TextureRole::base_color),
          pane ? texture(TextureRole::transmission) : -1,
          pane ? texture(TextureRole::thickness) : -1,
          texture(TextureRole::emissive),
          pane ? texture(TextureRole::normal) : -1,
          m.transmission > 0.0f ? texture(TextureRole::metallic_roughness) : -1,
          pane ? texture(TextureRole::specular) : -1,
          pane ? texture(TextureRole::specular_color) : -1};
}

PaneKind kind_of(const PaneScene& scene, std::size_t item) {
  using Reflected = PaneKind::Reflected;
  const Material& material = scene.frame.scene.material_of_item(item);
  const PaneTextures textures = textures_of(scene.frame.scene, item);
  PaneKind kind{.texture = std::any_of(textures.begin(), textures.end(), [](int texture) { return texture >= 0; }),
                .surface = is_partly_surface(material),
                .pane = (pane_share(material) > 0.0f)};
  kind.specular = kind.pane && !has_plain_faces(material);
  kind.texture |= kind.specular;  // few have them, and it halves the permutations
  if (!scene.reflected.drawn || scene.reflectors.of_item(item) < 0) return kind;
  if (scene.reflectors.is_mirror(item)) {
    kind.reflected = Reflected::mirror;
    kind.surface = kind.pane = kind.specular = false;
  } else {
    kind.reflected = scene.reflected.has_ghost ? Reflected::both : Reflected::front;
  }
  kind.hatched = scene.reflected.low_confidence;
  return kind;
}

}  // namespace

std::vector<ShaderVariant> Panes::shader_variants() {
  using Reflected = PaneKind::Reflected;
  std::vector<ShaderVariant> variants{kPaneTiles};
  for (const char* visibility : {"none", "baked", "traced"}) {
    ShadingPlan plan;
    plan.visibility = visibility;
    for (const bool textured : {false, true}) {
      for (int k = 0; k < 5; ++k) {
        const bool hatched = k > 2;
        const auto reflected = static_cast<Reflected>(hatched ? k - 2 : k);
        for (const int shares : {1, 2, 3, 6, 7}) {  // surface, pane, its faces
          if ((shares & 4) != 0 && !textured) continue;
          variants.push_back(pane_variant(plan, {.texture = textured,
                                                 .surface = (shares & 1) != 0,
                                                 .pane = (shares & 2) != 0,
                                                 .specular = (shares & 4) != 0,
                                                 .reflected = reflected,
                                                 .hatched = hatched}));
        }
      }
      for (const bool hatched : {false, true})
        variants.push_back(
            pane_variant(plan, {.texture = textured, .reflected = Reflected::mirror, .hatched = hatched}));
      for (const bool specular : {false, textured})
        variants.push_back(
            pane_variant(plan, {.texture = textured, .pane = true, .specular = specular, .record = true}));
    }
  }
  return variants;
}

void Panes::sort(const PaneScene& scene, const std::vector<std::size_t>& items) {
  const glm::vec3 eye = eye_for_order(scene.frame);
  const Key now = Key::of(eye, scene.frame.scene.revisions().geometry, items);
  if (order_ && order_->of == now) return;
  order_.emplace(Order{.of = now, .first = {}, .indices = {}});
  const FlatGeometry& geometry = scene.frame.scene.geometry();
  std::vector<std::uint32_t> sorted;
  for (std::size_t i : items) {
    const DrawItem& item = geometry.items[i];
    const std::span<const std::uint32_t> indices(geometry.indices.data() + item.first_index, item.index_count);
    if (!faces_both_ways(geometry.positions, indices, eye)) continue;
    order_->first[i] = sorted.size();
    const std::vector<std::uint32_t> own = back_to_front(geometry.positions, indices, eye);
    sorted.insert(sorted.end(), own.begin(), own.end());
  }
  if (!sorted.empty()) order_->indices = Buffer::from("panes from back to front", sorted);
}

std::vector<std::size_t> Panes::items(const PaneScene& scene) const {
  const SceneState& state = scene.frame.scene;
  const SceneBuffers& buffers = state.buffers();
  std::vector<std::size_t> items;
  for (std::size_t i = 0; i < state.geometry().items.size(); ++i) {
    const bool drawn = buffers.visible(i) && (state.is_transparent(i) || scene.reflectors.is_mirror(i));
    if (drawn && may_be_seen(scene.frame.constants.clip_from_world, buffers.bounds(i))) items.push_back(i);
  }
  const glm::vec3 eye = eye_for_order(scene.frame);
  std::stable_sort(items.begin(), items.end(), [&](std::size_t a, std::size_t b) {
    return squared_distance(buffers.bounds(a), eye) > squared_distance(buffers.bounds(b), eye);
  });
  return items;
}

bool Panes::record(const PaneScene& scene, const Texture& behind) {
  const FrameContext& frame = scene.frame;
  const DrawnLayer& layer = scene.layers.front();
  const Surfaces& surfaces = layer.context.surfaces;
  if (!surfaces.kept()) recorded_.reset();  // of another G-buffer
  // Layers are listed in the order of the fragments, which only a software device promises to keep.
  if (!frame.plan.glass || !frame.device.software || !surfaces.kept() || !frame.plan.reflections.empty() ||
      scene.layers.size() > 1 || frame.request.settings.get_string("reflections.layer") != "all")
    return false;
  const Key now = Key::of(surfaces.revision(), layer.context.plan.visibility, frame.bakes.without_indirect());
  if (recorded_ && recorded_->of == now) return recorded_->complete;
  const std::vector<std::size_t> drawn = items(scene);
  constexpr std::size_t kLayerBytes = 48, kHeaderBytes = 16, kMostBytes = std::size_t{1} << 27;
  const int w = frame.size().grid_width(), h = frame.size().grid_height();
  const std::size_t points = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  Recorded& r = recorded_.emplace(Recorded{});
  r.of = now;
  if (std::any_of(drawn.begin(), drawn.end(), [&](std::size_t i) { return kind_of(scene, i).surface; })) return false;
  r.heads = Texture::make_2d("pane layers by point", GL_R32UI, w, h);
  r.layers = Buffer("pane layers", std::min(kHeaderBytes + points * kLayerBytes, kMostBytes));
  r.layer_view = Texture::make_buffer("pane layers", GL_RGBA32UI, r.layers);
  const GLuint none[4] = {};
  glClearTexImage(r.heads.get(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, none);
  glClearNamedBufferSubData(r.layers.get(), GL_R32UI, 0, kHeaderBytes, GL_RED_INTEGER, GL_UNSIGNED_INT, none);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPaneLayers, r.layers.get());
  glBindImageTexture(kImagePaneHeads, r.heads.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
  draw_items(scene, drawn, behind, true);
  std::uint32_t count = 0;
  r.layers.read(0, sizeof count, &count);
  r.complete = kHeaderBytes + count * kLayerBytes <= r.layers.bytes();
  if (r.complete) {
    r.covered_tiles = make_tile_list(surfaces.size(), surfaces.band_rows());
    r.bare_tiles = make_tile_list(surfaces.size(), surfaces.band_rows());
    counter_ = TileCounter(r.bare_tiles.counts.size());
    glBindTextureUnit(kUnitPaneHeads, r.heads.get());
    const Program& split =
        counter_.begin(&frame.programs, kPaneTiles, surfaces.band_rows(), r.covered_tiles, &r.bare_tiles);
    dispatch_tiles(split, surfaces.tiles(), kPerTile);
    counter_.end(&r.covered_tiles, &r.bare_tiles);
  }
  return r.complete;
}

void Panes::bind_recorded(const Program& program, float rotation_rad) const {
  constexpr float kTurn_rad = 2.0f * std::numbers::pi_v<float>;
  glBindTextureUnit(kUnitPaneHeads, recorded_->heads.get());
  glBindTextureUnit(kUnitPaneLayers, recorded_->layer_view.get());
  program.set("u_rotation", std::remainder(rotation_rad, kTurn_rad) / kTurn_rad);
}

void Panes::draw(const PaneScene& scene, const Texture& behind) { draw_items(scene, items(scene), behind, false); }

void Panes::bind_framebuffer(const PaneScene& scene, const Texture& behind) {
  if (!framebuffer_) {
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    framebuffer_ = GlName<FramebufferTraits>(name);
  }
  glNamedFramebufferTexture(framebuffer_.get(), GL_DEPTH_ATTACHMENT, scene.frame.raster.depth_buffer().get(), 0);
  glNamedFramebufferTexture(framebuffer_.get(), GL_COLOR_ATTACHMENT0, behind.get(), 0);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glViewport(0, 0, scene.frame.size().grid_width(), scene.frame.size().grid_height());
}

void Panes::draw_items(const PaneScene& scene, const std::vector<std::size_t>& drawn, const Texture& behind,
                       bool record) {
  const std::string& layer = scene.frame.request.settings.get_string("reflections.layer");
  const bool on_black = !record && layer_weights(layer).z == 0.0f;
  if (drawn.empty() && !on_black) return;
  SceneState& state = scene.frame.scene;
  bind_framebuffer(scene, behind);
  if (on_black) clear_colors(framebuffer_.get());
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CLIP_DISTANCE0);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  record ? glDisable(GL_BLEND) : glEnable(GL_BLEND);
  if (record) glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glBlendFuncSeparate(GL_ONE, GL_SRC1_COLOR, GL_ZERO, GL_ONE);  // alpha stays: 0 where only the sky is behind
  glFrontFace(GL_CCW);
  glCullFace(GL_BACK);
  std::vector<std::size_t> two_sided;
  std::copy_if(drawn.begin(), drawn.end(), std::back_inserter(two_sided),
               [&](std::size_t i) { return state.shows_both_sides(i) && !scene.reflectors.is_mirror(i); });
  sort(scene, two_sided);
  glBindVertexArray(state.buffers().vertex_array());
  for (std::size_t i : drawn) draw_item(scene, i, record);
  glVertexArrayElementBuffer(state.buffers().vertex_array(), state.buffers().indices());
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  end_triangles();
  glDisable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ZERO);  // a second source forbids draws into several images, even while nothing blends
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void Panes::draw_item(const PaneScene& scene, std::size_t i, bool record) const {
  const SceneState& state = scene.frame.scene;
  const SceneBuffers& buffers = state.buffers();
  const DrawItem& item = state.geometry().items[i];
  const Material& m = state.material_of_item(i);
  const ShadingPlan& plan = scene.layers[static_cast<std::size_t>(scene.parts.layer_of_item(i))].context.plan;
  state.shows_both_sides(i) ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
  PaneKind kind = kind_of(scene, i);
  kind.record = record;
  const Program& program = scene.frame.programs.get(pane_variant(plan, kind));
  if (plan.visibility == "traced") scene.frame.bakes.octree().buffers().set_uniforms(program);
  glUseProgram(program.get());
  const bool blends = m.alpha_mode == AlphaMode::blend;
  glUniform1f(program.location("u_cutoff"), m.alpha_mode == AlphaMode::mask ? m.alpha_cutoff : -1.0f);
  glUniform1i(program.location("u_blends"), blends ? 1 : 0);
  glUniform4f(program.location("u_base"), m.base_color.r, m.base_color.g, m.base_color.b, m.base_color.a);
  glUniform3f(program.location("u_emission"), m.emissive.r, m.emissive.g, m.emissive.b);
  if (kind.surface) scene.blended->bind(program);
  glUniform2f(program.location("u_pane"), pane_share(m), m.ior);
  if (kind.specular)
    glUniform4f(program.location("u_specular"), m.specular_color.r, m.specular_color.g, m.specular_color.b, m.specular);
  const glm::vec3 weights = layer_weights(scene.frame.request.settings.get_string("reflections.layer"));
  glUniform3f(program.location("u_layer"), weights.x, weights.y, weights.z);
  if (kind.reflected != PaneKind::Reflected::none) program.set("u_reflector", scene.reflectors.of_item(i));
  const glm::vec3 absorption = volume_absorption(m) * item.scale;
  glUniform3f(program.location("u_absorption"), absorption.r, absorption.g, absorption.b);
  if (kind.texture) {
    const PaneTextures textures = textures_of(state, i);
    glUniform1iv(program.location("u_textures"), static_cast<GLsizei>(textures.size()), textures.data());
    program.set("u_normal_scale", m.normal_scale);
    program.set("u_metallic", m.metallic);
  }
  const auto sorted = order_->first.find(i);
  const bool is_sorted = sorted != order_->first.end();
  glVertexArrayElementBuffer(buffers.vertex_array(), is_sorted ? order_->indices.get() : buffers.indices());
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(item.index_count), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>((is_sorted ? sorted->second : item.first_index) * std::uintptr_t{4}));
}

std::size_t Panes::bytes() const {
  std::size_t sum = order_ ? order_->indices.bytes() : 0;
  if (recorded_)
    sum += recorded_->layers.bytes() + recorded_->heads.bytes() + recorded_->covered_tiles.tiles.bytes() +
           recorded_->bare_tiles.tiles.bytes();
  return sum;
}

}  // namespace maquette
