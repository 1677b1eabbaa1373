#include "render/reflections/reflections.h"

#include <algorithm>
#include <array>

#include "render/bake/scene_bakes.h"
#include "render/frame/constants.h"
#include "render/gl/bindings.h"
#include "render/gl/raster_state.h"
#include "render/math/shared_formulas.h"
#include "render/views/read_texture.h"
#include "scenes/error.h"

namespace maquette {

namespace {

/// A probe for so many points each way decides whether they are followed.
constexpr int kProbeSpacing = 4;
/// So much of a pixel of the reflected picture a pane's outline may be off. What it mirrors is found on the true patch.
constexpr float kPaneTolerance_px = 0.1f;

const ShaderVariant kPane{"reflections/pane.frag", "reflections/pane.vert", {}},
    kProbes{"reflections/probes.comp", "", {}};

int divisor_of(const FrameContext& frame) { return reflection_divisor(frame.request.settings, frame.accumulated > 0); }

ShaderVariant rays_variant(bool ghost, bool fitted) {
  return {"reflections/rays.comp", "", {{"GHOST", flag(ghost)}, {"FITTED", flag(fitted)}}};
}

}  // namespace

std::vector<ShaderVariant> Reflections::shader_variants() {
  std::vector<ShaderVariant> variants{kPane, kProbes};
  for (int k = 0; k < 4; ++k) variants.push_back(rays_variant(k & 1, k & 2));
  for (const auto& more : {MirroredRays::shader_variants(), Skipping::shader_variants()})
    variants.insert(variants.end(), more.begin(), more.end());
  return variants;
}

void Reflections::report(const FrameRequest& request, const Technique& technique, const SceneState& scene,
                         const ReflectorSet& reflectors, bool traced, FrameStatus* status) {
  status->follows_all_rays = Skipping::why_all(request, technique, reflectors, traced);
  if (status->follows_all_rays.empty() && scene.facts().has_blended)
    status->follows_all_rays = "what blended surfaces add has no bound";
  if (!status->follows_all_rays.empty())
    skipping_.clear();
  else if (!skipping_.update_geometry(scene, reflectors))
    status->follows_all_rays = "geometry changes from frame to frame";
  skips_ = status->follows_all_rays.empty();
}

Pass Reflections::pass(const MirroredScene& scene, const Technique& technique, bool averages_points,
                       std::function<Key()> surfaces, std::function<const Texture&()> behind) {
  const FrameContext& frame = scene.frame;
  if (technique_name_ != technique.name) {
    technique_ = technique.make_reflector();
    technique_name_ = technique.name;
    traced_.reset();
  }
  Pass pass;
  for (const PlannedPass& planned : frame.plan.passes) {
    const bool own = std::any_of(planned.writes.begin(), planned.writes.end(), [](const std::string& resource) {
      return resource == "rays" || resource == "hits" || resource == "reflections";
    });
    if (own) pass.names.push_back(planned.name);
  }
  // What is skipped depends on the light.
  const bool may_keep = technique.can.keeps_hits && !skips_ && frame.request.settings.get_bool("shading.reuse");
  pass.run = [=, this, &scene, names = pass.names] {
    const FrameContext& context = scene.frame;
    const Key now = Key::of(surfaces(), context.scene.revisions().all(), context.bakes.all(), technique_name_,
                            context.request.reflectors, context.request.settings, divisor_of(context));
    const int varies = technique.can.is_exact && !skips_ ? context.accumulated : 0;
    const bool same = rays_.has_images() && traced_ == now, kept = may_keep && same && varies == 0;
    traced_.reset();
    run({scene, behind(), averages_points && !skips_ && context.accumulated > 0, same, kept, varies});
    if (!skips_) traced_ = now;
    if (!kept) return;
    for (const std::string& name : names)
      context.frame.skip(name, "kept from the frame before: neither camera nor surfaces changed");
  };
  return pass;
}

void Reflections::run(const Frame& frame) {
  const MirroredScene& scene = frame.scene;
  const int divisor = divisor_of(scene.frame);
  const GridSize& grid = scene.frame.size();
  if (!skips_) probes_.clear();
  if (scene.frame.request.settings.get_bool("reflections.ghost")) {
    ghost_.fit(grid, divisor);
    ghost_.bind_constants(scene);
    if (!frame.kept) cast_rays(frame, &ghost_, true);
    follow(frame, &ghost_, true);
  } else {
    ghost_.clear();
  }
  rays_.fit(grid, divisor);
  rays_.bind_constants(scene);
  if (!frame.kept) {
    cast_rays(frame, &rays_, false);
    if (skips_) drop_unseen_rays(frame);
  }
  follow(frame, &rays_, false);
}

void Reflections::draw_panes(const Frame& frame, const ReflectionTargets& t) {
  const FrameContext& context = frame.scene.frame;
  const SceneState& scene = context.scene;
  ReflectorSet& reflectors = frame.scene.reflectors;
  reflectors.update_coarse_patches(scene);
  begin_triangles(t.pane_framebuffer.get(), t.width, t.height);
  glBindVertexArray(scene.buffers().vertex_array());
  const Program& program = context.programs.get(kPane);
  glUseProgram(program.get());
  const CoarsePatches& patches = reflectors.coarse_patches();
  for (std::size_t k = 0; k < reflectors.all().size(); ++k) {
    const std::size_t i = reflectors.all()[k].item;
    if (!scene.buffers().visible(i) || !may_be_seen(context.constants.clip_from_world, scene.buffers().bounds(i)))
      continue;
    scene.shows_both_sides(i) ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
    program.set("u_first_triangle", static_cast<int>(scene.geometry().items[i].first_index / 3));
    program.set("u_reflector", static_cast<int>(k));
    const auto patch = patches.of_item.find(i);
    // Seen by parallel rays the tolerance is a length, and the patch's own triangles always hold it.
    const CoarsePatch::Level* level =
        patch == patches.of_item.end() || context.constants.eye.w == 0.0f
            ? nullptr
            : coarsest_level(patch->second, glm::vec3(context.constants.eye),
                             kPaneTolerance_px * context.constants.forward.w * static_cast<float>(t.divisor));
    const PatchSides sides = level ? patch->second.sides : PatchSides{0, 0};
    glUniform2i(program.location("u_quads"), sides.u, sides.v);
    reflectors.draw_level(scene, i, level);
  }
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  end_triangles();
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void Reflections::set_variation(const Frame& frame, const Program& rays) {
  const std::vector<Reflector>& reflectors = frame.scene.reflectors.all();
  std::array<float, kMaxReflectors> alpha{};
  for (std::size_t k = 0; k < reflectors.size(); ++k) {
    const float roughness = frame.scene.frame.scene.material_of_item(reflectors[k].item).roughness;
    if (reflectors[k].mirror) alpha[k] = std::max(roughness * roughness, shared::kMinAlpha);
  }
  rays.set("u_frame_at_rest", frame.varies);
  glProgramUniform1fv(rays.get(), rays.location("u_alpha"), static_cast<GLsizei>(kMaxReflectors), alpha.data());
}

void Reflections::bind_ghost(const Frame& frame, const Program& rays) {
  const SceneState& scene = frame.scene.frame.scene;
  const Settings& settings = frame.scene.frame.request.settings;
  const std::vector<Reflector>& reflectors = frame.scene.reflectors.all();
  std::array<glm::vec2, kMaxReflectors> optics{};
  for (std::size_t k = 0; k < reflectors.size(); ++k)
    optics[k] = {
        std::max(scene.material_of_item(reflectors[k].item).ior, 1.0f),
        reflectors[k].mirror ? 0.0f : 1e-3f * static_cast<float>(settings.get_double("reflections.thickness"))};
  glProgramUniform2fv(rays.get(), rays.location("u_ghost_optics"), static_cast<GLsizei>(kMaxReflectors), &optics[0].x);
  glProgramUniform1f(rays.get(), rays.location("u_wedge"),
                     1e-3f * static_cast<float>(settings.get_double("reflections.wedge")));
  if (!ghost_reach_) ghost_reach_ = Buffer("reach of ghosts", kMaxReflectors * sizeof(GhostDeviation));
  ghost_reach_.clear_to_zero();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferGhostReach, ghost_reach_.get());
}

void Reflections::cast_rays(const Frame& frame, MirroredRays* image, bool ghost) {
  const ReflectionTargets& t = image->targets();
  draw_panes(frame, t);
  const float no_ray[4] = {};
  glClearTexImage(t.ray_direction.get(), 0, GL_RGBA, GL_FLOAT, no_ray);
  glBindTextureUnit(kUnitPane, t.pane.get());
  glBindTextureUnit(kUnitOpaqueDepth, frame.scene.depth.get());
  glBindImageTexture(kImageRayOrigin, t.ray_origin.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageRayDirection, t.ray_direction.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageFocus, t.focus.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R16F);
  const GLubyte certain = 0;
  glClearTexImage(t.low_confidence.get(), 0, GL_RED_INTEGER, GL_UNSIGNED_BYTE, &certain);
  const bool fitted = frame.scene.reflectors.any_fitted();
  ProgramCache& programs = frame.scene.frame.programs;
  const Program& rays = programs.get(rays_variant(ghost, fitted));
  if (ghost) bind_ghost(frame, rays);
  if (fitted) {
    if (!fit_reach_) fit_reach_ = Buffer("reach of fits", kMaxPatches * sizeof(FitDeviation));
    fit_reach_.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferFitReach, fit_reach_.get());
    glBindTextureUnit(kUnitPatchFits, frame.scene.reflectors.fit_triangles().get());
  }
  rays.set("u_divisor", t.divisor);
  set_variation(frame, rays);
  image->list_tiles(&programs, false);
  dispatch_tiles(rays, t.tiles, kPerPoint);
  frame.scene.frame.timer().end("panes");
}

void Reflections::drop_unseen_rays(const Frame& frame) {
  const MirroredScene& scene = frame.scene;
  ProgramCache& programs = scene.frame.programs;
  skipping_.update_light(scene.frame, scene.layers.front().context.plan.visibility != "none");
  probes_.fit(scene.frame.size(), rays_.targets().divisor * kProbeSpacing);
  glBindTextureUnit(kUnitRayOrigin, rays_.targets().ray_origin.get());
  glBindTextureUnit(kUnitRayDirection, rays_.targets().ray_direction.get());
  probes_.bind_constants(scene);
  const ReflectionTargets& few = probes_.targets();
  glBindImageTexture(kImageRayOrigin, few.ray_origin.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageRayDirection, few.ray_direction.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const Program& pick = programs.get(kProbes);
  pick.set("u_spacing", kProbeSpacing);
  dispatch(pick, group_count(few.width, 8), group_count(few.height, 8));
  follow(frame, &probes_, false);
  skipping_.draw_cover(scene, rays_.targets());
  rays_.bind_constants(scene);
  skipping_.mark(scene, rays_.targets(), few, kProbeSpacing, frame.behind);
  scene.frame.timer().end("skip");
}

void Reflections::follow(const Frame& frame, MirroredRays* image, bool ghost) {
  std::vector<GhostDeviation> reach(kMaxReflectors);
  if (ghost && !frame.kept) ghost_reach_.read(0, ghost_reach_.bytes(), reach.data());
  std::vector<FitDeviation> fits(kMaxPatches);
  const bool fitted = frame.scene.reflectors.any_fitted();
  if (fitted && !frame.kept) fit_reach_.read(0, fit_reach_.bytes(), fits.data());
  image->follow(frame.scene, {.technique = *technique_,
                              .keeps_hits = frame.kept,
                              .shadow_rays = frame.scene.frame.accumulated > 0,
                              .averages = frame.averages,
                              .continues = frame.continues,
                              .ghost = ghost ? &reach : nullptr,
                              .fits = fitted ? &fits : nullptr});
}

ReflectedPicture Reflections::bind(const Settings& settings) {
  const ReflectionTargets& t = rays_.targets();
  glBindTextureUnit(kUnitRayDirection, t.ray_direction.get());
  glBindTextureUnit(kUnitReflection, t.radiance.get());
  glBindTextureUnit(kUnitLowConfidence, t.low_confidence.get());
  const bool ghost = ghost_.has_images();
  glBindTextureUnit(kUnitGhostDirection, ghost ? ghost_.targets().ray_direction.get() : 0);
  glBindTextureUnit(kUnitGhost, ghost ? ghost_.targets().radiance.get() : 0);
  return {true, ghost, technique_->marks_low_confidence() && settings.get_string("reflections.mark") == "hatch"};
}

void Reflections::add_bytes(const ReflectorSet& reflectors, std::map<std::string, std::size_t>* bytes) const {
  (*bytes)["reflections"] = rays_.bytes() + reflectors.bytes() + (skips_ ? skipping_.bytes() : 0);
  technique_->add_bytes(bytes);
}

void Reflections::add_counters(const ReflectorSet& reflectors, std::map<std::string, double>* counters) const {
  technique_->add_counters(counters);
  for (const Reflector& reflector : reflectors.all()) {
    if (!reflector.fit) continue;
    (*counters)["fitted_patches"] += static_cast<double>(reflector.fit->patches.size());
    double& error_mm = (*counters)["fit_error_mm"];
    error_mm = std::max(error_mm, 1e3 * reflector.fit->largest_m);
  }
  if (skips_) skipping_.add_counters(counters);
}

std::vector<DebugViewInfo> Reflections::views() {
  return {{"reflection", "", ViewColors::radiance},
          {"ghost", "", ViewColors::radiance},
          {"reflection_distance"},
          {"reflection_steps"},
          {"reflection_root"},
          {"reflection_doubt"},
          {"rays_skipped"}};
}

/// The picture (`channel` < 0), a channel of ReflectionTargets::effort, or 2: where confidence is low.
Image Reflections::read_picture(const MirroredRays& rays, int channel) const {
  const ReflectionTargets& r = rays.targets();
  const auto radiance = read_texture<float>(r.radiance, GL_RGBA, GL_FLOAT, 4);
  const auto direction = read_texture<float>(r.ray_direction, GL_RGBA, GL_FLOAT, 4);
  const auto effort = read_texture<std::uint8_t>(r.effort, GL_RG_INTEGER, GL_UNSIGNED_BYTE, 2);
  const auto low_confidence = read_texture<std::uint8_t>(r.low_confidence, GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1);
  Image image(r.width, r.height, 4);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    if (direction[i / 4 * 4 + 3] == 0.0f) continue;  // where no reflector is seen nothing is written
    const float value = channel < 0   ? radiance[i]
                        : channel > 1 ? static_cast<float>(low_confidence[i / 4])
                                      : static_cast<float>(effort[i / 4 * 2 + static_cast<std::size_t>(channel)]);
    image.data[i] = i % 4 == 3 ? 1.0f : value;
  }
  return image;
}

std::optional<Image> Reflections::view(const std::string& name, bool drawn, const FrameConstants& frame) const {
  const std::vector<DebugViewInfo> known = views();
  if (std::none_of(known.begin(), known.end(), [&](const DebugViewInfo& v) { return v.name == name; }))
    return std::nullopt;
  if (name == "ghost" && (!drawn || !ghost_.has_images()))
    throw Error("--view", "there is no second image", "add --set reflections.ghost=true");
  if (!drawn)
    throw Error("--view", "reflections are seen with a reflector in view and a technique",
                "add --reflections with the name of one");
  if (name == "ghost") return read_picture(ghost_, -1);
  const int channel = name == "reflection_steps"   ? 0
                      : name == "reflection_root"  ? 1
                      : name == "reflection_doubt" ? 2
                                                   : -1;
  Image image = read_picture(rays_, channel);
  const ReflectionTargets& r = rays_.targets();
  const auto direction = read_texture<float>(r.ray_direction, GL_RGBA, GL_FLOAT, 4);
  if (name == "rays_skipped")
    for (std::size_t i = 0; i < image.data.size(); ++i)
      if (i % 4 != 3) image.data[i] = direction[i / 4 * 4 + 3] < 0.0f ? 1.0f : 0.0f;
  if (name != "reflection_distance") return image;
  const auto origin = read_texture<float>(r.ray_origin, GL_RGBA, GL_FLOAT, 4);
  const auto along_m = read_texture<float>(r.depth, GL_RED, GL_FLOAT, 1);
  for (std::size_t i = 0; i < along_m.size(); ++i) {
    const glm::vec3 to = from_eye(frame, {origin[4 * i], origin[4 * i + 1], origin[4 * i + 2]});
    const bool hits = image.data[4 * i + 3] > 0.0f && along_m[i] > 0.0f;
    for (std::size_t c = 0; c < 3; ++c) image.data[4 * i + c] = hits ? glm::length(to) + along_m[i] : 0.0f;
  }
  return image;
}

}  // namespace maquette
