#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/environment/environment_buffers.h"
#include "render/lights/light_buffers.h"
#include "render/materials/material_store.h"
#include "render/scene_state/facts.h"
#include "render/scene_state/revisions.h"
#include "render/scene_state/scene_buffers.h"
#include "render/visibility/visibility_bake.h"

namespace maquette {

/// Scene, materials, environment and lights as they are drawn, edits included, on the GPU and as values, with a
/// revision of each thing that results depend on.
class SceneState {
 public:
  void set_scene(std::shared_ptr<const Scene> scene);
  void set_environment(std::shared_ptr<const Environment> environment);
  /// See Renderer::set_material.
  void set_material(const std::string& material_name, const std::string& source);
  void update_mesh(int mesh, const std::vector<glm::vec3>& positions, const std::vector<glm::vec3>& normals);
  void set_node_visible(int node, bool visible);
  /// See Renderer::move_nodes.
  bool move_nodes(std::shared_ptr<const Scene> scene);
  /// See Renderer::set_texture_offset.
  void set_texture_offset(const std::string& material_name, const glm::vec2& offset);

  /// Brings variant and facts up to date.
  void update(int variant);
  /// Lists the lights anew if they have changed since.
  void list_lights();
  bool lights_are_listed() const { return lights_listed_ == revisions_.lights; }
  void drop_lights();  ///< they are kept for when they are listed again

  /// Throws Error when there is no scene.
  void require_scene() const;
  const Scene& scene() const { return *scene_; }
  const SceneFacts& facts() const { return facts_; }
  const Revisions& revisions() const { return revisions_; }
  SceneBuffers& buffers() { return *buffers_; }
  const SceneBuffers& buffers() const { return *buffers_; }
  const FlatGeometry& geometry() const { return buffers_->geometry(); }
  MaterialStore& materials() { return materials_; }
  const MaterialStore& materials() const { return materials_; }
  bool has_environment() const { return environment_.has_value(); }
  EnvironmentBuffers& environment() { return *environment_; }
  const EnvironmentBuffers& environment() const { return *environment_; }
  /// Null when nothing that shines is bright enough to be sampled.
  const LightBuffers* lights() const { return lights_ ? &*lights_ : nullptr; }

  /// The scene's materials with the overrides.
  const std::vector<Material>& effective_materials() const { return effective_; }
  /// BRDF slot of each effective material and of the default one; -1 for those without a measured table.
  const std::vector<int>& slots() const { return slots_; }
  const Material& material_of_item(std::size_t item) const;
  bool shows_both_sides(std::size_t item) const;
  /// Drawn with blending, not as an opaque surface.
  bool is_transparent(std::size_t item) const;
  /// [item] rays pass it: glass, blended or hidden.
  std::vector<bool> transmitting_items() const;
  /// [item] the opposite.
  std::vector<bool> occluding_items() const;
  /// Of an item: factor times the means over its texture and its vertices.
  float mean_alpha(std::size_t item) const;
  std::vector<Passage> passages() const;  ///< [item], as far as it transmits
  Scene edited_scene() const;             ///< with the effective materials and hidden nodes
  Bounds bounds() const;                  ///< of all items

  /// Whether a material took another measured table since they were last marked as drawn.
  bool tables_swapped() const;
  void mark_tables_drawn();

  /// Binds what shaders read of all this (shaders/shared/bindings.glsl).
  void bind() const;
  void add_bytes(std::map<std::string, std::size_t>* bytes) const;

 private:
  void find_effective_materials();
  void upload_materials();
  /// All of the facts that changes when a material takes another measured table.
  void recount_tables();

  static constexpr int kNone = -2;  ///< of variants

  std::shared_ptr<const Scene> scene_;
  std::optional<SceneBuffers> buffers_;
  MaterialStore materials_;
  std::map<std::string, std::string> overrides_;      ///< material name (or `*`) -> source
  std::map<std::string, glm::vec2> texture_offsets_;  ///< material name -> of its base colour texture
  std::vector<Material> effective_;
  std::vector<int> slots_;
  std::vector<bool> swapped_;  ///< [material] another measured table since the frame before
  std::optional<EnvironmentBuffers> environment_;
  std::optional<LightBuffers> lights_;
  std::optional<std::uint32_t> lights_listed_;  ///< revision that `lights_` is of
  std::optional<LightBuffers> lights_at_rest_;
  std::optional<std::uint32_t> at_rest_listed_;  ///< revision that `lights_at_rest_` is of
  Revisions revisions_;
  SceneFacts facts_;
  int facts_variant_ = kNone;
  int buffers_variant_ = -1;
};

}  // namespace maquette
