#include "render/renderer.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <utility>

#include "render/bezier/patch_fit.h"
#include "render/material_overrides.h"
#include "render/renderer_impl.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

Renderer::Renderer() : impl_(std::make_unique<Impl>()) {}
Renderer::~Renderer() = default;

const Scene& Renderer::scene() const {
  impl_->require_ready();
  return *impl_->scene;
}
const SceneFacts& Renderer::facts() const { return impl_->facts; }

void Renderer::Impl::require_ready() const {
  if (!scene || !buffers) throw Error("renderer", "no scene has been set");
}

void Renderer::set_scene(std::shared_ptr<const Scene> scene) {
  SceneBuffers buffers(*scene);
  impl_->scene = std::move(scene);
  impl_->buffers.emplace(std::move(buffers));
  impl_->facts_variant = -2;
  impl_->buffers_variant = -1;
  impl_->lights_stale = true;
  impl_->visibility.clear();
  impl_->indirect.clear();
  ++impl_->bounce_epoch;
  impl_->octree.clear();
  ++impl_->geometry_epoch;
  ++impl_->surface_epoch;
  impl_->overrides.clear();
  impl_->effective = impl_->scene->materials;
  impl_->upload_materials();
  ++impl_->epoch;
}

void Renderer::set_environment(std::shared_ptr<const Environment> environment) {
  impl_->environment.emplace(std::move(environment));
  impl_->irradiance = Texture();
  impl_->drawn_sky.reset();
  impl_->lookup_modes.clear();
  if (impl_->buffers) impl_->upload_materials();
  ++impl_->epoch;
}

void Renderer::set_material(const std::string& material_name, const std::string& source) {
  impl_->require_ready();
  std::vector<std::string> names{"*"};
  for (const Material& m : impl_->scene->materials) names.push_back(m.name);
  if (std::find(names.begin(), names.end(), material_name) == names.end())
    throw UsageError("--material", "the scene has no material '" + material_name + "'",
                     did_you_mean(material_name, names));
  std::map<std::string, std::string> sources = impl_->overrides;
  if (material_name == "*") sources.clear();
  if (source.empty())
    sources.erase(material_name);
  else
    sources[material_name] = source;
  if (!source.empty() && source != "builtin:glass") impl_->materials.slot_of(source);  // throws before anything changes
  impl_->overrides = std::move(sources);
  impl_->effective = override_materials(impl_->scene->materials, impl_->overrides);
  const std::uint32_t surfaces = impl_->surface_epoch;
  impl_->upload_materials();
  ++impl_->bounce_epoch;
  if (impl_->surface_epoch != surfaces) {
    impl_->facts_variant = -2;
    impl_->lights_stale = true;
  } else {
    impl_->recount_tables();
    ++impl_->paint_news;
  }
  ++impl_->epoch;
}

void Renderer::Impl::upload_materials() {
  repainted.resize(effective.size() + 1, false);
  const std::vector<int> before = std::exchange(slots, {});
  std::vector<float> shares, limits;
  const float environment_sr = environment ? environment->effective_sr() : 12.566f;
  for (const Material& m : effective) {
    const int slot = m.measured.empty() ? -1 : materials.slot_of(m.measured);
    slots.push_back(slot);
    limits.push_back(slot < 0 ? 0.0f : materials.bandwidth_limit(slot));
    if (slot >= 0) {
      shares.push_back(materials.brdf_share(slot, environment_sr));
    } else {
      const float gloss = std::clamp(1.0f - m.roughness, 0.0f, 1.0f);
      shares.push_back(std::clamp(0.375f + 0.375f * gloss * std::max(m.metallic, m.clearcoat), 0.25f, 0.875f));
    }
  }
  slots.push_back(-1);
  shares.push_back(0.5f);
  limits.push_back(0.0f);
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (i >= before.size() || slots[i] != before[i]) repainted[i] = true;
  if (buffers->update_materials(effective, slots, shares, limits, repainted)) ++surface_epoch;
}

void Renderer::update_mesh(int mesh, const std::vector<glm::vec3>& positions, const std::vector<glm::vec3>& normals) {
  impl_->require_ready();
  impl_->buffers->update_mesh(*impl_->scene, mesh, positions, normals);
  for (std::size_t i = 0; i < impl_->buffers->geometry().items.size(); ++i) {
    const bool shines = impl_->material_of_item(i).emissive != glm::vec3(0.0f);
    impl_->lights_stale |= shines && impl_->buffers->geometry().items[i].mesh == mesh;
  }
  ++impl_->geometry_epoch;
  ++impl_->surface_epoch;
  ++impl_->bounce_epoch;
  ++impl_->epoch;
}

void Renderer::set_interactive(bool interactive) {
  impl_->interactive = interactive;
  impl_->indirect.set_prepares(interactive);
  impl_->reference = ReferenceFrame();
}

void Renderer::set_node_visible(int node, bool visible) {
  impl_->require_ready();
  impl_->buffers->set_node_visible(node, visible);
  ++impl_->surface_epoch;
  ++impl_->bounce_epoch;
  impl_->lights_stale = true;
  ++impl_->epoch;
}

namespace {

int default_samples(const FrameRequest& request) {
  if (request.samples > 0) return request.samples;
  if (request.mode == "uniform") return request.settings.get_int("uniform.samples");
  if (request.mode == "bandwidth") return request.settings.get_int("bandwidth.samples");
  return 1;
}

/// Work item size: one item a point in uniform; in bandwidth a quarter of the samples, but no less than 64 while there
/// are so many: an item costs as much to begin as 5 to 10 samples. Error squared times time at 64 samples is 5 to 20 %
/// less with items of 64 than of 16 in six scenes of seven.
int choose_chunk(const FrameRequest& request, int samples) {
  if (request.mode != "bandwidth") return std::max(samples, 2);
  constexpr int kLeast = 4, kEnough = 64;
  const int per_point = std::max(samples / std::max(request.msaa, 1), kLeast);
  const auto power_of_two = [](int n) { return static_cast<int>(std::bit_ceil(static_cast<unsigned>(n))); };
  return std::clamp(power_of_two(per_point / 4), std::min(power_of_two(per_point), kEnough), 4096);
}

}  // namespace

CameraFrame Renderer::Impl::camera_frame(const FrameRequest& request) const {
  Bounds bounds;
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) {
    bounds.min = glm::min(bounds.min, buffers->bounds(i).min);
    bounds.max = glm::max(bounds.max, buffers->bounds(i).max);
  }
  return make_camera_frame(request.camera, request.width, request.height, bounds);
}

void Renderer::Impl::prepare_constants(const FrameRequest& request, const FramePlan& plan,
                                       std::optional<float> passing_density, int samples, int chunk) {
  const CameraFrame camera = camera_frame(request);
  FrameConstants& c = constants;
  c.clip_from_world = clip_from_world(camera);
  c.eye = glm::vec4(camera.eye, 0.0f);
  const int side = targets->side;
  c.forward = glm::vec4(camera.forward, 2.0f * camera.tan_y / static_cast<float>(request.height * side));
  c.right = glm::vec4(camera.right * camera.tan_x, 0.0f);
  c.up = glm::vec4(camera.up * camera.tan_y, 0.0f);
  c.environment = glm::vec4(std::cos(request.env_rotation_rad), std::sin(request.env_rotation_rad), request.env_scale,
                            static_cast<float>(environment->tables().luminance_integral));
  c.size = glm::ivec4(
      targets->grid_width(), targets->grid_height(), side,
      plan.mode == "bandwidth" ? request.settings.get_int("bandwidth.max_level") + (side == 4 ? 2 : side / 2) : 0);
  // In mode bandwidth each point counts its own samples.
  const int first_sample = plan.mode == "bandwidth" ? 0 : accumulated * samples;
  if (passing_density) samples = std::max(static_cast<int>(kTurningSamples * static_cast<float>(samples)), 1);
  c.sampling = glm::ivec4(samples, chunk, first_sample, static_cast<int>(request.seed));
  c.environment_size = glm::ivec4(environment->environment().width, environment->environment().height,
                                  environment->bias(), EnvironmentBuffers::kListLength);
  const PackedSky& sky = environment->sky();
  c.sky_nodes = glm::ivec4(sky.columns, sky.spans, sky.last_row, sky.offset > 0.0f ? 1 : 0);
  c.bandwidth_size = glm::ivec4(environment->tables().bandwidth_width, environment->tables().bandwidth_height,
                                lights ? lights->count() : 0, 0);
  // Interpolation's error falls with the square of the spacing, and noise with the 0.8th power of the samples (docs/
  // numerics.md): so they fall together. Once there is a picture, what was measured decides instead.
  const float quality = static_cast<float>(request.settings.get_double("bandwidth.quality")) *
                        std::pow(static_cast<float>(samples) / 64.0f, 0.4f) * passing_density.value_or(1.0f);
  c.quality = glm::vec4(quality, 1.0f, plan.texture_bandwidth ? 1.0f : 0.0f, environment->sun_luminance());
  frame_block.update(0, sizeof(c), &c);
}

void Renderer::Impl::bind_frame() const {
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame_block.get());
  buffers->bind_materials();
  environment->bind();
  if (materials.count() > 0) materials.bind();
  if (lights) lights->bind();
  if (visibility.ready()) visibility.bind();
  buffers->bind_geometry();
  glBindTextureUnit(0, targets->triangle.get());
  if (octree.ready()) octree.buffers().bind();
  glBindTextureUnit(8, targets->surface.get());
  glBindTextureUnit(9, targets->depth.get());
  glBindTextureUnit(26, targets->guide.get());
}

void Renderer::Impl::settle_slots() {
  if (!device.software) return;
  if (!slot_texture) {
    const float zero = 0.0f;
    slot_texture = Texture::make_2d("slots", GL_R32F, 1, 1);
    slot_texture.upload(0, 1, 1, GL_RED, GL_FLOAT, &zero);
  }
  glBindTextureUnit(0, slot_texture.get());
  glBindImageTexture(0, slot_texture.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  dispatch(programs.get({"shading/slots.comp", "", {}}), 1, 1);
}

void Renderer::Impl::dispatch(const Program& program, int x, int y) {
  glUseProgram(program.get());
  glDispatchCompute(static_cast<GLuint>(x), static_cast<GLuint>(y), 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void Renderer::Impl::dispatch_list(const Program& program, int count) {
  constexpr int kGroupsPerRow = 32768;
  const int groups = (count + 63) / 64;
  dispatch(program, std::min(groups, kGroupsPerRow), (groups + kGroupsPerRow - 1) / kGroupsPerRow);
}

void Renderer::Impl::dispatch_tiles(const Program& program, const TileList& list, int shift,
                                    std::optional<std::size_t> band, TileShare share) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, list.tiles.get());
  const std::size_t first = band.value_or(0), last = band ? first + 1 : list.counts.size();
  for (std::size_t b = first; b < last; ++b) {
    const int count = (list.counts[b] - share.first + share.step - 1) / share.step;
    if (count <= 0) continue;
    glProgramUniform4i(program.get(), program.location("u_tiles"),
                       static_cast<int>(b) * targets->band_tiles() + share.first, count, share.step, list.dealt);
    dispatch_list(program, count << shift);
  }
}

void Renderer::Impl::prepare_accumulation(const FramePlan& plan, bool accumulate) {
  if (accumulated > 0) return;
  // A list of the seed's own: what all samples of a list have in common is no noise that other seeds tell of.
  if (light_list_seed != last_request.seed) environment->resample(last_request.seed);
  light_list_seed = last_request.seed;
  if (!accumulate || plan.mode != "bandwidth")
    progressive.reset();
  else if (progressive && progressive->levels == constants.size.w)
    progressive->clear();
  else
    progressive = Progressive::make(*targets, constants.size.w);
}

void Renderer::Impl::renew_light_list(std::uint32_t seed) {
  environment->resample(seed * 0x9e3779b9u + static_cast<std::uint32_t>(accumulated));
  light_list_seed.reset();
}

void Renderer::Impl::renew_light_list_for(std::int64_t begin, std::int64_t count, std::uint32_t seed) {
  constexpr std::int64_t kLength = EnvironmentBuffers::kListLength;
  if (begin > 0 && begin / kLength != (begin + count) / kLength) renew_light_list(seed);
}

namespace {

/// What a frame does without because nothing moved since the one before.
void leave_out_known(FramePlan* plan) {
  for (const char* known : {"raster", "gbuffer", "texture_bandwidth", "bandwidth", "pyramid"}) {
    if (std::erase_if(plan->passes, [&](const PlannedPass& pass) { return pass.name == known; }) > 0)
      plan->left_out.push_back({known, "nothing moved: known from the first frame"});
  }
  if (plan->mode == "bandwidth")
    plan->passes.push_back({"measure", "nothing moved: the frames so far say where samples are worth most"});
}

/// What a frame does otherwise because only the light turned.
void note_turn(FramePlan* plan, bool sun) {
  for (PlannedPass& pass : plan->passes) {
    if (pass.name == "bandwidth") pass.reason = "only the light turned: predicted anew for a part of the tiles";
    if (pass.name == "shade")
      pass.reason = std::string("only the light turned: points go on from their past, by what turning changed; ") +
                    (sun ? "the sun is drawn apart, anew at each point" : "the environment has no sun to draw apart");
  }
}

/// What a frame does otherwise because only paint was swapped.
void note_repaint(FramePlan* plan) {
  for (PlannedPass& pass : plan->passes) {
    if (pass.name == "bandwidth") pass.reason = "only paint was swapped: predicted anew where it is seen";
    if (pass.name == "shade") pass.reason = "only paint was swapped: the points of other materials are kept";
  }
}

}  // namespace

bool Renderer::Impl::keeps_points(const FrameRequest& request, const FramePlan& plan, bool accumulate) const {
  // Several points a pixel are filtered in place: nothing of them is left.
  return plan.mode == "bandwidth" && targets->side == 1 && request.settings.get_bool("shading.reuse") &&
         drawn_epoch != epoch && drawn_points == points_epoch() && last_request == request &&
         (!accumulate || progressive);
}

FrameStats Renderer::render(const FrameRequest& request, bool accumulate) {
  Impl& s = *impl_;
  s.require_ready();
  if (!s.environment) throw Error("renderer", "no environment has been set");
  const auto begin = std::chrono::steady_clock::now();
  s.update_facts(request.variant);
  const int side = request.msaa == 16 ? 4 : request.msaa == 4 ? 2 : 1;
  s.update_reflectors(request);
  FramePlan plan = maquette::plan(s.facts, request.mode, request.settings, s.view_info(request));
  if (plan.mode == "reference") return s.render_reference(request, std::move(plan), accumulate);
  s.note_fits(&plan);
  s.update_visibility(&plan);
  s.update_indirect(request, &plan);
  s.update_octree(request, &plan);
  s.update_glossy(&plan);
  plan.lights = plan.lights && s.lights;  // what glows may be too dim to count
  const bool bandwidth = plan.mode == "bandwidth";
  const int samples = default_samples(request), chunk = choose_chunk(request, samples);
  if (!s.targets || s.targets->width != request.width || s.targets->height != request.height ||
      s.targets->side != side || s.targets->bandwidth != bandwidth ||
      s.targets->texture_bandwidth != plan.texture_bandwidth) {
    s.targets.reset();
    s.glass_framebuffer.reset();
    s.near_terms = Texture();
    s.drawn_surfaces.reset();
    s.traced.reset();
    s.glossy_traced.reset();
    s.drawn_sky.reset();
    s.targets.emplace(make_frame_targets(request.width, request.height, side, bandwidth, plan.texture_bandwidth));
    s.progressive.reset();
    s.history.reset();
    s.drawn_points.reset();
    s.accumulated = 0;
  }
  const bool kept = !bandwidth || s.progressive;  // a frame that was not to be accumulated kept nothing to go on from
  const bool keeps_points = s.keeps_points(request, plan, accumulate);
  const bool painted = std::find(s.repainted.begin(), s.repainted.end(), true) != s.repainted.end();
  const bool repaints = keeps_points && (painted || !accumulate);
  if (painted && !repaints) s.open_found = false;
  if (!accumulate || !kept || repaints || (s.drawn_epoch != s.epoch && !keeps_points) || !(s.last_request == request))
    s.accumulated = 0;
  s.drawn_points.reset();  // until the frame is there
  s.repainted.assign(s.repainted.size(), false);
  s.drawn_epoch = s.epoch;
  s.last_request = request;
  if (!bandwidth) s.renew_light_list_for(static_cast<std::int64_t>(s.accumulated) * samples, samples, request.seed);
  const Turn turn = s.begin_turn(request, plan, bandwidth && request.settings.get_bool("shading.reuse"), accumulate);
  std::optional<float> passing_density;
  if (turn.goes_on() || repaints)
    passing_density = turn.goes_on() && plan.visibility == "baked" ? kTurningMaskedDensity : kTurningDensity;
  s.prepare_constants(request, plan, passing_density, samples, chunk);
  if (!repaints)
    s.prepare_accumulation(plan, accumulate);
  else if (!accumulate)
    s.progressive.reset();
  s.settle_slots();
  s.bind_frame();
  // Of all passes that draw triangles, also where the G-buffer is kept: present() and panels set their own.
  glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
  PassTimer timer(s.device.software);
  timer.start();
  s.skips = s.update_skipping(&plan, request);
  if (s.skips) timer.end("skip");
  const bool goes_on = s.accumulated > 0;  // nothing moved: what is seen and predicted is known
  if (goes_on) leave_out_known(&plan);
  if (turn.goes_on()) note_turn(&plan, s.environment->sun());
  if (repaints) note_repaint(&plan);
  s.keeps_surfaces = true;
  if (!goes_on && s.needs_gbuffer(request, &plan)) s.draw_gbuffer(plan, &timer);
  if (repaints) s.find_repainted(painted, &timer);
  const TileList& tiles = repaints ? s.targets->repainted_tiles : s.targets->surface_tiles;
  if (bandwidth && !goes_on)
    s.predict(plan, {tiles, renewed_share(turn), turn.goes_on() && s.environment->sun()}, &timer);
  MarkRule rule;
  rule.repainted = repaints;
  if (bandwidth && goes_on) {
    rule.refine = s.measure_deviations();
    timer.end("measure");
    s.renew_light_list_after(rule.refine->light_rounds, request.seed);
    timer.end("shade");
  }
  if (const LookupModeInfo* lookup = find_lookup_mode(plan.mode))
    s.shade_by_lookup(*lookup, &timer);
  else if (turn.goes_on())
    s.shade_scheduled(plan, turn, &timer);
  else
    s.shade(plan, chunk, rule, &timer);
  if (bandwidth) s.fill(s.progressive.has_value(), tiles, &timer);
  if (plan.indirect == "baked") s.add_indirect(tiles, &timer);
  ++s.accumulated;
  s.keep_reflections(request, &plan);
  if (plan.glossy) s.reflect_glossy(plan, request, &timer);
  // Mode bandwidth averages its points, not its pictures: what was interpolated early leaves no trace.
  s.compose(plan, request, bandwidth ? 1.0f : 1.0f / static_cast<float>(s.accumulated), &timer);
  s.last_plan = plan;
  if (bandwidth) s.drawn_points = s.points_epoch();
  FrameStats stats;
  stats.passes = timer.finish();
  stats.plan = plan;
  stats.accumulated_frames = s.accumulated;
  stats.visible_pixels = s.visible_points;
  stats.shaded_pixels = s.shaded_points;
  stats.shading_samples = s.shading_samples;
  if (turn.goes_on()) stats.technique["continued_points"] = static_cast<double>(s.continued_points);
  stats.gpu_bytes["geometry"] = s.buffers->geometry_bytes();
  if (s.buffers->has_textures()) stats.gpu_bytes["textures"] = s.buffers->texture_bytes();
  if (s.materials.count() > 0) stats.gpu_bytes["materials"] = s.materials.bytes();
  stats.gpu_bytes["environment"] = s.environment->bytes();
  const FrameTargets& t = *s.targets;
  stats.gpu_bytes["gbuffer"] = t.triangle.bytes() + t.depth_buffer.bytes() + t.surface.bytes() + t.depth.bytes();
  stats.gpu_bytes["shading"] = t.surface_tiles.tiles.bytes() + t.sky_tiles.tiles.bytes() + t.marks.bytes() +
                               t.radiance.bytes() + t.picture.bytes() + t.indirect[0].bytes() + t.indirect[1].bytes() +
                               2 * (t.items[0].bytes() + t.points[0].bytes() + t.partial[0].bytes());
  if (bandwidth)
    stats.gpu_bytes["bandwidth"] = t.energy.bytes() + t.bend.bytes() + t.axes.bytes() + t.weights.bytes() +
                                   t.open.bytes() + t.pyramid.bytes() + s.near_terms.bytes();
  if (s.progressive) stats.gpu_bytes["accumulation"] = s.progressive->bytes();
  if (s.history) stats.gpu_bytes["accumulation"] += s.history->bytes();
  if (s.visibility.ready()) stats.gpu_bytes["visibility"] = s.visibility.bytes();
  if (s.indirect.ready()) stats.gpu_bytes["indirect"] = s.indirect.bytes();
  if (s.octree.ready()) {
    stats.gpu_bytes["octree"] = s.octree.bytes();
    stats.technique["octree_fine_cells"] = static_cast<double>(s.octree.leaf_counts().first);
    stats.technique["octree_coarse_cells"] = static_cast<double>(s.octree.leaf_counts().second);
  }
  if (s.octree.cells()) stats.gpu_bytes["cell_brdfs"] = s.octree.cell_bytes();
  if (s.lights) stats.gpu_bytes["lights"] = s.lights->bytes();
  if (s.irradiance)
    stats.gpu_bytes["glass"] =
        s.irradiance.bytes() + (s.pane_order ? s.pane_order->indices.bytes() : 0) +
        (s.kept_panes ? s.kept_panes->layers.bytes() + s.kept_panes->heads.bytes() +
                            s.kept_panes->covered_tiles.tiles.bytes() + s.kept_panes->bare_tiles.tiles.bytes()
                      : 0);
  if (plan.glossy) {
    stats.gpu_bytes["glossy"] = reflection_bytes(*s.glossy) + s.glossy_light.bytes() + s.glossy_tiles.tiles.bytes();
    s.glossy_technique->add_counters(&stats.technique);
  }
  if (!plan.reflections.empty()) {
    stats.gpu_bytes["reflections"] = reflection_bytes(*s.reflection) + s.coarse_indices.bytes();
    s.reflector_techniques[plan.reflections]->add_bytes(&stats.gpu_bytes);
    s.reflector_techniques[plan.reflections]->add_counters(&stats.technique);
    for (const Reflector& reflector : s.reflectors) {
      if (!reflector.fit) continue;
      std::string& fits = stats.fits[reflector.node];
      fits += (fits.empty() ? "" : "; ") + fit_text(*reflector.fit);
      stats.technique["fitted_patches"] += static_cast<double>(reflector.fit->patches.size());
      double& error_mm = stats.technique["fit_error_mm"];
      error_mm = std::max(error_mm, 1e3 * reflector.fit->largest_m);
    }
    if (s.skips) {
      unsigned counts[2];
      s.skipping->counters.read(0, sizeof counts, counts);
      stats.technique["rays_skipped"] = counts[1];
      stats.technique["rays_skipped_share"] = counts[1] / std::max(1.0 * counts[0] + counts[1], 1.0);
      stats.gpu_bytes["reflections"] += s.skipping->bytes();
    }
  }
  for (const auto& [name, mode] : s.lookup_modes) stats.gpu_bytes["prefilter"] += mode->bytes();
  if (plan.texture_bandwidth) stats.gpu_bytes["texture_bandwidth"] = t.texture_nu.bytes();
  stats.frame_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return stats;
}

Image Renderer::read_radiance() const {
  if (impl_->shows_reference()) return impl_->reference.news.mean;
  Image image(impl_->targets->width, impl_->targets->height, 4);
  glGetTextureImage(impl_->targets->picture.get(), 0, GL_RGBA, GL_FLOAT,
                    static_cast<GLsizei>(image.data.size() * sizeof(float)), image.data.data());
  return image;
}

Renderer::Pick Renderer::pick(int x, int y) const {
  Pick pick;
  if (impl_->shows_reference()) return impl_->pick_traced(x, y);
  const FrameTargets& t = *impl_->targets;
  if (x < 0 || y < 0 || x >= t.width || y >= t.height) return pick;
  const int gx = x * t.side + t.side / 2, gy = y * t.side + t.side / 2;
  std::uint32_t triangle = 0;
  float depth = 0.0f;
  glm::uvec4 surface(0u);
  glGetTextureSubImage(t.triangle.get(), 0, gx, gy, 0, 1, 1, 1, GL_RED_INTEGER, GL_UNSIGNED_INT, 4, &triangle);
  glGetTextureSubImage(t.depth.get(), 0, gx, gy, 0, 1, 1, 1, GL_RED, GL_FLOAT, 4, &depth);
  if (triangle == 0) return pick;
  const FrameConstants& c = impl_->constants;
  const glm::vec2 ndc((2.0f * static_cast<float>(gx) + 1.0f) / static_cast<float>(t.grid_width()) - 1.0f,
                      (2.0f * static_cast<float>(gy) + 1.0f) / static_cast<float>(t.grid_height()) - 1.0f);
  const glm::vec3 ray = glm::vec3(c.forward) + ndc.x * glm::vec3(c.right) - ndc.y * glm::vec3(c.up);
  pick.hit = true;
  pick.position = glm::vec3(c.eye) + ray * depth;
  const FlatGeometry& g = impl_->buffers->geometry();
  const std::size_t first = 3 * (static_cast<std::size_t>(triangle) - 1);
  const glm::vec3 a = g.positions[g.indices[first]], b = g.positions[g.indices[first + 1]],
                  d = g.positions[g.indices[first + 2]];
  pick.normal = glm::normalize(glm::cross(b - a, d - a));
  if (glm::dot(pick.normal, ray) > 0.0f) pick.normal = -pick.normal;
  for (std::size_t i = 0; i < g.items.size(); ++i) {
    const DrawItem& item = g.items[i];
    if (first < item.first_index || first >= item.first_index + item.index_count) continue;
    pick.node = item.node;
    pick.primitive = item.primitive;
    pick.material = impl_->buffers->material(i);
  }
  return pick;
}

}  // namespace maquette
