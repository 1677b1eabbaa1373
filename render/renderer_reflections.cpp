// What the reflectors show: their rays, the hits that a technique finds, and the hits' shading by the frame's own mode.
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/gtc/packing.hpp>
#include <span>
#include <utility>

#include "render/bezier/patch_fit_store.h"
#include "render/bezier/projection.h"
#include "render/bezier/reflector_patch.h"
#include "render/octree/reflections.h"
#include "render/reflections/nearest_hits.h"
#include "render/reflections/reflector_technique.h"
#include "render/renderer_impl.h"
#include "render/triangle/reflections.h"
#include "scenes/error.h"

namespace maquette {

namespace {

/// A probe for so many points each way decides whether they are followed.
constexpr int kProbeSpacing = 4;
/// So much of a pixel of the reflected picture a pane's outline may be off. What it mirrors is found on the true patch.
constexpr float kPaneTolerance_px = 0.1f;
/// Of the environment, for cells with BRDFs in the modes that look tables up: they show no noise.
constexpr int kLookupLayerSamples = 64;

int groups(int count, int size) { return (count + size - 1) / size; }

/// std140 twin of the block in shaders/reflections/reflectors.glsl.
struct ReflectorBlock {
  glm::ivec4 mirrors[kMaxReflectors]{};
  PatchRecord patches[kMaxPatches]{};
};

/// An item as it is in the scene, wherever it stands in the arrays.
PatchFitPart part_of(const Scene& scene, const FlatGeometry& geometry, const DrawItem& item) {
  PatchFitPart part;
  const auto copy = [&](const auto& all, auto* own) {
    const auto begin = all.begin() + item.first_vertex;
    own->assign(begin, begin + item.vertex_count);
    part.hash = XXH3_64bits_withSeed(own->data(), own->size() * sizeof(*own->data()), part.hash);
  };
  copy(geometry.positions, &part.positions);
  copy(geometry.normals, &part.normals);
  copy(geometry.uv0, &part.uvs);
  for (std::uint32_t k = 0; k < item.index_count; ++k)
    part.indices.push_back(geometry.indices[item.first_index + k] - item.first_vertex);
  part.hash = XXH3_64bits_withSeed(part.indices.data(), part.indices.size() * sizeof(std::uint32_t), part.hash);
  if (const Mesh& mesh = scene.meshes[static_cast<std::size_t>(item.mesh)]; mesh.cage && item.primitive == 0) {
    part.cage = mesh.cage;
    part.world_from_node = compute_world_transforms(scene)[static_cast<std::size_t>(item.node)];
  }
  return part;
}

std::string fit_line(const Reflector& reflector) { return "'" + reflector.name + "': " + fit_text(*reflector.fit); }

ShaderVariant rays_variant(bool ghost, bool fitted) {
  return {"reflections/rays.comp", "", {{"GHOST", flag(ghost)}, {"FITTED", flag(fitted)}}};
}

ShaderVariant list_tiles_variant(bool rays) { return {"reflections/list_tiles.comp", "", {{"RAYS", flag(rays)}}}; }

ShaderVariant reflected_shade_variant(const FramePlan& plan, int measured) {
  return {"shading/shade.comp",
          "",
          {{"REFLECTED", "1"},
           {"MEASURED", flag(measured)},
           {"VISIBILITY", visibility_define(plan)},
           {"LIGHTS", flag(plan.lights)}}};
}

ShaderVariant reflected_resolve_variant(bool textures, bool colors) {
  return {
      "gbuffer/resolve.comp",
      "",
      {{"REFLECTED", "1"}, {"TEXTURES", flag(textures)}, {"TEXTURE_BANDWIDTH", "0"}, {"VERTEX_COLORS", flag(colors)}}};
}

ShaderVariant reflected_mark_variant() {
  return {"bandwidth/mark.comp",
          "",
          {{"REFLECTED", "1"}, {"BANDWIDTH", "0"}, {"REFINE", "0"}, {"TEXTURES", "0"}, {"VISIBILITY", "0"}}};
}

ShaderVariant reflected_compose_variant(bool layers, bool glossy) {
  return {"shading/compose.comp",
          "",
          {{"REFLECTED", "1"},
           {"STAGE", "1"},
           {"TEXTURES", "0"},
           {"INDIRECT", "0"},
           {"PANES", "0"},
           {"LAYERS", flag(layers)},
           {"GLOSSY", flag(glossy)}}};
}

ShaderVariant reflected_indirect_variant(bool measured) {
  return {"shading/indirect.comp", "", {{"REFLECTED", "1"}, {"MEASURED", flag(measured)}}};
}

}  // namespace

int reflection_divisor(const Settings& settings) {
  const std::string& resolution = settings.get_string("reflections.resolution");
  return resolution == "full" ? 1 : resolution == "half" ? 2 : 4;
}

std::vector<ShaderVariant> reflection_shader_variants() {
  std::vector<ShaderVariant> variants{{"reflections/pane.frag", "reflections/pane.vert", {}},
                                      {"reflections/probes.comp", "", {}},
                                      list_tiles_variant(false),
                                      list_tiles_variant(true),
                                      {"reflections/skip.comp", "", {}},
                                      {"reflections/cover.frag", "reflections/cover.vert", {}},
                                      shade_cells_variant(false),
                                      shade_cells_variant(true),
                                      {"splitsum/shade.comp", "", {{"REFLECTED", "1"}}},
                                      {"sg/shade.comp", "", {{"REFLECTED", "1"}}},
                                      reflected_mark_variant()};
  for (const char* visibility : {"none", "baked", "traced"}) {
    for (int k = 0; k < 4; ++k) {
      FramePlan plan;
      plan.visibility = visibility;
      plan.lights = k & 1;
      variants.push_back(reflected_shade_variant(plan, k >> 1));
    }
  }
  for (const auto& more : {bezier_shader_variants(), triangle_shader_variants(), nearest_hits_shader_variants()})
    variants.insert(variants.end(), more.begin(), more.end());
  for (int k = 0; k < 4; ++k) {
    variants.push_back(rays_variant(k & 1, k & 2));
    variants.push_back(reflected_resolve_variant(k & 1, k & 2));
    variants.push_back(reflected_compose_variant(k & 1, k & 2));
    variants.push_back(octree_reflect_variant(k & 1, k & 2));
    variants.push_back(glossy_variant(k & 1, k & 2));
  }
  for (int k = 0; k < 2; ++k) {
    variants.push_back(reflected_indirect_variant(k));
    variants.push_back(glossy_rays_variant(k));
    variants.push_back(glossy_tiles_variant(k));
  }
  return variants;
}

void Renderer::Impl::forget_reflectors() {
  if (!reflectors.empty()) drawn_surfaces.reset();  // mirrors are opaque surfaces again
  reflectors.clear();
  fitting.clear();
  reflectors_epoch = 0;
}

void Renderer::Impl::update_reflectors(const FrameRequest& request) {
  if (request.reflections == "off") {
    patch_fits.cancel();
    forget_reflectors();
    coarse_epoch.reset();
    coarse_patches = {};
    coarse_indices = Buffer();
    return;
  }
  const bool fits = request.reflections == "bezier" && request.mode != "reference";  // which has no use for them
  if (!fits) patch_fits.cancel();
  if (fits && patch_fits.update()) ++epoch;
  const bool glossy_too = request.reflections == "octree";
  if (reflectors_epoch == epoch + 1 && reflectors_named == request.reflectors && reflectors_fitted == fits &&
      reflectors_glossy == glossy_too)
    return;
  std::vector<const Material*> item_materials;
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) item_materials.push_back(&material_of_item(i));
  forget_reflectors();  // what is refused below is refused in every frame
  reflectors = find_reflectors(*scene, buffers->geometry(), item_materials, request.reflectors,
                               glossy_too ? glossy_items(kMostGlossyRoughness) : std::vector<bool>());
  drawn_surfaces.reset();
  if (fits) fit_reflectors();
  upload_reflectors();
  reflectors_named = request.reflectors;
  reflectors_epoch = epoch + 1;
  reflectors_fitted = fits;
  reflectors_glossy = glossy_too;
}

void Renderer::Impl::fit_reflectors() {
  const FlatGeometry& geometry = buffers->geometry();
  std::vector<Reflector*> curved;
  std::vector<PatchFitPart> parts;
  std::vector<std::uint64_t> hashes;
  for (Reflector& reflector : reflectors) {
    if (reflector.patch || reflector.plane) continue;
    curved.push_back(&reflector);
    parts.push_back(part_of(*scene, geometry, geometry.items[reflector.item]));
    hashes.push_back(parts.back().hash);
  }
  patch_fits.want(hashes, [&](std::size_t i) { return std::move(parts[i]); });
  for (std::size_t i = 0; i < curved.size(); ++i) {
    Reflector& reflector = *curved[i];
    reflector.fit = patch_fits.find(hashes[i]);
    if (!reflector.fit) {
      fitting += (fitting.empty() ? "'" : ", '") + reflector.name + "'";
    } else if (reflector.fit->patches.empty()) {
      throw Error("--reflections bezier", "no patch fits '" + reflector.name + "': " + reflector.fit->why,
                  "correct the mesh, or use --reflections octree or raytraced");
    }
  }
  std::erase_if(reflectors, [](const Reflector& r) { return !r.patch && !r.plane && !r.fit; });
}

void Renderer::Impl::upload_reflectors() {
  auto block = std::make_unique<ReflectorBlock>();
  std::vector<glm::uvec4> triangles;
  std::size_t count = 0;
  std::string names;
  for (std::size_t i = 0; i < reflectors.size(); ++i) {
    Reflector& reflector = reflectors[i];
    glm::ivec4& mirror = block->mirrors[i];
    mirror = {-1, 0, 0, 0};
    std::vector<ReflectorPatch> patches;
    if (reflector.patch) patches.push_back(make_reflector_patch(reflector.points));
    if (reflector.patch && patches[0].degenerate) continue;
    if (reflector.fit) {
      for (const FittedPatch& patch : reflector.fit->patches) patches.push_back(make_reflector_patch(patch.points));
      const DrawItem& item = buffers->geometry().items[reflector.item];
      mirror.y = 1;
      mirror.z = static_cast<int>(triangles.size()) - static_cast<int>(item.first_index / 3);
      for (const FittedTriangle& t : reflector.fit->triangles) {
        const auto packed = [&](int k) { return glm::packSnorm2x16(glm::vec2(t.x[static_cast<std::size_t>(k)])); };
        const bool placed = t.patch >= 0 && !patches[static_cast<std::size_t>(t.patch)].degenerate;
        triangles.emplace_back(placed ? static_cast<unsigned>(count) + static_cast<unsigned>(t.patch) + 1u : 0u,
                               packed(0), packed(1), packed(2));
      }
      names += (names.empty() ? "" : ", ") + fit_line(reflector);
    }
    if (patches.empty()) continue;
    reflector.first_patch = static_cast<int>(count);
    if (reflector.patch) mirror.x = reflector.first_patch;
    for (const ReflectorPatch& patch : patches)
      if (count++ < kMaxPatches) block->patches[count - 1] = make_patch_record(patch);
  }
  if (count > kMaxPatches)
    throw Error("--reflections bezier",
                std::to_string(count) + " patches are more than the " + std::to_string(kMaxPatches) +
                    " that are drawn at once (" + names + ")",
                "name fewer with --reflector, or use --reflections octree or raytraced");
  reflector_block = Buffer("reflectors", sizeof *block, block.get());
  if (triangles.empty()) triangles.emplace_back(0u);
  fit_triangles = Buffer::from("fitted triangles", triangles);
  fit_triangle_view = Texture::make_buffer("fitted triangles", GL_RGBA32UI, fit_triangles);
}

/// What the fits are worth, for those who look at the plan.
void Renderer::Impl::note_fits(FramePlan* plan) const {
  if (!fitting.empty()) {
    if (reflectors.empty()) {
      std::erase_if(plan->left_out, [](const LeftOut& l) { return l.what == "reflections"; });
      plan->left_out.push_back({"reflections", "their patches are not fitted yet"});
    }
    plan->left_out.push_back(
        {"patch_fit", "patches are being fitted to " + fitting + ": " + percent(patch_fits.progress())});
  }
  if (plan->reflections != "bezier") return;
  std::string good, bad;
  for (const Reflector& reflector : reflectors) {
    if (!reflector.fit) continue;
    std::string* line = reflector.fit->met ? &good : &bad;
    *line += (line->empty() ? "" : ", ") + fit_line(reflector);
  }
  if (!good.empty()) plan->passes.push_back({"patch_fit", "curved meshes get bicubic patches: " + good});
  char tolerance[16];
  std::snprintf(tolerance, sizeof tolerance, "%.2g mm", 1e3 * kFitTolerance_m);
  if (!bad.empty())
    plan->passes.push_back({"patch_fit", std::string("patches miss these by more than ") + tolerance + ": " + bad +
                                             "; where a pixel's own ray is far from theirs it is hatched, and octree "
                                             "or raytraced shows it"});
}

void Renderer::Impl::keep_reflections(const FrameRequest& request, FramePlan* plan) {
  reflections_kept = false;
  tracing.reset();
  // An octree may have been built anew since, and what is skipped depends on the light.
  const bool may_keep = !plan->reflections.empty() && plan->reflections != "octree" && !skips && drawn_surfaces &&
                        request.settings.get_bool("shading.reuse");
  if (!may_keep) {
    traced.reset();
    return;
  }
  const TracedKey key{*drawn_surfaces, epoch, plan->reflections, request.reflectors, request.settings};
  reflections_kept = reflection && traced == key;
  if (!reflections_kept) {
    traced.reset();
    tracing = key;
    return;
  }
  for (const char* pass : {"projection", "rays"}) {
    if (std::erase_if(plan->passes, [&](const PlannedPass& p) { return p.name == pass; }) == 0) continue;
    plan->left_out.push_back({pass, "kept from the frame before: neither camera nor surfaces changed"});
  }
}

int Renderer::Impl::reflector_of_item(std::size_t item) const {
  for (std::size_t k = 0; k < reflectors.size(); ++k)
    if (reflectors[k].item == item) return static_cast<int>(k);
  return -1;
}

bool Renderer::Impl::is_mirror(std::size_t item) const {
  const int k = reflector_of_item(item);
  return k >= 0 && reflectors[static_cast<std::size_t>(k)].mirror;
}

bool Renderer::Impl::any_fitted() const {
  return std::any_of(reflectors.begin(), reflectors.end(), [](const Reflector& r) { return r.fit; });
}

int Renderer::Impl::reflectors_in_view(const FrameRequest& request) const {
  const glm::mat4 clip = clip_from_world(camera_frame(request));
  int count = 0;
  for (const Reflector& reflector : reflectors)
    count += buffers->visible(reflector.item) && may_be_seen(clip, buffers->bounds(reflector.item));
  return count;
}

void Renderer::Impl::update_coarse_patches() {
  if (coarse_epoch == geometry_epoch) return;
  coarse_epoch = geometry_epoch;
  coarse_patches = make_coarse_patches(buffers->geometry());
  const std::vector<std::uint32_t>& indices = coarse_patches.indices;
  coarse_indices = indices.empty() ? Buffer() : Buffer::from("coarse patches", indices);
}

void Renderer::Impl::draw_level(std::size_t i, const CoarsePatch::Level* level) const {
  const DrawItem& item = buffers->geometry().items[i];
  const std::uint32_t first = level ? level->first_index : item.first_index,
                      count = level ? level->index_count : item.index_count;
  if (level) glVertexArrayElementBuffer(buffers->vertex_array(), coarse_indices.get());
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(static_cast<std::uintptr_t>(first) * 4));
  if (level) glVertexArrayElementBuffer(buffers->vertex_array(), buffers->indices());
}

void Renderer::Impl::draw_panes(ReflectionTargets* t) {
  update_coarse_patches();
  const GLuint framebuffer = t->pane_framebuffer.get();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, t->width, t->height);
  const GLuint none[4] = {0, 0, 0, 0};
  const float far_depth = 0.0f;
  glClearNamedFramebufferuiv(framebuffer, GL_COLOR, 0, none);
  glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &far_depth);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glFrontFace(GL_CCW);
  glCullFace(GL_BACK);
  glBindVertexArray(buffers->vertex_array());
  const Program& program = programs.get({"reflections/pane.frag", "reflections/pane.vert", {}});
  glUseProgram(program.get());
  for (std::size_t k = 0; k < reflectors.size(); ++k) {
    const std::size_t i = reflectors[k].item;
    if (!buffers->visible(i) || !may_be_seen(constants.clip_from_world, buffers->bounds(i))) continue;
    const DrawItem& item = buffers->geometry().items[i];
    shows_both_sides(i) ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
    program.set("u_first_triangle", static_cast<int>(item.first_index / 3));
    program.set("u_reflector", static_cast<int>(k));
    const auto patch = coarse_patches.of_item.find(i);
    const CoarsePatch::Level* level =
        patch == coarse_patches.of_item.end()
            ? nullptr
            : coarsest_level(patch->second, glm::vec3(constants.eye),
                             kPaneTolerance_px * constants.forward.w * static_cast<float>(t->divisor));
    const PatchSides sides = level ? patch->second.sides : PatchSides{0, 0};
    glUniform2i(program.location("u_quads"), sides.u, sides.v);
    draw_level(i, level);
  }
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void Renderer::Impl::shade_reflections(const FramePlan& plan, RayKind kind, PassTimer* timer) {
  ReflectionTargets& t = *reflection;
  if (const LookupModeInfo* lookup = find_lookup_mode(plan.mode)) {
    lookup_modes[plan.mode]->bind();
    targets->counters.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, targets->counters.get());
    glBindImageTexture(0, t.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(1, t.marks.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8UI);
    dispatch_tiles(programs.get({lookup->shader, "", {{"REFLECTED", "1"}}}), t.tiles, kLookupLanes);
  } else {
    int panes = 0;  // rays of glossy surfaces name their material
    for (std::size_t k = 0; kind != RayKind::glossy && k < reflectors.size(); ++k)
      panes |= reflectors[k].mirror ? 0 : 1 << k;
    // Of whole blocks of mark.comp.
    const int rows = std::min(targets->band_rows, targets->item_capacity / (4 * kMostReflectedItems * t.width) * 4);
    for (int row = 0; row < t.height; row += rows)
      shade_reflected_rows(plan, row, std::min(rows, t.height - row), panes);
  }
  timer->end("reflected shade");
}

void Renderer::Impl::shade_reflected_rows(const FramePlan& plan, int first_row, int rows, int panes) {
  const FrameTargets& t = *targets;
  const ReflectionTargets& r = *reflection;
  for (GLuint k = 0; k < 2; ++k) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2 + 2 * k, t.items[k].get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3 + 2 * k, t.points[k].get());
  }
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, t.counters.get());
  targets->counters.clear_to_zero();
  const Program& mark = programs.get(reflected_mark_variant());
  glProgramUniform2i(mark.get(), mark.location("u_band"), first_row, rows);
  mark.set("u_item_capacity", t.item_capacity);
  mark.set("u_sample_scale", 1.0f);
  mark.set("u_frames", accumulated);
  mark.set("u_panes", panes);
  glBindImageTexture(0, r.marks.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8UI);
  dispatch_list(mark, groups(r.width, 4) * groups(rows, 4));
  unsigned counters[16];
  t.counters.read(0, sizeof counters, counters);
  dispatch(programs.get({"shading/arguments.comp", "", {}}), 1, 1);
  glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, t.counters.get());
  const Program& gather = programs.get(gather_variant(false, false));
  glBindImageTexture(0, r.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  shade_lists(plan, counters, reflected_shade_variant, gather);
}

void Renderer::Impl::reflect(const FramePlan& plan, const FrameRequest& request, PassTimer* timer) {
  const int divisor = reflection_divisor(request.settings);
  if (!skips) probes.reset();
  if (request.settings.get_bool("reflections.ghost")) {
    std::swap(reflection, ghost);
    reflect_at(divisor, RayKind::ghost, plan, request, timer);
    std::swap(reflection, ghost);
  } else {
    ghost.reset();
  }
  reflect_at(divisor, skips ? RayKind::some : RayKind::all, plan, request, timer);
  if (!reflections_kept) traced = std::exchange(tracing, std::nullopt);
  bind_frame();
  glBindTextureUnit(0, targets->triangle.get());
  glBindTextureUnit(50, reflection->ray_direction.get());
  glBindTextureUnit(53, reflection->radiance.get());
  glBindTextureUnit(56, reflection->doubt.get());
  glBindTextureUnit(62, ghost ? ghost->ray_direction.get() : 0);
  glBindTextureUnit(63, ghost ? ghost->radiance.get() : 0);
}

void Renderer::Impl::bind_ghost(const Program& rays, const Settings& settings) {
  std::array<glm::vec2, kMaxReflectors> optics{};
  for (std::size_t k = 0; k < reflectors.size(); ++k)
    optics[k] = {
        std::max(material_of_item(reflectors[k].item).ior, 1.0f),
        reflectors[k].mirror ? 0.0f : 1e-3f * static_cast<float>(settings.get_double("reflections.thickness"))};
  glProgramUniform2fv(rays.get(), rays.location("u_ghost_optics"), static_cast<GLsizei>(kMaxReflectors), &optics[0].x);
  glProgramUniform1f(rays.get(), rays.location("u_wedge"),
                     1e-3f * static_cast<float>(settings.get_double("reflections.wedge")));
  if (!ghost_reach) ghost_reach = Buffer("reach of ghosts", kMaxReflectors * sizeof(GhostReach));
  ghost_reach.clear_to_zero();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 8, ghost_reach.get());
}

void Renderer::Impl::cast_rays(RayKind kind, const FrameRequest& request, PassTimer* timer) {
  ReflectionTargets& t = *reflection;
  draw_panes(&t);
  const float no_ray[4] = {};
  glClearTexImage(t.ray_direction.get(), 0, GL_RGBA, GL_FLOAT, no_ray);
  glBindTextureUnit(51, t.pane.get());
  glBindTextureUnit(52, targets->depth.get());
  glBindImageTexture(0, t.ray_origin.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(1, t.ray_direction.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(2, t.focus.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R16F);
  const GLubyte no_doubt = 0;
  glClearTexImage(t.doubt.get(), 0, GL_RED_INTEGER, GL_UNSIGNED_BYTE, &no_doubt);
  const bool fitted = any_fitted();
  const Program& rays = programs.get(rays_variant(kind == RayKind::ghost, fitted));
  if (kind == RayKind::ghost) bind_ghost(rays, request.settings);
  if (fitted) {
    if (!fit_reach) fit_reach = Buffer("reach of fits", kMaxPatches * sizeof(FitReach));
    fit_reach.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 12, fit_reach.get());
    glBindTextureUnit(54, fit_triangle_view.get());
  }
  rays.set("u_divisor", t.divisor);
  list_tiles(&t, false);
  dispatch_tiles(rays, t.tiles, kTileLanes);
  timer->end("panes");
}

void Renderer::Impl::drop_unseen_rays(const FramePlan& plan, const FrameRequest& request, PassTimer* timer) {
  fit_targets(reflection->divisor * kProbeSpacing, &probes);
  glBindTextureUnit(49, reflection->ray_origin.get());
  glBindTextureUnit(50, reflection->ray_direction.get());
  std::swap(reflection, probes);
  set_reflection_constants(request);
  const ReflectionTargets& few = *reflection;
  glBindImageTexture(0, few.ray_origin.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(1, few.ray_direction.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const Program& pick = programs.get({"reflections/probes.comp", "", {}});
  pick.set("u_spacing", kProbeSpacing);
  dispatch(pick, groups(few.width, 8), groups(few.height, 8));
  follow_rays(RayKind::all, plan, request, timer);
  std::swap(reflection, probes);
  draw_cover();
  set_reflection_constants(request);
  const ReflectionTargets& t = *reflection;
  const Program& skip = programs.get({"reflections/skip.comp", "", {}});
  bind_skipping(skip, static_cast<float>(request.settings.get_double("reflections.skip")));
  skip.set("u_divisor", t.divisor);
  skip.set("u_spacing", kProbeSpacing);
  glBindTextureUnit(51, t.pane.get());
  glBindImageTexture(0, t.ray_origin.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(1, t.ray_direction.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  dispatch_tiles(skip, t.tiles, kTileLanes);
  timer->end("skip");
}

void Renderer::Impl::list_tiles(ReflectionTargets* t, bool rays) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, targets->tile_counts.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, t->tiles.tiles.get());
  targets->tile_counts.clear_to_zero();
  dispatch_list(programs.get(list_tiles_variant(rays)),
                groups(t->width, FrameTargets::kTile) * groups(t->height, FrameTargets::kTile));
  unsigned count = 0;
  targets->tile_counts.read(0, sizeof count, &count);
  t->tiles.counts.assign(1, static_cast<int>(count));
}

void Renderer::Impl::fit_targets(int divisor, std::optional<ReflectionTargets>* reflected) const {
  const int width = targets->grid_width(), height = targets->grid_height();
  if (!*reflected || (*reflected)->divisor != divisor || (*reflected)->width != groups(width, divisor) ||
      (*reflected)->height != groups(height, divisor))
    reflected->emplace(make_reflection_targets(width, height, divisor));
}

void Renderer::Impl::set_reflection_constants(const FrameRequest& request) {
  const ReflectionTargets& t = *reflection;
  FrameConstants& small = reflection_constants;
  small = constants;
  small.size = glm::ivec4(t.width, t.height, 1, 0);
  small.forward.w = constants.forward.w * static_cast<float>(t.divisor);
  const int samples = request.settings.get_int("reflections.samples");
  small.sampling = glm::ivec4(samples, std::max(samples / kMostReflectedItems, 2), accumulated * samples,
                              constants.sampling.w ^ 0x5bd1e995);
  if (!reflection_block) reflection_block = Buffer("reflection constants", sizeof(FrameConstants));
  reflection_block.update(0, sizeof small, &small);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, reflection_block.get());
  glBindBufferBase(GL_UNIFORM_BUFFER, 1, reflector_block.get());
}

void Renderer::Impl::reflect_at(int divisor, RayKind kind, const FramePlan& plan, const FrameRequest& request,
                                PassTimer* timer) {
  fit_targets(divisor, &reflection);
  set_reflection_constants(request);
  if (!reflections_kept && kind != RayKind::glossy) {
    cast_rays(kind, request, timer);
    if (kind == RayKind::some) drop_unseen_rays(plan, request, timer);
  }
  follow_rays(kind, plan, request, timer);
}

void Renderer::Impl::follow_rays(RayKind kind, const FramePlan& plan, const FrameRequest& request, PassTimer* timer) {
  ReflectionTargets& t = *reflection;
  const bool is_glossy = kind == RayKind::glossy, kept = is_glossy ? glossy_kept : reflections_kept;
  const int samples = request.settings.get_int("reflections.samples");
  glBindTextureUnit(49, t.ray_origin.get());
  glBindTextureUnit(50, t.ray_direction.get());
  std::vector<bool> occluding = transmitting_items();
  occluding.flip();
  std::unique_ptr<ReflectorTechnique>& technique =
      is_glossy ? glossy_technique : reflector_techniques[plan.reflections];
  if (!technique)
    technique = is_glossy ? make_glossy_reflections() : find_reflector_implementation(plan.reflections).make();
  std::vector<GhostReach> reach(kMaxReflectors);
  if (kind == RayKind::ghost) ghost_reach.read(0, ghost_reach.bytes(), reach.data());
  std::vector<FitReach> fits(kMaxPatches);
  const bool fitted = any_fitted();
  if (fitted && !reflections_kept) fit_reach.read(0, fit_reach.bytes(), fits.data());
  const ReflectionFrame frame{&reflection_constants,
                              &*buffers,
                              &reflectors,
                              &occluding,
                              geometry_epoch,
                              octree.ready() ? &octree.buffers() : nullptr,
                              octree.cells(),
                              kind == RayKind::ghost ? &reach : nullptr,
                              fitted ? &fits : nullptr,
                              &request.settings,
                              &t,
                              &programs,
                              timer,
                              [&](const Program& program) { dispatch_tiles(program, t.tiles, kTileLanes); }};
  if (!kept) {
    list_tiles(&t, true);
    const float none = 0.0f;
    glClearTexImage(t.depth.get(), 0, GL_RED, GL_FLOAT, &none);
    technique->trace(frame);
  }
  if (!kept && !technique->resolves()) {
    glBindTextureUnit(0, t.triangle.get());
    glBindImageTexture(0, t.surface.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
    glBindImageTexture(1, t.depth.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glBindImageTexture(3, t.guide.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32UI);
    dispatch_tiles(programs.get(reflected_resolve_variant(buffers->has_textures(), buffers->has_colors())), t.tiles,
                   kTileLanes);
    timer->end("reflected gbuffer");
  }
  glBindTextureUnit(0, t.triangle.get());
  glBindTextureUnit(8, t.surface.get());
  glBindTextureUnit(9, t.depth.get());
  shade_reflections(plan, kind, timer);
  glBindImageTexture(0, t.radiance.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  if (plan.indirect == "baked") {
    const Program& program = programs.get(reflected_indirect_variant(facts.measured_count > 0));
    bind_indirect(program, indirect.blend() > 0.5f ? indirect.keys().back() : indirect.keys().front());
    dispatch_tiles(program, t.tiles, kTileLanes);
  }
  const bool layers = technique->shade_layers(frame, plan.visibility == "traced",
                                              find_lookup_mode(plan.mode) ? kLookupLayerSamples : samples);
  const Program& complete = programs.get(reflected_compose_variant(layers, is_glossy));
  if (is_glossy) {
    complete.set("u_blend", 1.0f / static_cast<float>(glossy_frames));
    glBindImageTexture(1, t.mean.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  }
  dispatch_tiles(complete, t.tiles, kTileLanes);
  timer->end("reflected shade");
}

}  // namespace maquette
