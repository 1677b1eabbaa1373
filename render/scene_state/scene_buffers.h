#pragma once

#include <array>
#include <string>
#include <vector>

#include "render/gl/objects.h"
#include "render/materials/texture_atlas.h"
#include "render/scene_state/geometry.h"
#include "scenes/scene.h"

namespace maquette {

/// GPU copy of a scene's geometry, materials and textures. material_table.glsl lists the textures that shaders read.
class SceneBuffers {
 public:
  explicit SceneBuffers(const Scene& scene);

  /// Writes the material records; `brdf_slots[i]` is the measured table of material i or -1, `brdf_shares[i]` its share
  /// of BRDF samples, `bandwidth_limits[i]` the table's largest bandwidth in cycles/rad, `table_swapped[i]` whether its
  /// table was exchanged. The last entry of each belongs to glTF's default material. Returns true when the G-buffer, or
  /// the set of drawn surfaces, is affected: exchanging a material's measured table does not count.
  bool update_materials(const std::vector<Material>& materials, const std::vector<int>& brdf_slots,
                        const std::vector<float>& brdf_shares, const std::vector<float>& bandwidth_limits,
                        const std::vector<bool>& table_swapped);
  void update_variant(const Scene& scene, int variant);
  /// Updates the positions and normals (node space) of primitive 0 of one mesh in all its instances.
  void update_mesh(const Scene& scene, int mesh, const std::vector<glm::vec3>& positions,
                   const std::vector<glm::vec3>& normals);

  /// The same triangles elsewhere; false, and nothing is changed, where they are not the same.
  bool move(const Scene& scene);

  const FlatGeometry& geometry() const { return geometry_; }
  /// World bounds of item i.
  const Bounds& bounds(std::size_t i) const { return bounds_[i]; }
  /// Material of item i under the current variant; materials.size() for the default one.
  int material(std::size_t i) const { return item_materials_[i]; }
  /// Of a texture that an item's material has: its index in the atlas, -1: none.
  int texture(std::size_t item, TextureRole role) const {
    const auto material = static_cast<std::size_t>(item_materials_[item]);
    return material < textures_.size() ? textures_[material][static_cast<std::size_t>(role)] : -1;
  }
  /// Items with this flag off are not drawn.
  bool visible(std::size_t i) const { return visible_[i]; }
  void set_node_visible(int node, bool visible);
  /// Of the base colour texture of a material that has one.
  void set_texture_offset(std::size_t material, const glm::vec2& offset);

  GLuint vertex_array() const { return vertex_array_.get(); }
  GLuint indices() const { return indices_.get(); }
  void bind_geometry() const;   ///< units 4, 5, 6, 7
  void bind_materials() const;  ///< units 1, 2, 3
  bool has_textures() const { return static_cast<bool>(texel_view_); }
  bool has_colors() const { return has_colors_; }  ///< some vertex colour is not white
  std::size_t geometry_bytes() const;
  std::size_t texture_bytes() const { return texels_.bytes() + texture_records_.bytes(); }
  const Texture& texture_bandwidth() const { return texture_bandwidth_view_; }

 private:
  void build_geometry();
  void build_textures(const Scene& scene);
  void upload_vertices(std::uint32_t first, std::uint32_t count);

  FlatGeometry geometry_;
  std::vector<Bounds> bounds_;
  std::vector<int> item_materials_;
  std::vector<bool> visible_;
  bool has_colors_ = false;
  std::vector<glm::uvec4> surface_words_;  ///< the part of the material records that the G-buffer depends on
  GlName<VertexArrayTraits> vertex_array_;
  Buffer positions_, uvs_, indices_, vertices_, triangle_materials_, materials_, texels_, texture_records_,
      texture_bandwidth_;
  Texture index_view_, vertex_view_, triangle_material_view_, material_view_, texel_view_, texture_record_view_,
      texture_bandwidth_view_;
  std::vector<std::array<int, kTextureRoles>> textures_;  ///< TextureAtlas::of_material
};

}  // namespace maquette
