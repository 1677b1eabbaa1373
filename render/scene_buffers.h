#pragma once

#include <array>
#include <string>
#include <vector>

#include "render/geometry.h"
#include "render/gl/objects.h"
#include "render/texture_atlas.h"
#include "scenes/scene.h"

namespace maquette {

/// GPU copy of a scene's geometry, materials and textures. Textures of what the shaders read are listed in
/// material_table.glsl.
class SceneBuffers {
 public:
  explicit SceneBuffers(const Scene& scene);

  /// Writes the material records; `brdf_slots[i]` is the measured table of material i or -1, `brdf_shares[i]` its share
  /// of BRDF samples, `bandwidth_limits[i]` the table's largest bandwidth in cycles/rad. The last entry of each stands
  /// for glTF's default material. True when something changed that the G-buffer holds or that decides what is drawn
  /// into it: another measured table for a material does not.
  bool update_materials(const std::vector<Material>& materials, const std::vector<int>& brdf_slots,
                        const std::vector<float>& brdf_shares, const std::vector<float>& bandwidth_limits,
                        const std::vector<bool>& repainted);
  void update_variant(const Scene& scene, int variant);
  /// New positions and normals (node space) of one mesh's primitive 0 in all its instances.
  void update_mesh(const Scene& scene, int mesh, const std::vector<glm::vec3>& positions,
                   const std::vector<glm::vec3>& normals);

  const FlatGeometry& geometry() const { return geometry_; }
  /// World bounds of item i.
  const Bounds& bounds(std::size_t i) const { return bounds_[i]; }
  /// Material of item i under the current variant; materials.size() for the default one.
  int material(std::size_t i) const { return item_materials_[i]; }
  /// Index of the base colour's texture of a material in the texture records, or -1.
  int base_color_texture(std::size_t material) const {
    return material < base_color_textures_.size() ? base_color_textures_[material] : -1;
  }
  /// Items with this flag off are not drawn.
  bool visible(std::size_t i) const { return visible_[i]; }
  void set_node_visible(int node, bool visible);

  GLuint vertex_array() const { return vertex_array_.get(); }
  GLuint indices() const { return indices_.get(); }
  void bind_geometry() const;   ///< units 4, 5, 6
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
  std::vector<int> base_color_textures_;
  std::vector<glm::uvec4> surface_words_;  ///< what the G-buffer depends on in the material records
  GlName<VertexArrayTraits> vertex_array_;
  Buffer positions_, uvs_, indices_, vertices_, triangle_materials_, materials_, texels_, texture_records_,
      texture_bandwidth_;
  Texture index_view_, vertex_view_, triangle_material_view_, material_view_, texel_view_, texture_record_view_,
      texture_bandwidth_view_;
  std::vector<std::array<int, kTextureRoles>> textures_;  ///< TextureAtlas::of_material
};

}  // namespace maquette
