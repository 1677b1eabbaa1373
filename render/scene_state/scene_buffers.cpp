#include "render/scene_state/scene_buffers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include "render/gl/bindings.h"
#include "render/materials/texture_atlas.h"
#include "render/materials/texture_bandwidth.h"
#include "render/scene_state/geometry_edit.h"
#include "render/scene_state/material_overrides.h"

namespace maquette {

namespace {

constexpr std::size_t kVertexTexels = 4;
/// Of a material's record (shaders/shared/material_table.glsl), and which of them has the flags.
constexpr std::ptrdiff_t kMaterialTexels = 13, kFlagsTexel = 6;
/// Roles that the G-buffer reads: all but the last.
constexpr std::size_t kSurfaceTextures = kTextureRoles - 1;

/// Whether a material with a measured table still reads a texture.
bool is_read_with_table(const Material& m, TextureRole role) {
  return role == TextureRole::normal || role == TextureRole::emissive || role == TextureRole::occlusion ||
         (role == TextureRole::base_color && m.tint_measured);
}

/// Linear colours as four half floats, in two texel components: 8 bits would be too coarse for dark ones.
glm::vec2 pack_color(const glm::vec4& c) {
  return {std::bit_cast<float>(glm::packHalf2x16({c.r, c.g})), std::bit_cast<float>(glm::packHalf2x16({c.b, c.a}))};
}

GLuint make_vertex_array(const Buffer& positions, const Buffer& uvs, const Buffer& indices) {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  glVertexArrayVertexBuffer(name, 0, positions.get(), 0, sizeof(glm::vec3));
  glVertexArrayVertexBuffer(name, 1, uvs.get(), 0, sizeof(glm::vec2));
  glEnableVertexArrayAttrib(name, 0);
  glVertexArrayAttribFormat(name, 0, 3, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(name, 0, 0);
  glEnableVertexArrayAttrib(name, 1);
  glVertexArrayAttribFormat(name, 1, 2, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(name, 1, 1);
  glVertexArrayElementBuffer(name, indices.get());
  return name;
}

Bounds item_bounds(const FlatGeometry& geometry, const DrawItem& item) {
  Bounds bounds;
  for (std::uint32_t v = item.first_vertex; v < item.first_vertex + item.vertex_count; ++v) {
    bounds.min = glm::min(bounds.min, geometry.positions[v]);
    bounds.max = glm::max(bounds.max, geometry.positions[v]);
  }
  return bounds;
}

}  // namespace

SceneBuffers::SceneBuffers(const Scene& scene) : geometry_(flatten(scene)) {
  build_geometry();
  update_variant(scene, -1);
  build_textures(scene);
}

void SceneBuffers::build_geometry() {
  const std::size_t count = geometry_.positions.size();
  positions_ = Buffer::from("positions", geometry_.positions);
  uvs_ = Buffer::from("uv0", geometry_.uv0);
  indices_ = Buffer::from("indices", geometry_.indices);
  vertices_ = Buffer("vertices", count * kVertexTexels * sizeof(glm::vec4));
  upload_vertices(0, static_cast<std::uint32_t>(count));
  index_view_ = Texture::make_buffer("indices", GL_R32UI, indices_);
  vertex_view_ = Texture::make_buffer("vertices", GL_RGBA32F, vertices_);
  vertex_array_ = GlName<VertexArrayTraits>(make_vertex_array(positions_, uvs_, indices_));
  bounds_.clear();
  for (const DrawItem& item : geometry_.items) bounds_.push_back(item_bounds(geometry_, item));
  visible_.assign(geometry_.items.size(), true);
  has_colors_ = std::any_of(geometry_.colors.begin(), geometry_.colors.end(),
                            [](const glm::vec4& c) { return c != glm::vec4(1.0f); });
}

void SceneBuffers::upload_vertices(std::uint32_t first, std::uint32_t count) {
  std::vector<glm::vec4> texels(static_cast<std::size_t>(count) * kVertexTexels);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t v = first + i;
    texels[4 * i] = glm::vec4(geometry_.positions[v], geometry_.uv0[v].x);
    texels[4 * i + 1] = glm::vec4(geometry_.normals[v], geometry_.uv0[v].y);
    texels[4 * i + 2] = geometry_.tangents[v];
    texels[4 * i + 3] = glm::vec4(geometry_.uv1[v], pack_color(geometry_.colors[v]));
  }
  vertices_.update(static_cast<std::size_t>(first) * kVertexTexels * sizeof(glm::vec4),
                   texels.size() * sizeof(glm::vec4), texels.data());
}

void SceneBuffers::update_variant(const Scene& scene, int variant) {
  const int default_material = static_cast<int>(scene.materials.size());
  item_materials_.clear();
  std::vector<std::uint16_t> triangles(geometry_.indices.size() / 3);
  for (const DrawItem& item : geometry_.items) {
    int material = item.patch >= 0 ? scene.patches[static_cast<std::size_t>(item.patch)].material
                                   : material_of(scene.meshes[static_cast<std::size_t>(item.mesh)]
                                                     .primitives[static_cast<std::size_t>(item.primitive)],
                                                 variant);
    if (material < 0 || material > default_material) material = default_material;
    item_materials_.push_back(material);
    std::fill_n(triangles.begin() + item.first_index / 3, item.index_count / 3, static_cast<std::uint16_t>(material));
  }
  triangle_materials_ = Buffer::from("triangle materials", triangles);
  triangle_material_view_ = Texture::make_buffer("triangle materials", GL_R16UI, triangle_materials_);
}

void SceneBuffers::build_textures(const Scene& scene) {
  const TextureAtlas atlas = build_texture_atlas(scene);
  textures_ = atlas.of_material;
  if (atlas.records.empty()) return;
  std::vector<float> bandwidth;
  // Several roles may read one texture.
  struct Read {
    bool color = false;
    unsigned channels = 0;
    auto operator<=>(const Read&) const = default;
  };
  std::vector<Read> reads(atlas.images.size());
  for (const auto& roles : atlas.of_material)
    for (std::size_t k = 0; k < kTextureRoles; ++k) {
      if (roles[k] < 0) continue;
      const unsigned channels = data_channels(static_cast<TextureRole>(k));
      reads[static_cast<std::size_t>(roles[k])].channels |= channels;
      reads[static_cast<std::size_t>(roles[k])].color |= channels == 0;
    }
  std::map<std::pair<int, Read>, std::vector<float>> maps;
  for (std::size_t i = 0; i < reads.size(); ++i) {
    const auto [known, added] = maps.try_emplace({atlas.images[i], reads[i]});
    if (added) {
      const TextureImage& image = scene.images[static_cast<std::size_t>(atlas.images[i])];
      known->second = compute_data_bandwidth(image, reads[i].channels);
      if (reads[i].color) {
        const std::vector<float> color = compute_texture_bandwidth(image);
        for (std::size_t r = 0; r < color.size(); ++r) known->second[r] = std::max(known->second[r], color[r]);
      }
    }
    bandwidth.insert(bandwidth.end(), known->second.begin(), known->second.end());
  }
  texels_ = Buffer::from("texels", atlas.texels);
  texel_view_ = Texture::make_buffer("texels", GL_RG32UI, texels_);
  texture_records_ = Buffer::from("texture records", atlas.records);
  texture_record_view_ = Texture::make_buffer("texture records", GL_RGBA32F, texture_records_);
  texture_bandwidth_ = Buffer::from("texture bandwidth", bandwidth);
  texture_bandwidth_view_ = Texture::make_buffer("texture bandwidth", GL_R32F, texture_bandwidth_);
}

void SceneBuffers::set_texture_offset(std::size_t material, const glm::vec2& offset) {
  if (material >= textures_.size()) return;
  const int texture = textures_[material][static_cast<std::size_t>(TextureRole::base_color)];
  if (texture < 0) return;
  constexpr std::size_t kRecordTexels = 3, kOffsetTexel = 2;
  texture_records_.update((kRecordTexels * static_cast<std::size_t>(texture) + kOffsetTexel) * sizeof(glm::vec4),
                          sizeof offset, &offset);
}

bool SceneBuffers::update_materials(const std::vector<Material>& materials, const std::vector<int>& brdf_slots,
                                    const std::vector<float>& brdf_shares, const std::vector<float>& bandwidth_limits,
                                    const std::vector<bool>& table_swapped) {
  constexpr std::uint32_t kNone = 0xffffffffu;
  std::vector<glm::uvec4> words, surface_words;
  const auto bits = [](float x, float y, float z, float w) {
    return glm::uvec4(std::bit_cast<std::uint32_t>(x), std::bit_cast<std::uint32_t>(y), std::bit_cast<std::uint32_t>(z),
                      std::bit_cast<std::uint32_t>(w));
  };
  const Material default_material;
  for (std::size_t i = 0; i <= materials.size(); ++i) {
    const Material& m = i < materials.size() ? materials[i] : default_material;
    // `builtin:glass` may have removed a material's own textures.
    std::array<std::uint32_t, kTextureRoles> textures;
    textures.fill(kNone);
    for (std::size_t k = 0; k < kTextureRoles && i < textures_.size(); ++k)
      if (texture_of(m, static_cast<TextureRole>(k))) textures[k] = static_cast<std::uint32_t>(textures_[i][k]);
    const int slot = brdf_slots[i];
    std::array<std::uint32_t, kSurfaceTextures> list;
    list.fill(kNone);
    std::size_t used = 0;
    for (std::uint32_t role = 0; role < kSurfaceTextures; ++role)
      if (textures[role] != kNone && (slot < 0 || is_read_with_table(m, static_cast<TextureRole>(role))))
        list[used++] = textures[role] | role << 16;
    const std::uint32_t flags = (slot >= 0 ? 1u : 0u) | (slot >= 0 && m.tint_measured ? 2u : 0u) | (m.unlit ? 4u : 0u) |
                                (m.double_sided ? 8u : 0u) | (table_swapped[i] ? 16u : 0u);
    words.push_back(bits(m.base_color.r, m.base_color.g, m.base_color.b, m.alpha_cutoff));
    words.push_back(bits(m.metallic, m.roughness, m.normal_scale, m.occlusion_strength));
    words.push_back(bits(m.emissive.r, m.emissive.g, m.emissive.b, m.ior));
    words.push_back(bits(m.clearcoat, m.clearcoat_roughness, m.specular, m.transmission));
    words.push_back(bits(m.specular_color.r, m.specular_color.g, m.specular_color.b, m.sheen_roughness));
    words.push_back(bits(m.sheen_color.r, m.sheen_color.g, m.sheen_color.b, m.anisotropy));
    words.emplace_back(flags | glm::packHalf2x16({0.0f, bandwidth_limits[i]}),
                       static_cast<std::uint32_t>(std::max(slot, 0)), std::bit_cast<std::uint32_t>(brdf_shares[i]),
                       std::bit_cast<std::uint32_t>(m.anisotropy_rotation_rad));
    words.push_back(bits(m.iridescence, m.iridescence_ior, m.iridescence_least_nm, m.iridescence_greatest_nm));
    words.push_back(bits(m.clearcoat_normal_scale, has_own_coat_tangents(m) ? 1.0f : 0.0f, 0.0f, 0.0f));
    for (std::size_t k = 0; k < kSurfaceTextures; k += 4)
      words.emplace_back(list[k], list[k + 1], list[k + 2], list[k + 3]);
    // The whole record except the measured table, and what the raster reads from the material itself.
    surface_words.insert(surface_words.end(), words.end() - kMaterialTexels, words.end());
    glm::uvec4& of_table = surface_words.end()[kFlagsTexel - kMaterialTexels];
    of_table = glm::uvec4(flags & ~(1u | 16u), 0u, 0u, of_table.w);
    surface_words.emplace_back(static_cast<std::uint32_t>(m.alpha_mode), m.glass ? 1u : 0u,
                               std::bit_cast<std::uint32_t>(m.base_color.a), textures[0]);
  }
  materials_ = Buffer::from("materials", words);
  material_view_ = Texture::make_buffer("materials", GL_RGBA32UI, materials_);
  const bool changed = surface_words != surface_words_;
  surface_words_ = std::move(surface_words);
  return changed;
}

void SceneBuffers::update_mesh(const Scene& scene, int mesh, const std::vector<glm::vec3>& positions,
                               const std::vector<glm::vec3>& normals) {
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  Primitive moved = scene.meshes[static_cast<std::size_t>(mesh)].primitives[0];
  moved.positions = positions;
  moved.normals = normals;
  for (std::size_t i = 0; i < geometry_.items.size(); ++i) {
    const DrawItem& item = geometry_.items[i];
    if (item.mesh != mesh || item.primitive != 0) continue;
    write_item(scene, moved, world[static_cast<std::size_t>(item.node)], item, &geometry_);
    positions_.update(item.first_vertex * sizeof(glm::vec3), item.vertex_count * sizeof(glm::vec3),
                      &geometry_.positions[item.first_vertex]);
    upload_vertices(item.first_vertex, item.vertex_count);
    bounds_[i] = item_bounds(geometry_, item);
  }
}

bool SceneBuffers::move(const Scene& scene) {
  FlatGeometry moved = flatten(scene);
  const auto same = [](const DrawItem& a, const DrawItem& b) {
    return a.node == b.node && a.mesh == b.mesh && a.primitive == b.primitive && a.patch == b.patch &&
           a.index_count == b.index_count && a.vertex_count == b.vertex_count;
  };
  if (!std::ranges::equal(moved.items, geometry_.items, same)) return false;
  const std::vector<bool> visible = visible_;
  geometry_ = std::move(moved);
  build_geometry();
  visible_ = visible;
  return true;
}

void SceneBuffers::set_node_visible(int node, bool visible) {
  for (std::size_t i = 0; i < geometry_.items.size(); ++i)
    if (geometry_.items[i].node == node) visible_[i] = visible;
}

void SceneBuffers::bind_geometry() const {
  glBindTextureUnit(kUnitIndices, index_view_.get());
  glBindTextureUnit(kUnitVertices, vertex_view_.get());
  glBindTextureUnit(kUnitTriangleMaterial, triangle_material_view_.get());
  if (texture_bandwidth_view_) glBindTextureUnit(kUnitTextureBandwidth, texture_bandwidth_view_.get());
}

void SceneBuffers::bind_materials() const {
  glBindTextureUnit(kUnitMaterials, material_view_.get());
  if (texel_view_) {
    glBindTextureUnit(kUnitTexels, texel_view_.get());
    glBindTextureUnit(kUnitTextureRecords, texture_record_view_.get());
  }
}

std::size_t SceneBuffers::geometry_bytes() const {
  return positions_.bytes() + uvs_.bytes() + indices_.bytes() + vertices_.bytes() + triangle_materials_.bytes();
}

}  // namespace maquette
