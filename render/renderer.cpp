#include "render/renderer.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "render/bake/scene_bakes.h"
#include "render/bezier/patch_fit.h"
#include "render/picture/presenter.h"
#include "render/renderer_impl.h"
#include "scenes/error.h"

namespace maquette {

namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point from) {
  return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

GridSize grid_of(const FrameRequest& request) {
  return {request.width, request.height, request.msaa == 16 ? 4 : request.msaa == 4 ? 2 : 1};
}

}  // namespace

Renderer::Renderer(const Registry& registry) : impl_(std::make_unique<Impl>(registry)) {}
Renderer::~Renderer() = default;

// --- the scene ---

const Scene& Renderer::scene() const {
  impl_->scene.require_scene();
  return impl_->scene.scene();
}
const SceneFacts& Renderer::facts() const { return impl_->scene.facts(); }
const Registry& Renderer::registry() const { return impl_->registry; }

void Renderer::set_scene(std::shared_ptr<const Scene> scene) {
  impl_->scene.set_scene(std::move(scene));
  impl_->bakes.clear();
}

void Renderer::set_environment(std::shared_ptr<const Environment> environment) {
  impl_->scene.set_environment(std::move(environment));
  impl_->light_samples = LightSamples();
}

void Renderer::set_material(const std::string& material_name, const std::string& source) {
  impl_->scene.set_material(material_name, source);
}

void Renderer::update_mesh(int mesh, const std::vector<glm::vec3>& positions, const std::vector<glm::vec3>& normals) {
  impl_->scene.update_mesh(mesh, positions, normals);
}

void Renderer::set_node_visible(int node, bool visible) { impl_->scene.set_node_visible(node, visible); }

bool Renderer::move_nodes(std::shared_ptr<const Scene> scene) { return impl_->scene.move_nodes(std::move(scene)); }

void Renderer::set_texture_offset(const std::string& material_name, const glm::vec2& offset) {
  impl_->scene.set_texture_offset(material_name, offset);
}

void Renderer::set_interactive(bool interactive) {
  impl_->interactive = interactive;
  impl_->bakes.set_interactive(interactive);
  impl_->whole = WholePicture();
}

Renderer::PathSnapshot Renderer::path_snapshot() const {
  const SceneState& scene = impl_->scene;
  scene.require_scene();
  return {scene.edited_scene(), scene.environment().shared_environment(), scene.geometry()};
}

// --- a frame ---

ViewInfo Renderer::Impl::look_at(const FrameRequest& request) {
  scene.require_scene();
  scene.update(request.variant);
  const Technique& mode = registry.find_mode(request.mode);
  const Technique* reflector = registry.find_reflector(request.reflections);
  const bool fits = reflector && reflector->can.needs_patches && !mode.can.traces_picture;  // which has no use for them
  ReflectorSet& reflectors = mirrors.reflectors;
  reflectors.update(scene, request, reflector, fits);
  ViewInfo view{request.width, request.height, request.msaa};
  view.reflections = request.reflections;
  view.orthographic = request.camera.is_orthographic();
  view.hidden_share = bakes.shadow_scene().hidden_share();
  view.part_modes = request.part_modes;
  view.reflectors = static_cast<int>(reflectors.all().size());
  view.mirrors = reflectors.has_mirrors();
  const glm::mat4 clip = clip_of(request);
  view.reflectors_in_view = reflectors.in_view(scene, clip);
  view.glossy_in_view = reflector && reflector->make_glossy ? glossy_in_view(scene, reflectors, request, clip) : 0;
  return view;
}

FrameStatus Renderer::Impl::prepare(const FrameRequest& request, const FramePlan& wanted) {
  const auto once = [](const std::string& name, std::function<void()> run) {
    return Pass{.names = {name}, .run = std::move(run)};
  };
  Pass lights_pass = once("list_lights", [&] { scene.list_lights(); });
  lights_pass.skip = [&] { return scene.lights_are_listed() ? std::string("they are those of before") : ""; };
  std::vector<Pass> passes{lights_pass,
                           once("bake_visibility", [&] { bakes.update_visibility(scene); }),
                           once("build_shadow_rays", [&] { bakes.update_shadow_rays(scene, request); }),
                           once("bake_indirect", [&] { bakes.update_indirect(scene, request); }),
                           once("build_octree",
                                [&] {
                                  bakes.update_octree(scene, request);
                                  if (!wanted.cell_brdfs) bakes.update_cells(scene, request, false);
                                }),
                           once("bake_cells", [&] { bakes.update_cells(scene, request, true); })};
  for (const ShadingPlan& layer : wanted.layers)
    if (!layer.own_bake.empty())
      passes.push_back(once("bake_" + layer.own_bake, [&] { bakes.update_own(layer, scene, request); }));
  frame.run(wanted.preparations, passes, [](int) {});
  const bool lights = wanted.prepares("list_lights"), rays = wanted.prepares("build_shadow_rays");
  if (!lights) scene.drop_lights();
  if (!rays) bakes.drop_shadow_rays();
  FrameStatus status;
  status.has_sun = rays && scene.environment().sun();
  status.lights_count = !lights || scene.lights();
  const Technique* reflector = registry.find_reflector(request.reflections);
  if (!wanted.octree) status.keeps_octree = bakes.release_octree(reflector && reflector->can.needs_octree);
  bakes.report(wanted, scene, &status);
  ReflectorSet& reflectors = mirrors.reflectors;
  reflectors.report(&status);
  if (wanted.reflections.empty()) return status;
  const bool traced = wanted.shading().visibility == "traced" && status.octree.ready;
  reflectors.set_drawn(!reflector->can.needs_octree || status.octree.ready);
  mirrors.reflections.report(request, *reflector, scene, reflectors, traced, &status);
  return status;
}

FrameStart Renderer::Impl::start(const FrameRequest& request, bool accumulate, bool layers_made, FrameStatus* status) {
  const std::uint32_t fits = mirrors.reflectors.fits_revision();
  const Key points = Key::of(scene.revisions().without_tables(), bakes.without_indirect(), fits);
  const Key all = Key::of(scene.revisions().all(), bakes.all(), fits);
  const bool nothing_moved = last.scene == all, same_request = last.request == request;
  const Continuation from = layers.compare({request, accumulate, same_request, nothing_moved, points});
  const bool repaints = layers.size() == 1 && from.keeps_points && (scene.tables_swapped() || !accumulate);
  if (layers_made || !accumulate || !from.accumulates || repaints || (!nothing_moved && !from.keeps_points) ||
      !same_request)
    last.accumulated = 0;
  last.scene = all;
  last.request = request;
  const FrameStart start{request, scene, points, accumulate, last.accumulated, repaints};
  status->accumulated = last.accumulated;
  status->single = request.single;
  status->tables_swapped = repaints;
  layers.begin(start, status);
  if (status->light_rotated) status->sun_apart = scene.environment().sun() != nullptr;
  return start;
}

void Renderer::Impl::bind_layer(int layer) {
  scene.bind();
  bakes.bind();
  layers[static_cast<std::size_t>(std::max(layer, 0))].bind();
}

FrameStats Renderer::render(const FrameRequest& asked, bool accumulate) {
  Impl& s = *impl_;
  const auto begin = Clock::now();
  const FrameRequest request = s.with_defaults(asked);
  require_usable(request.camera);
  s.scene.require_scene();
  if (!s.scene.has_environment()) throw Error("renderer", "no environment has been set");
  const ViewInfo view = s.look_at(request);
  const auto plan_for = [&](const FrameStatus& status) {
    return maquette::plan(s.scene.facts(), request.mode, request.settings, view, status, s.registry);
  };
  const FramePlan wanted = plan_for({});
  s.programs.set_common(shader_defines(s.scene.facts().details));
  s.frame.begin(s.device.software);
  FrameStats stats;
  if (s.registry.find_mode(request.mode).can.traces_picture) {
    stats = s.draw_whole_picture(request, wanted, accumulate);
  } else {
    FrameStatus status = s.prepare(request, wanted);
    std::vector<std::string> modes;
    for (const ShadingPlan& layer : wanted.layers) modes.push_back(layer.mode);
    s.parts.update(s.scene, request.part_modes, modes);
    const GridSize size = grid_of(request);
    if (!(size == s.targets.raster.size())) {
      s.layers.clear();
      s.frame.forget(-1);
    }
    s.targets.raster.fit(size);
    const bool made = s.layers.fit(wanted, size, s.registry, [&](int layer) { s.frame.forget(layer); });
    s.targets.composer.fit(size, wanted.layers.size() > 1);
    const FrameStart start = s.start(request, accumulate, made, &status);
    const FramePlan plan = plan_for(status);
    s.carry_out(request, plan, start);
    stats = s.stats_of(plan, status);
  }
  stats.frame_ms = milliseconds_since(begin);
  if (frame_observer) frame_observer(stats);
  return stats;
}

void Renderer::Impl::carry_out(const FrameRequest& request, const FramePlan& plan, const FrameStart& start) {
  const FrameConstants base = make_frame_constants(scene, request, targets.raster.size());
  layers.set_constants(base, start, plan);
  if (!start.repaints && start.accumulated == 0) light_samples.begin_picture(&scene.environment(), request.seed);
  last.constants = layers[0].constants;
  const FrameContext context{device, programs,       registry, scene, bakes,          light_samples,
                             frame,  targets.raster, request,  plan,  last.constants, start.accumulated};
  std::vector<DrawnLayer> drawn;
  for (std::size_t k = 0; k < layers.size(); ++k)
    drawn.push_back(
        {{context, plan.layers[k], static_cast<int>(k), layers[k].surfaces, layers[k].radiance, layers[k].constants},
         *layers[k].mode});
  bool averages_points = true;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    layers[k].mode->prepare(start, drawn[k].context);
    averages_points = averages_points && registry.find_mode(plan.layers[k].mode).can.averages_points;
  }
  if (device.software) targets.slots.settle(&programs);
  bind_layer(0);
  // Of all passes that draw triangles, also where the G-buffer is kept: present() and panels set their own.
  glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
  const float blend = averages_points ? 1.0f : 1.0f / static_cast<float>(start.accumulated + 1);
  targets.composer.begin(plan, layers[0].radiance, blend);
  std::vector<ComposedLayer> composed;
  for (std::size_t k = 0; k < layers.size(); ++k)
    composed.push_back({drawn[k], [this, k, &context] { return layers[k].indirect.bind(context); },
                        plan.layers[k].shadow_rays ? &layers[k].shadows.light() : nullptr});
  const MirroredScene mirrored{
      context, drawn, parts, mirrors.reflectors, targets.composer.depth(layers[0].surfaces), [this](int layer) {
        bind_layer(layer);
      }};
  std::vector<Pass> passes = picture_passes(mirrored, composed);
  for (std::size_t k = 0; k < layers.size(); ++k) {
    for (const std::vector<Pass>& more :
         {surface_passes(drawn[k].context, &layers[k], parts, &targets.sky), drawn[k].mode.passes(drawn[k].context)})
      passes.insert(passes.end(), more.begin(), more.end());
    passes.push_back(indirect_pass(drawn[k].context, &layers[k]));
    passes.push_back(shadow_pass(drawn[k].context, &layers[k], averages_points));
  }
  frame.run(plan.passes, passes, [this](int layer) { bind_layer(layer); });
  ++last.accumulated;
  last.plan = plan;
  last.is_whole_picture = false;
  for (std::size_t k = 0; k < layers.size(); ++k) layers[k].mode->end(start);
  scene.mark_tables_drawn();
}

std::vector<Pass> Renderer::Impl::picture_passes(const MirroredScene& mirrored,
                                                 const std::vector<ComposedLayer>& composed) {
  const FrameContext& context = mirrored.frame;
  const FrameRequest& request = context.request;
  const FramePlan& plan = context.plan;
  Composer& composer = targets.composer;
  const auto surfaces = [this, &request] {
    return Key::of(targets.raster.revision(), parts.revision(), request.camera);
  };
  std::vector<Pass> passes;
  Pass raster{.names = {"raster"}};
  raster.skip = [&context] {
    return context.accumulated > 0 ? std::string("nothing moved: known from the first frame") : "";
  };
  raster.always = !request.settings.get_bool("shading.reuse");
  raster.key = [this, &request] {
    return Key::of(request.camera, request.width, request.height, scene.revisions().surfaces, mirrors.reflectors.key());
  };
  raster.run = [this, &context] {
    targets.raster.draw(scene, context.constants, &programs,
                        [this](std::size_t item) { return mirrors.reflectors.is_mirror(item); });
  };
  passes.push_back(raster);
  const bool averages_points = registry.find_mode(plan.shading().mode).can.averages_points;
  if (!plan.glossy) mirrors.glossy.rest();
  passes.push_back({.names = {"glossy"}, .run = [this, &mirrored, surfaces, averages_points] {
                      mirrors.glossy.run(mirrored, *registry.find_reflector(mirrored.frame.request.reflections),
                                         surfaces(), averages_points);
                    }});
  const auto recorded = std::make_shared<bool>(false);
  passes.push_back(
      {.names = {"compose"}, .run = [this, &mirrored, &composed, &composer, recorded] {
         const FrameContext& frame_context = mirrored.frame;
         *recorded =
             mirrors.panes.record({frame_context, mirrored.layers, parts, mirrors.reflectors}, composer.behind_panes());
         ComposeScene scene_of{frame_context, composed, targets.sky};
         if (frame_context.plan.glossy) scene_of.glossy_light = &mirrors.glossy.light();
         if (!*recorded) return composer.compose(scene_of);
         const Panes& panes = mirrors.panes;
         const RecordedPanes in_place{panes.covered_tiles(), panes.bare_tiles(), [&](const Program& program) {
                                        panes.bind_recorded(program, frame_context.request.env_rotation_rad);
                                      }};
         scene_of.panes = &in_place;
         composer.compose(scene_of);
       }});
  if (!plan.reflections.empty())
    passes.push_back(mirrors.reflections.pass(mirrored, *registry.find_reflector(plan.reflections), averages_points,
                                              surfaces,
                                              [&composer]() -> const Texture& { return composer.behind_panes(); }));
  else
    mirrors.reflections.rest();
  if (!scene.facts().has_blended) mirrors.blended.clear();
  passes.push_back({.names = {"blended"}, .run = [this, &mirrored, surfaces, averages_points] {
                      mirrors.blended.run(mirrored, surfaces(), averages_points);
                    }});
  Pass glass{.names = {"glass"}};
  glass.skip = [recorded] {
    return *recorded ? std::string("panes are kept with the G-buffer: drawn in compose") : "";
  };
  glass.run = [this, &mirrored, &composer] {
    bind_layer(0);
    PaneScene panes{mirrored.frame, mirrored.layers, parts, mirrors.reflectors, {}, &mirrors.blended};
    if (!mirrored.frame.plan.reflections.empty())
      panes.reflected = mirrors.reflections.bind(mirrored.frame.request.settings);
    mirrors.panes.draw(panes, composer.behind_panes());
  };
  passes.push_back(glass);
  passes.push_back({.names = {"filter"}, .run = [this, &composer] {
                      bind_layer(0);
                      composer.filter(&programs);
                    }});
  return passes;
}

FrameStats Renderer::Impl::stats_of(const FramePlan& plan, const FrameStatus& status) {
  FrameStats stats;
  FrameRecord record = frame.finish();
  stats.passes = std::move(record.times);
  stats.skipped = std::move(record.skipped);
  stats.plan = plan;
  stats.status = status;
  stats.accumulated_frames = last.accumulated;
  const ShadingCounts counts = layers.counts();
  stats.visible_pixels = counts.visible;
  stats.shaded_pixels = counts.shaded;
  stats.shading_samples = counts.samples;
  std::map<std::string, std::size_t>* bytes = &stats.gpu_bytes;
  scene.add_bytes(bytes);
  (*bytes)["gbuffer"] = targets.raster.bytes();
  (*bytes)["shading"] = targets.sky.tiles.tiles.bytes() + targets.composer.bytes();
  bakes.add_bytes(bytes);
  bakes.add_counters(&stats.technique);
  layers.add_bytes_at_rest(bytes);
  for (std::size_t k = 0; k < layers.size(); ++k) {
    layers[k].add_bytes(bytes);
    layers[k].mode->add_counters(&stats.technique);
  }
  if (parts.several()) (*bytes)["parts"] = parts.bytes();
  if (plan.glass || mirrors.panes.bytes() > 0) (*bytes)["glass"] = mirrors.panes.bytes();
  if (mirrors.blended.bytes() > 0) (*bytes)["blended"] = mirrors.blended.bytes();
  if (plan.glossy) {
    (*bytes)["glossy"] = mirrors.glossy.bytes();
    mirrors.glossy.add_counters(&stats.technique);
  }
  if (!plan.reflections.empty()) {
    mirrors.reflections.add_bytes(mirrors.reflectors, bytes);
    mirrors.reflections.add_counters(mirrors.reflectors, &stats.technique);
    for (const Reflector& reflector : mirrors.reflectors.all()) {
      if (!reflector.fit) continue;
      std::string& fits = stats.fits[reflector.node];
      fits += (fits.empty() ? "" : "; ") + fit_text(*reflector.fit);
    }
  }
  return stats;
}

FrameStats Renderer::Impl::draw_whole_picture(const FrameRequest& request, const FramePlan& plan, bool accumulate) {
  if (whole.mode_name != request.mode || !whole.mode) {
    whole = WholePicture();
    whole.mode_name = request.mode;
    whole.mode = registry.find_mode(request.mode).make_picture_mode();
  }
  Pass trace{.names = {plan.passes.front().name}};
  trace.run = [&] { whole.mode->draw({scene, request, accumulate, interactive}); };
  frame.run(plan.passes, {trace}, [](int) {});
  whole.texture_stale = true;
  last.request = request;
  last.plan = plan;
  last.scene.reset();
  last.is_whole_picture = true;
  FrameStats stats;
  FrameRecord record = frame.finish();
  stats.passes = std::move(record.times);
  stats.skipped = std::move(record.skipped);
  stats.plan = plan;
  stats.accumulated_frames = whole.mode->frames();
  stats.visible_pixels = stats.shaded_pixels = whole.mode->covered_pixels();
  stats.shading_samples = whole.mode->samples();
  whole.mode->add_counters(&stats.technique);
  stats.estimated_error = whole.mode->estimated_error();
  return stats;
}

void Renderer::forget_frames() {
  Impl& s = *impl_;
  s.layers.clear();
  s.frame.forget(-1);
  s.last = LastFrame();
  s.whole = WholePicture();
  s.light_samples.forget();
  s.mirrors.reflections = Reflections();
  s.mirrors.glossy.clear();
  s.mirrors.blended.clear();
  s.mirrors.panes = Panes();
}

bool Renderer::finish_background_work(const FrameRequest& asked) {
  Impl& s = *impl_;
  const FrameRequest request = s.with_defaults(asked);
  ViewInfo view = s.look_at(request);
  if (s.mirrors.reflectors.patch_fits().busy()) {
    s.mirrors.reflectors.patch_fits().wait();
    view = s.look_at(request);
  }
  // What is there decides what more is wanted.
  bool all = true;
  for (std::optional<double> known = -1.0; known != view.hidden_share; view = s.look_at(request)) {
    known = view.hidden_share;
    const FramePlan wanted = maquette::plan(s.scene.facts(), request.mode, request.settings, view, {}, s.registry);
    all = s.bakes.finish(wanted, s.scene, request);
    view.hidden_share = s.bakes.shadow_scene().hidden_share();
  }
  return all;
}

std::optional<BakeKeys> Renderer::bake_keys(const FrameRequest& asked) {
  Impl& s = *impl_;
  const FrameRequest request = s.with_defaults(asked);
  ViewInfo view = s.look_at(request);
  const bool counted = view.hidden_share.has_value();
  const auto wanted_bakes = [&](double hidden_share) {
    view.hidden_share = hidden_share;
    const FramePlan wanted = maquette::plan(s.scene.facts(), request.mode, request.settings, view, {}, s.registry);
    std::vector<std::string> names;
    for (const std::string& bake : keyed_bakes(s.registry))
      if (wanted.prepares("bake_" + bake)) names.push_back(bake);
    return names;
  };
  const std::vector<std::string> names = wanted_bakes(view.hidden_share.value_or(0.0));
  if (!counted && names != wanted_bakes(1.0)) return std::nullopt;
  BakeKeys keys;
  for (const std::string& bake : names)
    if (std::string key = bake_key(request, bake); !key.empty()) keys[bake] = std::move(key);
  return keys;
}

std::string Renderer::bake_key(const FrameRequest& asked, const std::string& bake) {
  Impl& s = *impl_;
  const FrameRequest request = s.with_defaults(asked);
  const ViewInfo view = s.look_at(request);
  return s.bakes.key(bake, maquette::plan(s.scene.facts(), request.mode, request.settings, view, {}, s.registry),
                     s.scene, request);
}

std::vector<BackgroundWork> Renderer::background_work() const {
  const Impl& s = *impl_;
  std::vector<BackgroundWork> work;
  std::vector<const Bake*> bakes = s.bakes.list();
  bakes.push_back(&s.mirrors.reflectors.patch_fits());
  for (const Bake* bake : bakes)
    if (bake->busy()) work.push_back({bake->name(), bake->progress()});
  if (!s.shows_whole_picture()) return work;
  if (const std::optional<double> progress = s.whole.mode->progress())
    work.push_back({s.last.plan.passes.front().name, *progress});
  return work;
}

// --- shaders ---

std::vector<ShaderVariant> all_shader_variants(const Registry& registry) {
  std::vector<ShaderVariant> all{TextureSlots::variant()};
  for (const int side : {1, 2, 4}) all.push_back(present_variant(side));
  const auto add = [&](const std::vector<ShaderVariant>& more) {
    for (const ShaderVariant& variant : more)
      if (std::find(all.begin(), all.end(), variant) == all.end()) all.push_back(variant);
  };
  for (const auto& more : {Raster::shader_variants(), Surfaces::shader_variants(), Composer::shader_variants(),
                           IndirectPass::shader_variants(), point_rays_shader_variants(), Panes::shader_variants(),
                           Blended::shader_variants(), Reflections::shader_variants(), Glossy::shader_variants(),
                           Parts::shader_variants()})
    add(more);
  for (const Technique& technique : registry.techniques)
    if (technique.shader_variants) add(technique.shader_variants());
  return all;
}

}  // namespace maquette
