// Which mirrored rays are not followed, because what they bring is invisible before what is seen through the pane.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "render/material_overrides.h"
#include "render/renderer_impl.h"

namespace maquette {

namespace {

const ShaderVariant kCover{"reflections/cover.frag", "reflections/cover.vert", {}};

float channel_max(const glm::vec3& c) { return std::max({c.x, c.y, c.z}); }
float channel_min(const glm::vec3& c) { return std::min({c.x, c.y, c.z}); }

/// Textures that may make a lobe narrower than the material's factors say.
bool varies(const Material& m) {
  return m.metallic_roughness_texture || m.clearcoat_roughness_texture || m.sheen_roughness_texture;
}

shared::AnalyticMaterial analytic_of(const Material& m) {
  return shared::make_analytic(glm::vec3(m.base_color), m.metallic, m.roughness, m.ior, m.specular, m.specular_color,
                               m.clearcoat, m.clearcoat_roughness, m.sheen_color, m.sheen_roughness);
}

/// How much comes through a pane varies slowly: so many quads of a patch along either side are one.
constexpr std::uint32_t kCoverQuads = 4;

}  // namespace

bool Renderer::Impl::update_skipping(FramePlan* plan, const FrameRequest& request) {
  const auto leave_out = [&](const std::string& why) {
    plan->left_out.push_back({"skip", why});
    return false;
  };
  if (plan->reflections.empty()) return false;
  const auto wanted = [&] { return request.display && request.settings.get_double("reflections.skip") > 0.0; };
  const bool panes = std::any_of(reflectors.begin(), reflectors.end(), [](const Reflector& r) { return !r.mirror; });
  if (!wanted() || !panes) {
    skipping.reset();
    return leave_out(!panes            ? "nothing is seen through an opaque mirror"
                     : request.display ? "reflections.skip is 0"
                                       : "the picture is one to measure");
  }
  if (request.settings.get_bool("reflections.ghost")) {
    skipping.reset();
    return leave_out("two images are mirrored (reflections.ghost)");
  }
  if (plan->reflections != "raytraced" && plan->reflections != "octree") {
    skipping.reset();
    return leave_out("technique " + plan->reflections + " draws triangles, whatever becomes of single rays");
  }
  if (plan->reflections == "raytraced" && plan->visibility != "traced") {
    skipping.reset();
    return leave_out("a ray of technique raytraced and its shading cost less than to know that they are not needed");
  }
  if (!skipping) skipping.emplace();
  if (!update_skip_geometry()) return leave_out("geometry changes from frame to frame");
  update_skip_light(*plan, request);
  Skipping& s = *skipping;
  if (s.clip_from_world != constants.clip_from_world) {
    s.bounds = Buffer::from("mirrored bounds", s.bound.compute(constants));
    s.bound_view = Texture::make_buffer("mirrored bounds", GL_R32F, s.bounds);
    s.clip_from_world = constants.clip_from_world;
  }
  plan->passes.push_back(
      {"skip", "mirrored rays that bring less than reflections.skip of what is seen through the pane"});
  return true;
}

bool Renderer::Impl::update_skip_geometry() {
  Skipping& s = *skipping;
  std::vector<std::size_t> items;
  for (const Reflector& reflector : reflectors) items.push_back(reflector.item);
  std::vector<bool> occluding = transmitting_items();
  occluding.flip();
  const bool rests = !s.geometry_epoch || s.seen_epoch == geometry_epoch;
  s.seen_epoch = geometry_epoch;
  if (s.geometry_epoch == geometry_epoch && s.items == items && s.occluding == occluding) return true;
  if (!rests) return false;
  s.bound.set_geometry(buffers->geometry(), occluding, reflectors);
  s.geometry_epoch = geometry_epoch;
  s.items = std::move(items);
  s.occluding = std::move(occluding);
  s.light.reset();
  s.clip_from_world.reset();
  s.parts = Buffer::from("parts of reflectors", s.bound.part_of_triangle());
  s.part_view = Texture::make_buffer("parts of reflectors", GL_R32UI, s.parts);
  return true;
}

int Renderer::Impl::lobe_of(std::size_t material, std::vector<LobeBound>* lobes) {
  static const Material kDefault;
  const Material& m = material < effective.size() ? effective[material] : kDefault;
  const int slot = material < slots.size() ? slots[material] : -1;
  if (slot >= 0) {
    lobes->push_back(materials.lobe_bound(slot));
    if (m.tint_measured)
      for (auto& row : lobes->back().peak)
        for (float& v : row) v *= channel_max(glm::vec3(m.base_color));
  } else if (varies(m)) {
    lobes->push_back(unknown_lobe());
  } else {
    const shared::AnalyticMaterial analytic = analytic_of(m);
    auto known = std::find_if(skipping->lobes.begin(), skipping->lobes.end(), [&](const Skipping::Lobe& l) {
      return std::memcmp(&l.material, &analytic, sizeof analytic) == 0;
    });
    if (known == skipping->lobes.end()) {
      skipping->lobes.push_back({analytic, make_lobe_bound([&](const glm::vec3& wi, const glm::vec3& wo) {
                                   return channel_max(shared::evaluate_analytic(analytic, wi, wo).total);
                                 })});
      known = std::prev(skipping->lobes.end());
    }
    lobes->push_back(known->bound);
  }
  return static_cast<int>(lobes->size()) - 1;
}

void Renderer::Impl::update_skip_light(const FramePlan& plan, const FrameRequest& request) {
  Skipping& s = *skipping;
  const SkipLightKey key{epoch, request.env_rotation_rad, request.env_scale, plan.visibility != "none"};
  if (s.light == key) return;
  s.light = key;
  s.clip_from_world.reset();
  if (s.environment != environment->shared_environment()) {
    s.environment = environment->shared_environment();
    s.sky = make_sky_bound(*s.environment);
  }
  BoundLight light;
  light.sky = &s.sky;
  light.cosine = std::cos(request.env_rotation_rad);
  light.sine = std::sin(request.env_rotation_rad);
  light.scale = request.env_scale;
  light.shadows = plan.visibility != "none";
  std::vector<int> lobe_of_material(effective.size() + 1, -1);
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) {
    const Material& m = material_of_item(i);
    const auto material = std::min(static_cast<std::size_t>(buffers->material(i)), effective.size());
    int& lobe = lobe_of_material[material];
    if (lobe < 0) lobe = lobe_of(material, &light.lobes);
    const float own = m.unlit ? channel_max(glm::vec3(m.base_color)) : 0.0f;
    light.surfaces.push_back({lobe, channel_max(m.emissive) + own,
                              static_cast<bool>(m.normal_texture) || static_cast<bool>(m.clearcoat_normal_texture)});
  }
  s.bound.set_light(light);
}

void Renderer::Impl::draw_cover() {
  update_coarse_patches();
  Skipping& s = *skipping;
  const ReflectionTargets& t = *reflection;
  if (s.cover.width() != t.width || s.cover.height() != t.height) {
    s.cover = Texture::make_2d("cover", GL_R16F, t.width, t.height);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    s.framebuffer = GlName<FramebufferTraits>(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, s.cover.get(), 0);
  }
  const float all[4] = {1.0f, 1.0f, 1.0f, 1.0f};
  glClearNamedFramebufferfv(s.framebuffer.get(), GL_COLOR, 0, all);
  glBindFramebuffer(GL_FRAMEBUFFER, s.framebuffer.get());
  glViewport(0, 0, t.width, t.height);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ZERO, GL_SRC_COLOR);
  const Program& program = programs.get(kCover);
  glUseProgram(program.get());
  glBindVertexArray(buffers->vertex_array());
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) {
    const Material& m = material_of_item(i);
    if (!buffers->visible(i) || !(m.glass || m.alpha_mode == AlphaMode::blend || is_mirror(i))) continue;
    if (!may_be_seen(constants.clip_from_world, buffers->bounds(i))) continue;
    const bool known = !m.base_color_texture && !is_mirror(i);
    const float share = known ? pane_share(m) : 0.0f;
    glUniform4f(program.location("u_cover"), share, std::max(m.ior, 1.0f),
                std::clamp(channel_min(glm::vec3(m.base_color)), 0.0f, 1.0f),
                known && m.alpha_mode == AlphaMode::blend ? std::clamp(1.0f - m.base_color.a, 0.0f, 1.0f) : 0.0f);
    const CoarsePatch::Level* level = nullptr;
    if (const auto patch = coarse_patches.of_item.find(i); patch != coarse_patches.of_item.end())
      for (const CoarsePatch::Level& l : patch->second.levels)
        if (l.quads == kCoverQuads) level = &l;
    draw_level(i, level);
  }
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glDisable(GL_BLEND);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void Renderer::Impl::bind_skipping(const Program& rays, float contrast) {
  Skipping& s = *skipping;
  if (!s.counters) s.counters = Buffer("skipped rays", 2 * sizeof(unsigned));
  s.counters.clear_to_zero();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 8, s.counters.get());
  glBindTextureUnit(56, s.part_view.get());
  glBindTextureUnit(57, s.bound_view.get());
  glBindTextureUnit(58, s.cover.get());
  glBindTextureUnit(59, under_panes().get());
  glBindTextureUnit(60, probes->radiance.get());
  glBindTextureUnit(61, probes->ray_direction.get());
  std::array<GLint, kMaxReflectors> offsets{};
  std::array<glm::vec3, kMaxReflectors> optics{};
  for (std::size_t k = 0; k < reflectors.size(); ++k) {
    const Material& m = material_of_item(reflectors[k].item);
    const auto first = static_cast<GLint>(buffers->geometry().items[reflectors[k].item].first_index / 3);
    offsets[k] = static_cast<GLint>(s.bound.first_of_reflector()[k]) - first;
    optics[k] = {std::max(m.ior, 1.0f), std::clamp(channel_max(glm::vec3(m.base_color)), 0.0f, 1.0f),
                 reflectors[k].mirror ? 0.0f : 1.0f};
  }
  constexpr auto kCount = static_cast<GLsizei>(kMaxReflectors);
  glProgramUniform1iv(rays.get(), rays.location("u_part_offset"), kCount, offsets.data());
  glProgramUniform3fv(rays.get(), rays.location("u_optics"), kCount, &optics[0].x);
  glProgramUniform1f(rays.get(), rays.location("u_contrast"), contrast);
}

}  // namespace maquette
