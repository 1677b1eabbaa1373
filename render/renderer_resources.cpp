// What a plan needs besides the scene itself, made when it is first needed: facts, lights, the visibility bake.
#include <cmath>
#include <cstdio>

#include "render/material_overrides.h"
#include "render/octree/octree_file.h"
#include "render/octree/octree_interest.h"
#include "render/octree/technique.h"
#include "render/renderer_impl.h"

namespace maquette {

namespace {

/// So many frames of a window an octree stays that nothing in view goes through: to read it again takes a third of a
/// second, in which nothing is mirrored.
constexpr int kFramesWithoutOctree = 200;

}  // namespace

std::string percent(double fraction) {
  char text[16];
  std::snprintf(text, sizeof text, "%.0f %%", std::floor(100.0 * fraction));
  return text;
}

const Material& Renderer::Impl::material_of_item(std::size_t item) const {
  static const Material kDefault;
  const auto index = static_cast<std::size_t>(buffers->material(item));
  return index < effective.size() ? effective[index] : kDefault;
}

bool Renderer::Impl::shows_both_sides(std::size_t item) const {
  return material_of_item(item).double_sided || buffers->geometry().items[item].patch >= 0;
}

Scene Renderer::Impl::edited_scene() const {
  Scene edited = *scene;
  edited.materials = effective;
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) {
    const int node = buffers->geometry().items[i].node;
    if (node >= 0) edited.nodes[static_cast<std::size_t>(node)].visible = buffers->visible(i);
  }
  return edited;
}

void Renderer::Impl::update_facts(int variant) {
  const bool replan = facts_variant != variant;
  if (!replan && !lights_stale) return;
  if (buffers_variant != variant) {
    buffers->update_variant(*scene, variant);
    buffers_variant = variant;
    ++surface_epoch;
  }
  const Scene planned = edited_scene();
  facts = compute_facts(planned, variant);
  facts_variant = variant;
  lights.reset();
  lights_stale = false;
  if (!facts.has_punctual_lights && !facts.has_emissive_meshes) return;
  const LightList list = build_light_list(planned, buffers->geometry(), variant);
  if (!list.lights.empty()) lights.emplace(list);
}

void Renderer::Impl::recount_tables() {
  std::vector<bool> used(effective.size() + 1, false);
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i)
    if (buffers->visible(i)) used[static_cast<std::size_t>(buffers->material(i))] = true;
  facts.measured_count = facts.analytic_count = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const bool measured = i < effective.size() && !effective[i].measured.empty();
    if (used[i]) ++(measured ? facts.measured_count : facts.analytic_count);
  }
}

ViewInfo Renderer::Impl::view_info(const FrameRequest& request) const {
  ViewInfo view{request.width, request.height, request.msaa};
  view.reflections = request.reflections;
  view.reflectors = static_cast<int>(reflectors.size());
  view.reflectors_in_view = reflectors_in_view(request);
  view.glossy_in_view = glossy_in_view(request);
  for (const Reflector& reflector : reflectors) view.mirrors = view.mirrors || reflector.mirror;
  return view;
}

std::vector<bool> Renderer::Impl::transmitting_items() const {
  std::vector<bool> transmits;
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) {
    const Material& m = material_of_item(i);
    transmits.push_back(m.glass || m.alpha_mode == AlphaMode::blend || !buffers->visible(i));
  }
  return transmits;
}

std::vector<Passage> Renderer::Impl::passages() const {
  std::vector<Passage> passages;
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) {
    const Material& m = material_of_item(i);
    const float inside = (m.base_color.r + m.base_color.g + m.base_color.b) / 3.0f;
    if (!buffers->visible(i))
      passages.emplace_back();
    else if (const float share = pane_share(m); share > 0.0f)
      passages.push_back({share, std::max(m.ior, 1.0f), std::clamp(inside, 0.0f, 1.0f)});
    else
      passages.push_back({m.alpha_mode == AlphaMode::blend ? 1.0f - m.base_color.a : 1.0f, 1.0f, 1.0f});
  }
  return passages;
}

void Renderer::Impl::take_visibility() {
  if (!visibility.update(buffers->geometry(), transmitting_items(), passages(), geometry_epoch)) return;
  ++epoch;
  open_found = false;
}

void Renderer::Impl::update_visibility(FramePlan* plan) {
  if (plan->visibility != "baked") return;
  const bool empty = buffers->geometry().positions.empty();
  if (!empty) take_visibility();
  if (visibility.ready()) return;
  plan->visibility = "none";
  std::erase_if(plan->passes, [](const PlannedPass& pass) { return pass.name == "visibility"; });
  plan->left_out.push_back({"visibility", empty ? "nothing is there to occlude"
                                                : "its bake is not ready yet: " + percent(visibility.progress())});
}

std::shared_ptr<const IndirectInput> Renderer::Impl::make_indirect_input(int variant) const {
  auto input = std::make_shared<IndirectInput>();
  input->scene = edited_scene();
  input->geometry = std::make_shared<FlatGeometry>(buffers->geometry());
  input->variant = variant;
  input->transmits = transmitting_items();
  for (std::size_t i = 0; i < effective.size(); ++i) {
    const int slot = effective[i].measured.empty() ? -1 : slots[i];
    input->measured_albedo.push_back(slot < 0 ? std::vector<glm::vec3>() : materials.albedo(slot));
    input->measured_hash.push_back(slot < 0 ? 0 : materials.hash(slot));
  }
  return input;
}

void Renderer::Impl::update_indirect(const FrameRequest& request, FramePlan* plan) {
  if (plan->indirect != "baked") return;
  if (visibility.ready()) {
    const bool stale = indirect_epoch != bounce_epoch || indirect_variant != request.variant || !indirect.input();
    IndirectJob job;
    job.input = stale ? make_indirect_input(request.variant) : indirect.input();
    job.visibility = visibility.bake();
    job.sky = {environment->shared_environment(), request.env_rotation_rad, request.env_scale};
    indirect_epoch = bounce_epoch;
    indirect_variant = request.variant;
    if (indirect.update(job)) {
      ++epoch;
      ++indirect_news;
    }
  }
  if (indirect.ready() && plan->visibility == "baked") return;
  plan->indirect = "none";
  std::erase_if(plan->passes, [](const PlannedPass& pass) { return pass.name == "indirect"; });
  plan->left_out.push_back({"indirect", visibility.ready()
                                            ? "its bake is not ready yet: " + percent(indirect.progress())
                                            : "it waits for the bake of visibility"});
}

void Renderer::Impl::update_cell_brdfs(const Settings& settings, const std::function<OctreeJob()>& make_octree,
                                       FramePlan* plan) {
  const bool wanted = (plan->reflections == "octree" || plan->glossy) && settings.get_string("octree.brdf") != "none";
  const auto make_job = [&] {
    CellBrdfJob job;
    job.octree = make_octree();
    job.materials = effective;
    return job;
  };
  const auto contents = wanted ? cell_material_contents(effective) : std::vector<std::uint64_t>();
  if (octree.update_cells(contents, make_job)) ++epoch;
  if (!wanted || octree.cells()) return;
  std::erase_if(plan->passes, [](const PlannedPass& p) { return p.name == "cell_brdfs"; });
  plan->left_out.push_back({"cell_brdfs", "their bake is not ready yet: " + percent(octree.cells_progress())});
}

bool Renderer::Impl::keep_octree(const std::string& technique, FramePlan* plan) {
  if (!interactive || technique != "octree" || (!octree.ready() && !octree.busy()) ||
      ++frames_without_octree > kFramesWithoutOctree)
    return false;
  for (LeftOut& left_out : plan->left_out)
    if (left_out.what == "octree") left_out.why = "nothing in view goes through it; kept for some frames more";
  return true;
}

void Renderer::Impl::update_octree(const FrameRequest& request, FramePlan* plan) {
  const Settings& settings = request.settings;
  if (plan->visibility != "traced" && plan->reflections != "octree" && !plan->glossy) {
    if (!keep_octree(request.reflections, plan)) octree.clear();
    return;
  }
  frames_without_octree = 0;
  OctreeState state;
  state.geometry_epoch = geometry_epoch;
  state.transmits = transmitting_items();
  for (std::size_t i = 0; i < buffers->geometry().items.size(); ++i) state.materials.push_back(buffers->material(i));
  state.depth = settings.get_int("octree.depth");
  state.detail = octree_detail(settings);
  state.interest = find_interest(settings.get_string("octree.interest"), *scene, buffers->geometry());
  const std::string& folder = settings.get_string("octree.bake");
  state.path = octree_file_path(folder, scene->name, state.depth);
  const auto make_job = [&] {
    OctreeJob job;
    job.geometry = buffers->geometry();
    job.materials = state.materials;
    job.transmits = state.transmits;
    job.paint = std::make_shared<const OctreePaint>(*scene, effective);
    job.options.depth = state.depth;
    job.options.detail = state.detail;
    job.options.interest = state.interest;
    job.path = state.path;
    job.scene = scene->name;
    job.must_load = !folder.empty();
    return job;
  };
  if (octree.update(state, make_job)) ++epoch;
  if (octree.ready()) {
    update_cell_brdfs(settings, make_job, plan);
    return;
  }
  const auto leave_out = [&](const std::string& what, const std::string& why) {
    std::erase_if(plan->passes, [&](const PlannedPass& p) { return p.name == what; });
    plan->left_out.push_back({what, why});
  };
  leave_out("octree", "it is not built yet: " + percent(octree.progress()));
  if (plan->visibility == "traced") {
    plan->visibility = "none";
    leave_out("visibility", "its octree is not built yet");
  }
  if (plan->reflections == "octree") {
    plan->reflections.clear();
    std::erase_if(plan->passes, [](const PlannedPass& p) { return p.name == "rays"; });
    leave_out("reflections", "their octree is not built yet");
    forget_reflectors();
  }
}

bool Renderer::finish_background_work(const FrameRequest& request) {
  Impl& s = *impl_;
  s.require_ready();
  s.update_facts(request.variant);
  s.update_reflectors(request);
  if (s.patch_fits.busy()) {
    s.patch_fits.wait();
    s.update_reflectors(request);
  }
  FramePlan plan = maquette::plan(s.facts, request.mode, request.settings, s.view_info(request));
  if (plan.visibility == "traced" || plan.reflections == "octree" || plan.glossy) {
    FramePlan now = plan;  // says what is missing: not what is wanted
    s.update_octree(request, &now);
    for (int round = 0; round < 2; ++round) {  // the cells' BRDFs start when the octree is there
      s.octree.wait();
      FramePlan wanted = plan;
      s.update_octree(request, &wanted);
    }
  }
  if (plan.visibility != "baked" || s.buffers->geometry().positions.empty()) return true;
  s.update_visibility(&plan);
  s.visibility.wait();
  s.take_visibility();
  if (plan.indirect != "baked" || !s.visibility.ready()) return s.visibility.ready();
  for (int round = 0; round < 2; ++round) {  // starts the bake, then takes it
    FramePlan wanted = plan;
    s.update_indirect(request, &wanted);
    s.indirect.wait();
  }
  return s.indirect.current();
}

std::vector<BackgroundWork> Renderer::background_work() const {
  std::vector<BackgroundWork> work;
  if (impl_->visibility.busy()) work.push_back({"visibility", impl_->visibility.progress()});
  if (impl_->indirect.busy()) work.push_back({"indirect", impl_->indirect.progress()});
  if (impl_->patch_fits.busy()) work.push_back({"patch_fit", impl_->patch_fits.progress()});
  if (impl_->octree.busy()) work.push_back({"octree", impl_->octree.progress()});
  if (impl_->octree.cells_busy()) work.push_back({"cell_brdfs", impl_->octree.cells_progress()});
  // So few paths are too noisy to be metered.
  constexpr int kFirstPaths = 4;
  const int paths = impl_->reference.news.paths;
  if (impl_->interactive && impl_->shows_reference() && paths < kFirstPaths)
    work.push_back({"trace", static_cast<double>(paths) / kFirstPaths});
  return work;
}

}  // namespace maquette
