#include "render/reflections/skipping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/luminance.h"

namespace maquette {

namespace {

const ShaderVariant kCover{"reflections/cover.frag", "reflections/cover.vert", {}},
    kSkip{"reflections/skip.comp", "", {}};

float channel_min(const glm::vec3& c) { return std::min({c.x, c.y, c.z}); }

/// What may make lobes other than the material's factors say, or than a round lobe with Schlick's term.
bool varies(const Material& m) {
  return m.metallic_roughness_texture || m.clearcoat_roughness_texture || m.sheen_roughness_texture ||
         m.clearcoat_normal_texture || m.anisotropy > 0.0f || m.iridescence > 0.0f;
}

shared::AnalyticMaterial analytic_of(const Material& m) {
  return shared::make_analytic(glm::vec3(m.base_color), m.metallic, m.roughness, m.ior, m.specular, m.specular_color,
                               m.clearcoat, m.clearcoat_roughness, m.sheen_color, m.sheen_roughness);
}

/// How much comes through a pane varies slowly: so many quads of a patch along either side are one.
constexpr std::uint32_t kCoverQuads = 4;

}  // namespace

std::vector<ShaderVariant> Skipping::shader_variants() { return {kCover, kSkip}; }

std::string Skipping::why_all(const FrameRequest& request, const Technique& technique, const ReflectorSet& reflectors,
                              bool traced) {
  if (!reflectors.has_panes()) return "nothing is seen through an opaque mirror";
  if (!request.display) return "the picture is one to measure";
  if (request.settings.get_double("reflections.skip") <= 0.0) return "reflections.skip is 0";
  if (request.settings.get_bool("reflections.ghost")) return "two images are mirrored (reflections.ghost)";
  if (!technique.can.skips_rays)
    return "technique " + technique.name + " draws triangles, whatever becomes of single rays";
  if (!technique.can.skips_cheap_rays && !traced)
    return "a ray of technique " + technique.name + " and its shading cost less than to know that they are not needed";
  return {};
}

void Skipping::clear() { *this = Skipping(); }

bool Skipping::update_geometry(const SceneState& scene, const ReflectorSet& reflectors) {
  Key now = Key::of(scene.revisions().geometry);
  for (const Reflector& reflector : reflectors.all()) now.add(reflector.item);
  const std::vector<bool> occluding = scene.occluding_items();
  now.add(occluding);
  const bool rests = !geometry_ || seen_geometry_ == scene.revisions().geometry;
  seen_geometry_ = scene.revisions().geometry;
  if (geometry_ == now) return true;
  if (!rests) return false;
  bound_.set_geometry(scene.geometry(), occluding, reflectors.all());
  geometry_ = now;
  light_.reset();
  clip_from_world_.reset();
  parts_ = Buffer::from("parts of reflectors", bound_.part_of_triangle());
  part_view_ = Texture::make_buffer("parts of reflectors", GL_R32UI, parts_);
  return true;
}

int Skipping::lobe_of(SceneState* scene, std::size_t material, std::vector<LobeBound>* lobes) {
  static const Material kDefault;
  const std::vector<Material>& materials = scene->effective_materials();
  const Material& m = material < materials.size() ? materials[material] : kDefault;
  const int slot = material < scene->slots().size() ? scene->slots()[material] : -1;
  if (slot >= 0) {
    lobes->push_back(scene->materials().lobe_bound(slot));
    if (m.tint_measured)
      for (auto& row : lobes->back().peak)
        for (float& v : row) v *= channel_max(glm::vec3(m.base_color));
  } else if (varies(m)) {
    lobes->push_back(unknown_lobe());
  } else {
    const shared::AnalyticMaterial analytic = analytic_of(m);
    auto known = std::find_if(lobes_.begin(), lobes_.end(),
                              [&](const Lobe& l) { return std::memcmp(&l.material, &analytic, sizeof analytic) == 0; });
    if (known == lobes_.end()) {
      lobes_.push_back({analytic, make_lobe_bound([&](const glm::vec3& wi, const glm::vec3& wo) {
                          return channel_max(shared::evaluate_analytic(analytic, wi, wo).total);
                        })});
      known = std::prev(lobes_.end());
    }
    lobes->push_back(known->bound);
  }
  return static_cast<int>(lobes->size()) - 1;
}

void Skipping::update_light(const FrameContext& frame, bool shadows) {
  SceneState& scene = frame.scene;
  const FrameRequest& request = frame.request;
  const Key key =
      Key::of(scene.revisions().all(), frame.bakes.all(), request.env_rotation_rad, request.env_scale, shadows);
  if (light_ != key) {
    light_ = key;
    clip_from_world_.reset();
    set_light(&scene, request, shadows);
  }
  if (clip_from_world_ == frame.constants.clip_from_world) return;
  bounds_ = Buffer::from("mirrored bounds", bound_.compute(frame.constants));
  bound_view_ = Texture::make_buffer("mirrored bounds", GL_R32F, bounds_);
  clip_from_world_ = frame.constants.clip_from_world;
}

void Skipping::set_light(SceneState* scene, const FrameRequest& request, bool shadows) {
  if (environment_ != scene->environment().shared_environment()) {
    environment_ = scene->environment().shared_environment();
    sky_ = make_sky_bound(*environment_);
  }
  BoundLight light;
  light.sky = &sky_;
  light.cosine = std::cos(request.env_rotation_rad);
  light.sine = std::sin(request.env_rotation_rad);
  light.scale = request.env_scale;
  light.shadows = shadows;
  const std::size_t count = scene->effective_materials().size();
  std::vector<int> lobe_of_material(count + 1, -1);
  for (std::size_t i = 0; i < scene->geometry().items.size(); ++i) {
    const Material& m = scene->material_of_item(i);
    const auto material = std::min(static_cast<std::size_t>(scene->buffers().material(i)), count);
    int& lobe = lobe_of_material[material];
    if (lobe < 0) lobe = lobe_of(scene, material, &light.lobes);
    const float own = m.unlit ? channel_max(glm::vec3(m.base_color)) : 0.0f;
    light.surfaces.push_back({lobe, channel_max(m.emissive) + own,
                              static_cast<bool>(m.normal_texture) || static_cast<bool>(m.clearcoat_normal_texture)});
  }
  bound_.set_light(light);
}

void Skipping::draw_cover(const MirroredScene& mirrored, const ReflectionTargets& t) {
  const SceneState& scene = mirrored.frame.scene;
  const SceneBuffers& buffers = scene.buffers();
  ReflectorSet& reflectors = mirrored.reflectors;
  reflectors.update_coarse_patches(scene);
  if (cover_.width() != t.width || cover_.height() != t.height) {
    cover_ = Texture::make_2d("cover", GL_R16F, t.width, t.height);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    framebuffer_ = GlName<FramebufferTraits>(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, cover_.get(), 0);
  }
  const float all[4] = {1.0f, 1.0f, 1.0f, 1.0f};
  glClearNamedFramebufferfv(framebuffer_.get(), GL_COLOR, 0, all);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glViewport(0, 0, t.width, t.height);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_CLIP_DISTANCE0);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ZERO, GL_SRC_COLOR);
  const Program& program = mirrored.frame.programs.get(kCover);
  glUseProgram(program.get());
  glBindVertexArray(buffers.vertex_array());
  for (std::size_t i = 0; i < scene.geometry().items.size(); ++i) {
    const Material& m = scene.material_of_item(i);
    if (!buffers.visible(i) || !(scene.is_transparent(i) || reflectors.is_mirror(i))) continue;
    if (!may_be_seen(mirrored.frame.constants.clip_from_world, buffers.bounds(i))) continue;
    const bool known = !m.base_color_texture && !m.transmission_texture && !m.metallic_roughness_texture &&
                       !(m.thickness > 0.0f) && m.alpha_mode != AlphaMode::mask && has_plain_faces(m) &&
                       !reflectors.is_mirror(i);
    const float share = known ? pane_share(m) : 0.0f;
    glUniform4f(program.location("u_cover"), share, std::max(m.ior, 1.0f),
                std::clamp(channel_min(glm::vec3(m.base_color)), 0.0f, 1.0f),
                known && m.alpha_mode == AlphaMode::blend ? std::clamp(1.0f - m.base_color.a, 0.0f, 1.0f) : 0.0f);
    const CoarsePatch::Level* level = nullptr;
    if (const auto patch = reflectors.coarse_patches().of_item.find(i);
        patch != reflectors.coarse_patches().of_item.end())
      for (const CoarsePatch::Level& l : patch->second.levels)
        if (l.quads == kCoverQuads) level = &l;
    reflectors.draw_level(scene, i, level);
  }
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  end_triangles();
  glDisable(GL_BLEND);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void Skipping::bind(const MirroredScene& mirrored, const ReflectionTargets& probes, const Texture& behind,
                    const Program& program) {
  const SceneState& scene = mirrored.frame.scene;
  const std::vector<Reflector>& reflectors = mirrored.reflectors.all();
  if (!counters_) counters_ = Buffer("skipped rays", 2 * sizeof(unsigned));
  counters_.clear_to_zero();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferSkipCounters, counters_.get());
  glBindTextureUnit(kUnitReflectorParts, part_view_.get());
  glBindTextureUnit(kUnitPartBounds, bound_view_.get());
  glBindTextureUnit(kUnitCover, cover_.get());
  glBindTextureUnit(kUnitOpaque, behind.get());
  glBindTextureUnit(kUnitProbes, probes.radiance.get());
  glBindTextureUnit(kUnitProbeDirections, probes.ray_direction.get());
  std::array<GLint, kMaxReflectors> offsets{};
  std::array<glm::vec3, kMaxReflectors> optics{};
  for (std::size_t k = 0; k < reflectors.size(); ++k) {
    const Material& m = scene.material_of_item(reflectors[k].item);
    const auto first = static_cast<GLint>(scene.geometry().items[reflectors[k].item].first_index / 3);
    offsets[k] = static_cast<GLint>(bound_.first_of_reflector()[k]) - first;
    optics[k] = {std::max(m.ior, 1.0f), std::clamp(channel_max(glm::vec3(m.base_color)), 0.0f, 1.0f),
                 reflectors[k].mirror || !has_plain_faces(m) ? 0.0f : 1.0f};
  }
  constexpr auto kCount = static_cast<GLsizei>(kMaxReflectors);
  glProgramUniform1iv(program.get(), program.location("u_part_offset"), kCount, offsets.data());
  glProgramUniform3fv(program.get(), program.location("u_optics"), kCount, &optics[0].x);
  glProgramUniform1f(program.get(), program.location("u_contrast"),
                     static_cast<float>(mirrored.frame.request.settings.get_double("reflections.skip")));
}

void Skipping::mark(const MirroredScene& scene, const ReflectionTargets& t, const ReflectionTargets& probes,
                    int spacing, const Texture& behind) {
  const Program& program = scene.frame.programs.get(kSkip);
  bind(scene, probes, behind, program);
  program.set("u_divisor", t.divisor);
  program.set("u_spacing", spacing);
  glBindTextureUnit(kUnitPane, t.pane.get());
  glBindImageTexture(kImageRayOrigin, t.ray_origin.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(kImageRayDirection, t.ray_direction.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  dispatch_tiles(program, t.tiles, kPerPoint);
}

void Skipping::add_counters(std::map<std::string, double>* counters) const {
  unsigned counts[2];
  counters_.read(0, sizeof counts, counts);
  (*counters)["rays_skipped"] = counts[1];
  (*counters)["rays_skipped_share"] = counts[1] / std::max(1.0 * counts[0] + counts[1], 1.0);
}

}  // namespace maquette
