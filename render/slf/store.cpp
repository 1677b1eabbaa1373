#include "render/slf/store.h"

#include "render/frame/plan.h"
#include "render/frame/request.h"
#include "render/parts/baked_parts.h"
#include "render/scene_state/material_overrides.h"
#include "render/scene_state/scene_state.h"
#include "render/slf/inspect.h"
#include "render/slf/job.h"
#include "render/slf/texel_report.h"

namespace maquette {

namespace {

Key key_of(const SceneState& scene, const FrameRequest& request, const std::vector<bool>& nodes) {
  Key key = Key::of(scene.revisions().all(), request.env_rotation_rad, request.env_scale, request.variant, nodes);
  for (const auto& [name, value] : request.settings.changed()) {
    if (!name.starts_with("slf.") || name == "slf.run" || name.starts_with("slf.slice")) continue;
    key.add(name);
    key.add(to_text(value));
  }
  return key;
}

LightFieldJob make_job(const SceneState& scene, const FrameRequest& request, const std::vector<bool>& nodes) {
  auto shown = std::make_shared<Scene>(scene.edited_scene());
  auto baked = std::make_shared<Scene>(*shown);
  // Light is baked with the file's own materials, so that those that replace them are exchanged without tracing.
  baked->materials = effective_materials(scene.scene(), {});
  LightFieldInput input;
  input.scene = std::move(baked);
  input.shown = std::move(shown);
  input.geometry = std::make_shared<const FlatGeometry>(scene.geometry());
  input.environment = scene.environment().shared_environment();
  input.variant = request.variant;
  input.env_rotation_rad = request.env_rotation_rad;
  input.env_scale = request.env_scale;
  input.wants = [&nodes](int node) { return static_cast<bool>(nodes[static_cast<std::size_t>(node)]); };
  return make_light_field_job(input, request.settings);
}

}  // namespace

Baked<LightField> LightFieldKind::run(const LightFieldJob& job, const Baked<LightField>&,
                                      const BakeTask<LightField>& task) {
  memory_.warn = [this](const std::vector<std::string>& warnings) {
    const std::lock_guard lock(mutex_);
    early_notes_ = warnings;
  };
  const auto field = make_light_field(job, &memory_, task.cancel, task.progress);
  return {field, field != nullptr, true};
}

bool LightFieldStore::update(const SceneState& scene, const FrameRequest& request, const ShadingPlan& layer) {
  const std::vector<bool> nodes = nodes_of_layer(scene.scene(), request, layer);
  const Key key = key_of(scene, request, nodes);
  const bool held = request.settings.get_string("slf.run") == "hold";
  if (held && busy()) cancel();
  if (!held) {
    require(key, [&] { return make_job(scene, request, nodes); });
    changes_.clear();
    changes_of_.reset();
  } else if (field_ && changes_of_ != key) {
    changes_ = changes_since(*field_, make_job(scene, request, nodes));
    changes_of_ = key;
  }
  const std::size_t triangles = scene.geometry().indices.size() / 3;
  const bool lost = buffers_ && triangles_ != triangles;
  if (lost) buffers_.reset();
  const std::shared_ptr<const LightField> field = take();
  if (!field) return lost;
  buffers_.reset();
  field_ = field;
  triangles_ = triangles;
  buffers_.emplace(*field, triangles);
  return true;
}

std::string LightFieldStore::key(const SceneState& scene, const FrameRequest& request, const ShadingPlan& layer) {
  const std::vector<bool> nodes = nodes_of_layer(scene.scene(), request, layer);
  const Key now = key_of(scene, request, nodes);
  if (digits_of_ != now) digits_ = incident_key(make_job(scene, request, nodes).incident);
  digits_of_ = now;
  return digits_;
}

bool LightFieldStore::is_kept(const std::string& key, const std::string& scene, const Settings& settings) const {
  return is_whole_incident(incident_folder(settings.get_string("slf.bake"), scene, key));
}

std::optional<PointReport> LightFieldStore::describe(const SceneState& scene, std::uint32_t triangle, bool back,
                                                     const glm::vec3& position) const {
  if (!field_) return std::nullopt;
  const std::optional<std::size_t> texel = texel_at(field_->atlas, scene.geometry(), triangle, back, position);
  if (!texel) return std::nullopt;
  return describe_texel(*field_, *texel);
}

std::vector<std::string> LightFieldStore::notes() const {
  std::vector<std::string> notes = changes_;
  const std::vector<std::string> more = field_ ? notes_of(*field_) : kind_->early_notes();
  notes.insert(notes.end(), more.begin(), more.end());
  return notes;
}

CompressionTableJob LightFieldStore::compression_table() const {
  if (!field_) return {};
  return [field = field_](const std::atomic<bool>& cancel, const std::function<void(double)>& progress) {
    return tabulate_compression(*field, cancel, progress);
  };
}

}  // namespace maquette
