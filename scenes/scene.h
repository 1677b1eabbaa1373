#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/animation.h"

namespace maquette {

/// Texture image, row 0 on top, always RGBA: 4 codes a texel.
struct TextureImage {
  std::string name;
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
  std::vector<std::uint16_t> rgba16{};  ///< the same in 16 bits, of images that have them; else empty
};

enum class Wrap { repeat, mirrored_repeat, clamp_to_edge };

/// One use of an image: UV set, KHR_texture_transform and sampler. `image` < 0: no texture.
struct TextureRef {
  int image = -1;
  int uv_set = 0;
  glm::vec2 offset{0.0f};
  glm::vec2 scale{1.0f};
  float rotation_rad = 0.0f;
  Wrap wrap_s = Wrap::repeat;
  Wrap wrap_t = Wrap::repeat;
  bool nearest = false;
  explicit operator bool() const { return image >= 0; }
};

enum class AlphaMode { opaque, mask, blend };

/// glTF 2.0 metallic-roughness material with the supported extensions (see docs/formats.md).
/// Colours are linear. When `measured` is set, a tabulated BRDF replaces the analytic lobes.
/// A new member also belongs to `numbers_of` and, where cells of the octree show it, to render/octree/cell_brdf.cpp.
struct Material {
  std::string name;
  glm::vec4 base_color{1.0f};
  float metallic = 1.0f;
  float roughness = 1.0f;
  glm::vec3 emissive{0.0f};  ///< factor times KHR_materials_emissive_strength, cd/m2 per channel
  float normal_scale = 1.0f;
  float occlusion_strength = 1.0f;
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;
  bool unlit = false;
  float clearcoat = 0.0f;
  float clearcoat_roughness = 0.0f;
  float transmission = 0.0f;
  float ior = 1.5f;
  /// Above 0 (KHR_materials_volume, m) a transmissive surface bounds a closed solid: mode reference refracts in it, the
  /// other modes treat its faces as panes. attenuation_color is the transmittance over attenuation_distance (m).
  float thickness = 0.0f;
  glm::vec3 attenuation_color{1.0f};
  float attenuation_distance = std::numeric_limits<float>::infinity();
  float specular = 1.0f;
  glm::vec3 specular_color{1.0f};
  glm::vec3 sheen_color{0.0f};
  float sheen_roughness = 0.0f;
  float clearcoat_normal_scale = 1.0f;
  float anisotropy = 0.0f;               ///< strength
  float anisotropy_rotation_rad = 0.0f;  ///< from the tangent, counter-clockwise
  float iridescence = 0.0f;
  float iridescence_ior = 1.3f;
  float iridescence_least_nm = 100.0f, iridescence_greatest_nm = 400.0f;  ///< thickness of the film

  TextureRef base_color_texture;          ///< sRGB, alpha linear
  TextureRef metallic_roughness_texture;  ///< G roughness, B metallic
  TextureRef normal_texture;
  TextureRef occlusion_texture;  ///< R
  TextureRef emissive_texture;   ///< sRGB
  TextureRef clearcoat_texture, clearcoat_roughness_texture, clearcoat_normal_texture;
  TextureRef transmission_texture, specular_texture, specular_color_texture;
  TextureRef sheen_color_texture, sheen_roughness_texture;
  TextureRef anisotropy_texture;                                  ///< RG direction, B strength
  TextureRef iridescence_texture, iridescence_thickness_texture;  ///< R, G
  TextureRef thickness_texture;                                   ///< G

  /// Source of a tabulated BRDF: a MERL .binary path or `builtin:NAME`; empty for analytic shading.
  /// From the command line (--material) or `extras.maquette.measured` of the file.
  /// base_color and base_color_texture then tint the table only if `tint_measured` is set.
  std::string measured;
  bool tint_measured = false;
  /// Glass (`builtin:glass`, or transmission > 0), a thin pane unless `thickness` is set: transmits light and does not
  /// occlude in the direct modes.
  bool glass = false;
};

/// Its textures: first those of the G-buffer, in the order of kRole... in shaders/shared/material_table.glsl.
inline constexpr std::array kMaterialTextures = {&Material::base_color_texture,
                                                 &Material::metallic_roughness_texture,
                                                 &Material::normal_texture,
                                                 &Material::emissive_texture,
                                                 &Material::occlusion_texture,
                                                 &Material::clearcoat_texture,
                                                 &Material::clearcoat_roughness_texture,
                                                 &Material::clearcoat_normal_texture,
                                                 &Material::transmission_texture,
                                                 &Material::specular_texture,
                                                 &Material::specular_color_texture,
                                                 &Material::sheen_color_texture,
                                                 &Material::sheen_roughness_texture,
                                                 &Material::anisotropy_texture,
                                                 &Material::iridescence_texture,
                                                 &Material::iridescence_thickness_texture,
                                                 &Material::thickness_texture};
/// Glass unless the file says otherwise: it transmits, and is not all metal. Source: KHR_materials_transmission.
bool may_transmit(const Material& material);
/// All members of a material that are numbers or flags, textures included, for hashes of content.
std::vector<float> numbers_of(const Material& material);

/// Indexed triangles of one material. All attribute arrays have the length of `positions` or are empty.
struct Primitive {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;
  std::vector<glm::vec4> tangents;  ///< w: handedness
  std::array<std::vector<glm::vec2>, 2> uvs;
  std::vector<glm::vec4> colors;
  std::vector<std::uint32_t> indices;    ///< three per triangle, always present after import
  int material = -1;                     ///< -1: glTF's default material
  std::map<int, int> variant_materials;  ///< variant index -> material index (KHR_materials_variants)
};

/// Catmull-Clark control cage (from `extras.maquette.subdivision` of a mesh): faces of 3 or more corners.
struct SubdivisionCage {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec2> uvs;  ///< per vertex, may be empty
  std::vector<int> face_sizes;
  std::vector<int> face_indices;
  std::vector<std::array<int, 2>> crease_edges;
  std::vector<float> crease_sharpness;  ///< one per crease edge; 10 is infinitely sharp
  int levels = 2;                       ///< uniform refinement before limit evaluation
};

struct Mesh {
  std::string name;
  std::vector<Primitive> primitives;
  /// When set, primitives[0] is its limit surface (positions, exact limit normals), computed again after edits of the
  /// cage.
  std::shared_ptr<const SubdivisionCage> cage;
};

/// Bicubic Bezier patch, control point [row v][column u] = points[4 * row + column], metres in node space.
struct BezierPatch {
  std::string name;
  std::array<glm::vec3, 16> points{};
  int material = -1;
  bool reflector = true;
};

struct Camera {
  std::string name;
  float fov_y_rad = 0.8f;
  float near_m = 0.01f;
  float far_m = 1000.0f;  ///< may be infinite
  float aspect = 0.0f;    ///< width over height of the picture that it was framed for; 0: any
  float height_m = 0.0f;  ///< of what an orthographic camera shows; 0: perspective
};

struct PunctualLight {
  enum class Kind { directional, point, spot };
  std::string name;
  Kind kind = Kind::point;
  glm::vec3 color{1.0f};
  float intensity = 1.0f;  ///< lux (directional) or candela (point, spot)
  float range_m = 0.0f;    ///< 0: infinite
  float inner_cone_rad = 0.0f;
  float outer_cone_rad = 0.785398f;
};

struct Node {
  std::string name;
  int parent = -1;
  std::vector<int> children;
  glm::mat4 local{1.0f};  ///< parent_from_node
  int mesh = -1;
  int patch = -1;
  int camera = -1;
  int light = -1;
  bool reflector = false;  ///< `extras.maquette.reflector`
  bool visible = true;
};

/// The contents of a scene file or a built-in scene: values only, no OpenGL. Indices refer to the vectors here.
struct Scene {
  std::string name;  ///< path or builtin:NAME
  std::vector<Node> nodes;
  std::vector<int> roots;
  std::vector<Mesh> meshes;
  std::vector<BezierPatch> patches;
  std::vector<Material> materials;
  std::vector<TextureImage> images;
  std::vector<Camera> cameras;
  std::vector<PunctualLight> lights;
  std::vector<std::string> variants;
  std::vector<Animation> animations;
  std::vector<std::string> warnings;  ///< one line per unsupported feature of the file
};

struct Bounds {
  glm::vec3 min{1e30f};
  glm::vec3 max{-1e30f};
  bool empty() const { return min.x > max.x; }
  glm::vec3 center() const { return 0.5f * (min + max); }
  float radius() const { return empty() ? 0.0f : 0.5f * glm::length(max - min); }
};

/// world_from_node of every node, in the order of `scene.nodes`.
std::vector<glm::mat4> compute_world_transforms(const Scene& scene);
/// World bounds of all visible meshes and patches.
Bounds compute_bounds(const Scene& scene);
/// Number of triangles that are drawn.
std::size_t count_triangles(const Scene& scene);
/// Material index of a primitive under a variant (-1: the file's default assignment).
int material_of(const Primitive& primitive, int variant);

/// Loads .gltf, .glb, or `builtin:cockpit|sphere|plate|cornell|seat`. `scene`: name or index of one of the file's
/// scenes; empty for its default. Throws Error, UsageError for a scene that is not there.
Scene load_scene(const std::string& source, const std::string& scene = {});
/// .gltf or .glb through tinygltf, Draco included. Throws Error naming file, element and fault.
Scene load_gltf(const std::string& path, const std::string& scene = {});
/// Writes meshes, cages, patches, materials, cameras, lights and variants so that load_gltf gives the same scene.
void save_glb(const std::string& path, const Scene& scene);
/// `name` without the prefix: cockpit, sphere, plate, cornell, seat. Throws UsageError listing the names.
Scene build_builtin_scene(const std::string& name);

}  // namespace maquette
