#include "render/bake/scene_bakes.h"

#include "render/octree/octree_file.h"
#include "render/octree/octree_interest.h"
#include "render/octree/technique.h"
#include "render/technique/registry.h"

namespace maquette {

namespace {

/// So many frames of a window an octree stays that nothing in view goes through: to read it again takes a third of a
/// second, in which nothing is mirrored.
constexpr int kFramesWithoutOctree = 200;

OctreeState octree_state(const SceneState& scene, const Settings& settings) {
  OctreeState state;
  state.geometry_epoch = scene.revisions().geometry;
  state.transmits = scene.transmitting_items();
  for (std::size_t i = 0; i < scene.geometry().items.size(); ++i)
    state.materials.push_back(scene.buffers().material(i));
  state.depth = settings.get_int("octree.depth");
  state.detail = octree_detail(settings);
  state.interest = find_interest(settings.get_string("octree.interest"), scene.scene(), scene.geometry());
  state.path = octree_file_path(settings.get_string("octree.bake"), scene.scene().name, state.depth);
  return state;
}

}  // namespace

void SceneBakes::set_interactive(bool interactive) {
  interactive_ = interactive;
  indirect_.set_prepares(interactive);
}

void SceneBakes::clear() {
  visibility_.clear();
  indirect_.clear();
  indirect_of_.reset();
  octree_.clear();
  shadow_scene_.clear();
  own_.clear();
}

void SceneBakes::update_own(const ShadingPlan& layer, const SceneState& scene, const FrameRequest& request) {
  if (!layer.own_bake.empty() && own_of(layer).update(scene, request, layer)) ++own_revision_;
}

SceneBake& SceneBakes::own_of(const ShadingPlan& layer) {
  std::unique_ptr<SceneBake>& own = own_[layer.own_bake];
  if (!own) own = registry_.find_mode(layer.mode).own_bake->make();
  return *own;
}

std::string SceneBakes::key(const std::string& bake, const FramePlan& wanted, const SceneState& scene,
                            const FrameRequest& request) {
  if (scene.geometry().positions.empty()) return {};
  if (bake == visibility_.name())
    return visibility_.key(scene.geometry(), scene.transmitting_items(), scene.passages());
  if (bake == indirect_.name()) return indirect_.key(make_indirect_job(scene, request));
  for (const ShadingPlan& layer : wanted.layers)
    if (layer.own_bake == bake) return own_of(layer).key(scene, request, layer);
  return {};
}

std::vector<const Bake*> SceneBakes::list() const {
  std::vector<const Bake*> all{&visibility_, &indirect_, &octree_, &octree_.cell_bake(), &shadow_scene_};
  for (const auto& [name, own] : own_) all.push_back(&own->bake());
  return all;
}

void SceneBakes::update_visibility(const SceneState& scene) {
  if (scene.geometry().positions.empty()) return;
  if (visibility_.update(scene.geometry(), scene.transmitting_items(), scene.passages(), scene.revisions().geometry))
    ++visibility_revision_;
}

void SceneBakes::update_shadow_rays(const SceneState& scene, const FrameRequest& request) {
  if (scene.geometry().positions.empty()) return;
  if (shadow_scene_.update(scene, request.variant)) ++shadow_revision_;
}

std::shared_ptr<const IndirectInput> SceneBakes::make_indirect_input(const SceneState& scene, int variant) const {
  auto input = std::make_shared<IndirectInput>();
  input->scene = scene.edited_scene();
  input->geometry = std::make_shared<FlatGeometry>(scene.geometry());
  input->variant = variant;
  input->transmits = scene.transmitting_items();
  const std::vector<Material>& materials = scene.effective_materials();
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const int slot = materials[i].measured.empty() ? -1 : scene.slots()[i];
    input->measured_albedo.push_back(slot < 0 ? std::vector<glm::vec3>() : scene.materials().albedo(slot));
    input->measured_hash.push_back(slot < 0 ? 0 : scene.materials().hash(slot));
  }
  return input;
}

void SceneBakes::update_indirect(const SceneState& scene, const FrameRequest& request) {
  if (!visibility_.ready()) return;
  IndirectJob job = make_indirect_job(scene, request);
  job.visibility = visibility_.bake();
  indirect_of_ = indirect_key(scene, request);
  if (indirect_.update(job)) ++indirect_revision_;
}

Key SceneBakes::indirect_key(const SceneState& scene, const FrameRequest& request) {
  return Key::of(scene.revisions().bounces(), request.variant);
}

IndirectJob SceneBakes::make_indirect_job(const SceneState& scene, const FrameRequest& request) const {
  const bool known = indirect_.input() && indirect_of_ == indirect_key(scene, request);
  IndirectJob job;
  job.input = known ? indirect_.input() : make_indirect_input(scene, request.variant);
  job.sky = {scene.environment().shared_environment(), request.env_rotation_rad, request.env_scale};
  return job;
}

OctreeJob SceneBakes::make_octree_job(const SceneState& scene, const OctreeState& state,
                                      const std::string& folder) const {
  OctreeJob job;
  job.geometry = scene.geometry();
  job.materials = state.materials;
  job.transmits = state.transmits;
  job.textures = std::make_shared<const OctreeTextures>(scene.scene(), scene.effective_materials());
  job.options.depth = state.depth;
  job.options.detail = state.detail;
  job.options.interest = state.interest;
  job.path = state.path;
  job.scene = scene.scene().name;
  job.must_save = !folder.empty();
  job.keeps = folder.empty();
  return job;
}

void SceneBakes::update_octree(const SceneState& scene, const FrameRequest& request) {
  frames_without_octree_ = 0;
  const OctreeState state = octree_state(scene, request.settings);
  const std::string& folder = request.settings.get_string("octree.bake");
  if (octree_.update(state, [&] { return make_octree_job(scene, state, folder); })) ++octree_revision_;
}

void SceneBakes::update_cells(const SceneState& scene, const FrameRequest& request, bool wanted) {
  if (!octree_.ready()) return;
  const auto make_job = [&] {
    CellBrdfJob job;
    job.octree =
        make_octree_job(scene, octree_state(scene, request.settings), request.settings.get_string("octree.bake"));
    job.materials = scene.effective_materials();
    return job;
  };
  const auto contents = wanted ? cell_material_contents(scene.effective_materials()) : std::vector<std::uint64_t>();
  if (octree_.update_cells(contents, make_job)) ++octree_revision_;
}

bool SceneBakes::release_octree(bool may_return) {
  const bool keeps = interactive_ && may_return && (octree_.ready() || octree_.busy()) &&
                     ++frames_without_octree_ <= kFramesWithoutOctree;
  if (!keeps) octree_.clear();
  return keeps;
}

void SceneBakes::report(const FramePlan& wanted, const SceneState& scene, FrameStatus* status) const {
  status->has_geometry = !scene.geometry().positions.empty();
  if (wanted.prepares("bake_visibility")) status->visibility = status_of(visibility_);
  if (wanted.prepares("bake_indirect")) status->indirect = status_of(indirect_);
  for (const ShadingPlan& layer : wanted.layers) {
    const auto own = own_.find(layer.own_bake);
    if (own == own_.end()) continue;
    BakeStatus& of_own = status->own_bakes[layer.own_bake];
    of_own = status_of(own->second->bake());
    of_own.notes = own->second->notes();
  }
  if (wanted.prepares("build_shadow_rays")) status->shadow_rays = status_of(shadow_scene_);
  if (wanted.octree) status->octree = status_of(octree_);
  if (wanted.cell_brdfs && octree_.ready()) status->cell_brdfs = status_of(octree_.cell_bake());
}

bool SceneBakes::finish(const FramePlan& wanted, const SceneState& scene, const FrameRequest& request) {
  bool all = true;  // what cannot be made takes nothing from what can
  for (const ShadingPlan& layer : wanted.layers) {
    update_own(layer, scene, request);
    const auto own = own_.find(layer.own_bake);
    if (own == own_.end()) continue;
    own->second->bake().wait();
    update_own(layer, scene, request);
    all = all && own->second->bake().ready();
  }
  if (wanted.prepares("build_shadow_rays") && !scene.geometry().positions.empty()) {
    update_shadow_rays(scene, request);
    shadow_scene_.wait();
    update_shadow_rays(scene, request);
    all = all && shadow_scene_.ready();
  }
  if (wanted.octree) {
    for (int round = 0; round < 3; ++round) {  // starts it, takes it over and starts the cells' BRDFs, takes them over
      update_octree(scene, request);
      update_cells(scene, request, wanted.cell_brdfs);
      octree_.wait();
    }
    update_cells(scene, request, wanted.cell_brdfs);
  }
  // What follows needs baked visibility.
  if (!wanted.prepares("bake_visibility") || scene.geometry().positions.empty()) return all;
  update_visibility(scene);
  visibility_.wait();
  update_visibility(scene);
  if (!wanted.prepares("bake_indirect") || !visibility_.ready()) return all && visibility_.ready();
  for (int round = 0; round < 2; ++round) {  // starts the bake, then takes it over
    update_indirect(scene, request);
    indirect_.wait();
  }
  return all && indirect_.current();
}

void SceneBakes::bind() const {
  if (visibility_.ready()) visibility_.bind();
  if (octree_.ready()) octree_.buffers().bind();
  for (const auto& [name, own] : own_)
    if (own->bake().ready()) own->bind();
}

void SceneBakes::add_bytes(std::map<std::string, std::size_t>* bytes) const {
  if (visibility_.ready()) (*bytes)[visibility_.name()] = visibility_.bytes();
  if (indirect_.ready()) (*bytes)[indirect_.name()] = indirect_.bytes();
  if (octree_.ready()) (*bytes)[octree_.name()] = octree_.bytes();
  if (shadow_scene_.ready()) (*bytes)[shadow_scene_.name()] = shadow_scene_.bytes();
  if (octree_.cells()) (*bytes)[octree_.cell_bake().name()] = octree_.cell_bytes();
  for (const auto& [name, own] : own_)
    if (own->bake().ready()) (*bytes)[name] = own->bake().bytes();
}

void SceneBakes::add_counters(std::map<std::string, double>* counters) const {
  if (!octree_.ready()) return;
  (*counters)["octree_fine_cells"] = static_cast<double>(octree_.leaf_counts().first);
  (*counters)["octree_coarse_cells"] = static_cast<double>(octree_.leaf_counts().second);
}

}  // namespace maquette
