#include "render/scene_state/scene_state.h"

#include <algorithm>
#include <utility>

#include "render/math/surface_formulas.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

/// What is added to a scene, as a ground, comes last, and a material of the scene may have its name.
Material* last_named(std::vector<Material>* materials, const std::string& name) {
  const auto found =
      std::find_if(materials->rbegin(), materials->rend(), [&](const Material& m) { return m.name == name; });
  return found == materials->rend() ? nullptr : &*found;
}

}  // namespace

void SceneState::require_scene() const {
  if (!scene_ || !buffers_) throw Error("renderer", "no scene has been set");
}

void SceneState::set_scene(std::shared_ptr<const Scene> scene) {
  SceneBuffers buffers(*scene);
  for (const Material& m : scene->materials)
    if (!m.measured.empty()) materials_.slot_of(m.measured);  // throws before anything changes
  scene_ = std::move(scene);
  buffers_.emplace(std::move(buffers));
  facts_variant_ = kNone;
  buffers_variant_ = -1;
  overrides_.clear();
  texture_offsets_.clear();
  find_effective_materials();
  upload_materials();
  ++revisions_.geometry;
  ++revisions_.occlusion;
  ++revisions_.surfaces;
  ++revisions_.lights;
}

void SceneState::set_environment(std::shared_ptr<const Environment> environment) {
  environment_.emplace(std::move(environment));
  if (buffers_) upload_materials();
  ++revisions_.sky;
}

void SceneState::set_material(const std::string& material_name, const std::string& source) {
  require_scene();
  std::vector<std::string> names{"*"};
  for (const Material& m : scene_->materials) names.push_back(m.name);
  if (std::find(names.begin(), names.end(), material_name) == names.end())
    throw UsageError("--material", "the scene has no material '" + material_name + "'",
                     did_you_mean(material_name, names));
  std::map<std::string, std::string> sources = overrides_;
  if (material_name == "*") sources.clear();
  if (source.empty())
    sources.erase(material_name);
  else
    sources[material_name] = source;
  if (!source.empty() && source != "builtin:glass") materials_.slot_of(source);  // throws before anything changes
  overrides_ = std::move(sources);
  find_effective_materials();
  const std::uint32_t surfaces = revisions_.surfaces;
  upload_materials();
  if (revisions_.surfaces != surfaces) {
    facts_variant_ = kNone;
    ++revisions_.lights;
  } else {
    recount_tables();
    ++revisions_.tables;
  }
}

void SceneState::find_effective_materials() {
  effective_ = maquette::effective_materials(*scene_, overrides_);
  for (const auto& [name, offset] : texture_offsets_)
    if (Material* material = last_named(&effective_, name)) material->base_color_texture.offset = offset;
}

void SceneState::set_texture_offset(const std::string& material_name, const glm::vec2& offset) {
  require_scene();
  texture_offsets_[material_name] = offset;
  find_effective_materials();
  if (const Material* moved = last_named(&effective_, material_name))
    buffers_->set_texture_offset(static_cast<std::size_t>(moved - effective_.data()), offset);
  ++revisions_.surfaces;
}

void SceneState::upload_materials() {
  swapped_.resize(effective_.size() + 1, false);
  const std::vector<int> before = std::exchange(slots_, {});
  std::vector<float> shares, limits;
  const float environment_sr = environment_ ? environment_->effective_sr() : 12.566f;
  for (const Material& m : effective_) {
    const int slot = m.measured.empty() ? -1 : materials_.slot_of(m.measured);
    slots_.push_back(slot);
    limits.push_back(slot < 0 ? 0.0f : materials_.bandwidth_limit(slot));
    if (slot >= 0) {
      shares.push_back(materials_.brdf_share(slot, environment_sr));
    } else {
      const float gloss = std::clamp(1.0f - m.roughness, 0.0f, 1.0f);
      shares.push_back(std::clamp(0.375f + 0.375f * gloss * std::max(m.metallic, m.clearcoat), 0.25f, 0.875f));
    }
  }
  slots_.push_back(-1);
  shares.push_back(0.5f);
  limits.push_back(0.0f);
  for (std::size_t i = 0; i < slots_.size(); ++i)
    if (i >= before.size() || slots_[i] != before[i]) swapped_[i] = true;
  if (buffers_->update_materials(effective_, slots_, shares, limits, swapped_)) ++revisions_.surfaces;
}

bool SceneState::tables_swapped() const { return std::find(swapped_.begin(), swapped_.end(), true) != swapped_.end(); }

void SceneState::mark_tables_drawn() { swapped_.assign(swapped_.size(), false); }

void SceneState::update_mesh(int mesh, const std::vector<glm::vec3>& positions, const std::vector<glm::vec3>& normals) {
  require_scene();
  buffers_->update_mesh(*scene_, mesh, positions, normals);
  for (std::size_t i = 0; i < geometry().items.size(); ++i) {
    const bool shines = material_of_item(i).emissive != glm::vec3(0.0f);
    if (shines && geometry().items[i].mesh == mesh) {
      ++revisions_.lights;
      facts_variant_ = kNone;
      break;
    }
  }
  ++revisions_.geometry;
  ++revisions_.occlusion;
  ++revisions_.surfaces;
}

bool SceneState::move_nodes(std::shared_ptr<const Scene> scene) {
  require_scene();
  if (!buffers_->move(*scene)) return false;
  scene_ = std::move(scene);
  facts_variant_ = kNone;
  ++revisions_.geometry;
  ++revisions_.occlusion;
  ++revisions_.surfaces;
  ++revisions_.lights;
  return true;
}

void SceneState::set_node_visible(int node, bool visible) {
  require_scene();
  buffers_->set_node_visible(node, visible);
  facts_variant_ = kNone;
  ++revisions_.occlusion;
  ++revisions_.surfaces;
  ++revisions_.lights;
}

void SceneState::update(int variant) {
  if (facts_variant_ == variant) return;
  if (buffers_variant_ != variant) {
    buffers_->update_variant(*scene_, variant);
    buffers_variant_ = variant;
    ++revisions_.surfaces;
    ++revisions_.lights;
  }
  facts_ = compute_facts(edited_scene(), variant);
  facts_variant_ = variant;
}

void SceneState::drop_lights() {
  if (!lights_listed_) return;
  lights_at_rest_ = std::exchange(lights_, std::nullopt);
  at_rest_listed_ = std::exchange(lights_listed_, std::nullopt);
}

void SceneState::list_lights() {
  if (lights_are_listed()) return;
  const bool rested = at_rest_listed_ == revisions_.lights;
  lights_ = rested ? std::exchange(lights_at_rest_, std::nullopt) : std::nullopt;
  lights_at_rest_.reset();
  at_rest_listed_.reset();
  lights_listed_ = revisions_.lights;
  if (rested) return;
  const LightList list = build_light_list(edited_scene(), geometry(), buffers_variant_);
  if (!list.lights.empty()) lights_.emplace(list);
}

void SceneState::recount_tables() {
  std::vector<bool> used(effective_.size() + 1, false);
  for (std::size_t i = 0; i < geometry().items.size(); ++i)
    if (buffers_->visible(i)) used[static_cast<std::size_t>(buffers_->material(i))] = true;
  count_tables(effective_, used, &facts_);
}

const Material& SceneState::material_of_item(std::size_t item) const {
  static const Material kDefault;
  const auto index = static_cast<std::size_t>(buffers_->material(item));
  return index < effective_.size() ? effective_[index] : kDefault;
}

bool SceneState::shows_both_sides(std::size_t item) const {
  return material_of_item(item).double_sided || geometry().items[item].patch >= 0;
}

bool SceneState::is_transparent(std::size_t item) const {
  const Material& m = material_of_item(item);
  return m.glass || m.alpha_mode == AlphaMode::blend;
}

std::vector<bool> SceneState::transmitting_items() const {
  std::vector<bool> transmits;
  for (std::size_t i = 0; i < geometry().items.size(); ++i)
    transmits.push_back(is_transparent(i) || !buffers_->visible(i) || is_cut_away(material_of_item(i)));
  return transmits;
}

std::vector<bool> SceneState::occluding_items() const {
  std::vector<bool> occluding = transmitting_items();
  occluding.flip();
  return occluding;
}

float SceneState::mean_alpha(std::size_t item) const {
  const Material& m = material_of_item(item);
  const DrawItem& drawn = geometry().items[item];
  double vertices = 0.0, texels = 0.0;
  for (std::uint32_t v = drawn.first_vertex; v < drawn.first_vertex + drawn.vertex_count; ++v)
    vertices += static_cast<double>(geometry().colors[v].a);
  double alpha = static_cast<double>(m.base_color.a) * vertices / std::max(drawn.vertex_count, 1u);
  if (!m.base_color_texture) return static_cast<float>(alpha);
  const TextureImage& image = scene_->images[static_cast<std::size_t>(m.base_color_texture.image)];
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) texels += image.rgba[i];
  return static_cast<float>(alpha * texels / (255.0 * std::max(image.width * image.height, 1)));
}

namespace {

/// Of the mean of its channels. Where alpha leaves a part open, the pane is one that reflects and absorbs as much less
/// at normal incidence: at glancing angles it is too dark.
Passage passage_of_pane(const Material& m, float share, float inside, float alpha) {
  const shared::PaneFaces faces = shared::pane_faces(m.ior, m.specular, m.specular_color);
  if (shared::is_plain(faces) && alpha >= 1.0f) return {share, faces.index.x, inside};
  const glm::vec3 reflected = shared::pane_shares(1.0f, faces, glm::vec3(1.0f)).reflected;
  const float both = alpha * (reflected.x + reflected.y + reflected.z) / 3.0f, open = 1.0f - alpha;
  const float passing = open + alpha * share;
  return {passing, shared::index_of_f0(both / (2.0f - both)),
          (open + alpha * share * inside) / std::max(passing, 1e-6f)};
}

}  // namespace

std::vector<Passage> SceneState::passages() const {
  std::vector<Passage> passages;
  for (std::size_t i = 0; i < geometry().items.size(); ++i) {
    const Material& m = material_of_item(i);
    const glm::vec3 color = glm::vec3(m.base_color) * glm::exp(-volume_absorption(m) * geometry().items[i].scale);
    const float inside = (color.r + color.g + color.b) / 3.0f;
    const float alpha = m.alpha_mode == AlphaMode::blend ? mean_alpha(i) : 1.0f;
    if (!buffers_->visible(i))
      passages.emplace_back();
    else if (const float share = pane_share(m); share > 0.0f)
      passages.push_back(passage_of_pane(m, share, std::clamp(inside, 0.0f, 1.0f), alpha));
    else
      passages.push_back({m.alpha_mode == AlphaMode::blend ? 1.0f - alpha : 1.0f, 1.0f, 1.0f});
  }
  return passages;
}

Scene SceneState::edited_scene() const {
  Scene edited = *scene_;
  edited.materials = effective_;
  for (std::size_t i = 0; i < geometry().items.size(); ++i) {
    const int node = geometry().items[i].node;
    if (node >= 0) edited.nodes[static_cast<std::size_t>(node)].visible = buffers_->visible(i);
  }
  return edited;
}

Bounds SceneState::bounds() const {
  Bounds all;
  for (std::size_t i = 0; i < geometry().items.size(); ++i) {
    all.min = glm::min(all.min, buffers_->bounds(i).min);
    all.max = glm::max(all.max, buffers_->bounds(i).max);
  }
  return all;
}

void SceneState::bind() const {
  buffers_->bind_materials();
  environment_->bind();
  if (materials_.count() > 0) materials_.bind();
  if (lights_) lights_->bind();
  buffers_->bind_geometry();
}

void SceneState::add_bytes(std::map<std::string, std::size_t>* bytes) const {
  (*bytes)["geometry"] = buffers_->geometry_bytes();
  if (buffers_->has_textures()) (*bytes)["textures"] = buffers_->texture_bytes();
  if (materials_.count() > 0) (*bytes)["materials"] = materials_.bytes();
  (*bytes)["environment"] = environment_->bytes();
  if (lights_) (*bytes)["lights"] = lights_->bytes();
  if (lights_at_rest_) (*bytes)["lights"] += lights_at_rest_->bytes();
}

}  // namespace maquette
