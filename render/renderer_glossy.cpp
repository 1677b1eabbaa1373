// What glossy opaque surfaces mirror of the scene, by rays through the octree; docs/reflections.md says which light
// that is.
#include <algorithm>
#include <array>

#include "render/renderer_impl.h"

namespace maquette {

ShaderVariant glossy_variant(bool measured, bool indirect) {
  return {"reflections/glossy.comp", "", {{"MEASURED", flag(measured)}, {"INDIRECT", flag(indirect)}}};
}
ShaderVariant glossy_rays_variant(bool measured) {
  return {"reflections/glossy_rays.comp", "", {{"MEASURED", flag(measured)}}};
}

ShaderVariant glossy_tiles_variant(bool measured) {
  return {"reflections/glossy_tiles.comp", "", {{"MEASURED", flag(measured)}}};
}

std::vector<bool> Renderer::Impl::glossy_items(float roughness) const {
  std::vector<bool> smooth;
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) {
    const Material& m = material_of_item(i);
    const int slot = slots[static_cast<std::size_t>(buffers->material(i))];
    const bool opaque = !m.glass && m.alpha_mode != AlphaMode::blend && !m.unlit;
    smooth.push_back(opaque && (slot >= 0 ? materials.roughness(slot) : least_roughness(m)) <= roughness);
  }
  return smooth;
}

std::vector<std::size_t> Renderer::Impl::named_glossy_items(const FrameRequest& request) const {
  std::vector<std::size_t> named;
  const std::vector<bool> smooth = glossy_items(kMostGlossyRoughness);
  for (std::size_t i = 0; i < smooth.size() && named.size() < kMaxReflectors; ++i) {
    const int node = buffers->geometry().items[i].node;
    if (!smooth[i] || node < 0 || is_mirror(i)) continue;
    const std::string& name = scene->nodes[static_cast<std::size_t>(node)].name;
    if (std::find(request.reflectors.begin(), request.reflectors.end(), name) != request.reflectors.end())
      named.push_back(i);
  }
  return named;
}

int Renderer::Impl::glossy_in_view(const FrameRequest& request) const {
  if (request.reflections != "octree") return 0;
  const auto roughness = static_cast<float>(request.settings.get_double("octree.glossy"));
  std::vector<bool> smooth =
      roughness > 0.0f ? glossy_items(roughness) : std::vector<bool>(buffers->geometry().items.size(), false);
  for (const std::size_t i : named_glossy_items(request)) smooth[i] = true;
  const glm::mat4 clip = clip_from_world(camera_frame(request));
  int count = 0;
  for (std::size_t i = 0; i < smooth.size(); ++i)
    count += smooth[i] && !is_mirror(i) && buffers->visible(i) && may_be_seen(clip, buffers->bounds(i));
  return count;
}

void Renderer::Impl::update_glossy(FramePlan* plan) {
  if (plan->glossy) {
    std::string why;
    if (!octree.ready())
      why = "its octree is not built yet";
    else if (plan->visibility == "none")
      why = "it waits for the bake of visibility";
    else if (plan->visibility == "baked" && plan->indirect != "baked")
      why = "it waits for the bake of indirect light";
    if (why.empty()) return;
    plan->glossy = false;
    std::erase_if(plan->passes, [](const PlannedPass& pass) { return pass.name == "glossy"; });
    plan->left_out.push_back({"glossy", why});
  }
  glossy.reset();
  glossy_light = Texture();
  glossy_tiles = TileList();
  glossy_technique.reset();
  glossy_traced.reset();
}

void Renderer::Impl::set_glossy(const Program& program, const FrameRequest& request) const {
  std::array<glm::ivec2, kMaxReflectors> triangles{};
  const std::vector<std::size_t> named = named_glossy_items(request);
  for (std::size_t k = 0; k < named.size(); ++k) {
    const DrawItem& item = buffers->geometry().items[named[k]];
    triangles[k] = glm::ivec2(item.first_index, item.first_index + item.index_count) / 3;
  }
  glProgramUniform2iv(program.get(), program.location("u_named"), static_cast<GLsizei>(kMaxReflectors),
                      &triangles[0].x);
  program.set("u_named_count", static_cast<int>(named.size()));
  program.set("u_roughness", static_cast<float>(request.settings.get_double("octree.glossy")));
  program.set("u_divisor", reflection_divisor(request.settings));
}

void Renderer::Impl::find_glossy(const FrameRequest& request) {
  FrameTargets& t = *targets;
  glossy_tiles.counts.resize(t.surface_tiles.counts.size());
  if (glossy_tiles.tiles.bytes() != t.surface_tiles.tiles.bytes())
    glossy_tiles.tiles = Buffer("glossy tiles", t.surface_tiles.tiles.bytes());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, t.tile_counts.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, glossy_tiles.tiles.get());
  t.tile_counts.clear_to_zero();
  const Program& program = programs.get(glossy_tiles_variant(facts.measured_count > 0));
  set_glossy(program, request);
  program.set("u_band_rows", t.band_rows / FrameTargets::kTile);
  dispatch_tiles(program, t.surface_tiles, 0);
  std::vector<unsigned> counts(2 * glossy_tiles.counts.size());
  t.tile_counts.read(0, t.tile_counts.bytes(), counts.data());
  for (std::size_t band = 0; band < glossy_tiles.counts.size(); ++band)
    glossy_tiles.counts[band] = static_cast<int>(counts[2 * band]);
  if (!glossy_light || glossy_light.width() != t.grid_width() || glossy_light.height() != t.grid_height())
    glossy_light = Texture::make_2d("glossy light", GL_RGBA32F, t.grid_width(), t.grid_height());
  const float none[4] = {};
  for (const Texture* image : {&glossy_light, &glossy->ray_origin, &glossy->ray_direction})
    glClearTexImage(image->get(), 0, GL_RGBA, GL_FLOAT, none);
}

void Renderer::Impl::cast_glossy_rays(const FrameRequest& request) {
  const ReflectionTargets& t = *glossy;
  const Program& program = programs.get(glossy_rays_variant(facts.measured_count > 0));
  set_glossy(program, request);
  octree.buffers().set_uniforms(program);
  glBindImageTexture(0, t.ray_origin.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(1, t.ray_direction.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(2, t.focus.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R16F);
  dispatch_tiles(program, glossy_tiles, t.divisor == 1 ? 6 : t.divisor == 2 ? 4 : 2);
}

void Renderer::Impl::reflect_glossy(const FramePlan& plan, const FrameRequest& request, PassTimer* timer) {
  timer->count_all_as("glossy");
  const int divisor = reflection_divisor(request.settings);
  const TracedKey key{drawn_surfaces ? *drawn_surfaces : SurfaceKey{}, epoch, "octree", request.reflectors,
                      request.settings};
  const bool had = glossy.has_value();
  fit_targets(divisor, &glossy);
  if (!glossy->mean) glossy->mean = Texture::make_2d("glossy radiance", GL_RGBA32F, glossy->width, glossy->height);
  glossy_kept = had && drawn_surfaces && glossy_traced == key && request.settings.get_bool("shading.reuse");
  // The other modes average whole pictures.
  glossy_frames = plan.mode == "bandwidth" && glossy_kept && accumulated > 1 ? glossy_frames + 1 : 1;
  if (!glossy_kept) {
    find_glossy(request);
    cast_glossy_rays(request);
  }
  std::swap(reflection, glossy);
  reflect_at(divisor, RayKind::glossy, plan, request, timer);
  std::swap(reflection, glossy);
  glossy_traced = key;
  bind_frame();
  const bool baked = plan.indirect == "baked";
  const Program& program = programs.get(glossy_variant(facts.measured_count > 0, baked));
  set_glossy(program, request);
  program.set("u_lift_m", octree.buffers().cell_m());
  if (baked) bind_indirect(program, indirect.blend() > 0.5f ? indirect.keys().back() : indirect.keys().front());
  glBindTextureUnit(49, glossy->ray_origin.get());
  glBindTextureUnit(50, glossy->ray_direction.get());
  glBindTextureUnit(53, glossy->mean.get());
  glBindImageTexture(0, glossy_light.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  dispatch_tiles(program, glossy_tiles, 6);
  timer->end("glossy");
  timer->count_all_as("");
}

}  // namespace maquette
