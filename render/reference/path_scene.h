#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <functional>
#include <type_traits>

#include "render/environment/environment_tables.h"
#include "render/lights/light_grid.h"
#include "render/materials/brdf_sampler.h"
#include "render/materials/brdf_tables.h"
#include "render/materials/texture_atlas.h"
#include "render/math/shared_formulas.h"
#include "render/reference/light_guide.h"
#include "render/reference/packed_brdf.h"
#include "render/reference/reference.h"
#include "scenes/btf/btf.h"

namespace maquette {

namespace shared {

/// Textures of an atlas, filtered by the shaders' own code (sample_texture, texture_coordinates, texture_transformed).
struct TextureFilter {
  const TextureAtlas& atlas;
  uvec2 fetch_texel_words(int index) const { return atlas.texels.data()[index]; }
  vec4 texture_record(int texture, int row) const { return atlas.records.data()[3 * texture + row]; }
#include "shared/texture_filter.glsl"
};

}  // namespace shared

/// A measured BRDF with the tables for sampling it; or a BTF, without them.
struct MeasuredMaterial {
  std::shared_ptr<const Btf> btf;  ///< null: a BRDF
  PackedBrdf values;
  BrdfTables tables;
};

struct TracedMaterial {
  Material values;
  std::array<int, kTextureRoles> textures{};  ///< in the atlas, -1: none
  bool textured = false;                      ///< any of them
  bool colored = false;                       ///< vertex colours other than 1
  std::shared_ptr<const MeasuredMaterial> measured;
  std::shared_ptr<const Btf> btf;
  /// Reflects by tables, not by the lobes of an analytic material.
  bool tabulated() const { return measured || btf; }
  float pane = 0.0f;           ///< share that is glass: a thin pane unless it refracts
  bool solid = false;          ///< glass with a volume: refracts
  bool rough = false;          ///< glass that scatters
  glm::vec3 absorption{0.0f};  ///< 1/m, of the volume
  /// Glass that straight rays do not cross: shadow rays end there, paths are refracted.
  bool refracts() const { return solid || rough; }
  /// Share that straight rays cross.
  float clear() const { return refracts() ? 0.0f : pane; }
  bool masked = false;             ///< cut out by alpha
  bool blended = false;            ///< covers by alpha
  bool own_coat_tangents = false;  ///< where the file has none (has_own_coat_tangents)
  int texture(TextureRole role) const { return textures[static_cast<std::size_t>(role)]; }
};

struct EnvironmentLookup {
  glm::vec3 radiance{};  ///< stored units, bilinear
  int x, y;              ///< texel whose cell contains the direction
};

/// The environment in its own frame (rotation undone), stored units.
struct TracedEnvironment {
  std::shared_ptr<const Environment> source;
  EnvironmentTables tables;
  bool black = true;
  std::vector<glm::vec4> texels;  ///< [height][width] radiance, mean density over the texel's cell (1/sr)
  std::vector<bool> bright;       ///< [height][width] cells that are sampled by their bilinear radiance
  std::unique_ptr<const EnvironmentPartition> partition;
  EnvironmentLookup look_up(const glm::vec3& direction) const;
  /// Density (1/sr) of plain importance sampling for a direction in the cell of a texel.
  float density_at(std::size_t texel, const glm::vec3& direction) const;
  /// Moves a point of the map that was drawn by the tables within its cell, by the bilinear radiance there.
  EnvironmentPoint follow_light(const EnvironmentPoint& point) const;
};

/// A ray as it was given to the ray tracer.
struct LoggedRay {
  glm::vec3 origin{}, direction{};
  float near, far;
  bool shadow;  ///< any hit ends it
};

struct EmbreeRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

/// What a hit needs of its triangle, in two cache lines; a pane on the way of a ray needs only the first.
struct alignas(64) TracedTriangle {
  std::array<glm::vec3, 3> normals{};
  glm::vec3 geometric{};   ///< unit normal by winding
  std::uint32_t material;  ///< material index and the flag kBothSides
  std::uint32_t source;    ///< index of the triangle in the geometry
  std::array<glm::vec3, 3> positions{};
};

/// Flag in TracedTriangle::material: camera rays see the back face too.
inline constexpr std::uint32_t kBothSides = 0x80000000u;

struct PathScene {
  FlatGeometry geometry;
  Bounds bounds;
  std::vector<TracedMaterial> materials;  ///< the last one is glTF's default
  /// In the order of the ray tracer's meshes: kOpaque stops every ray, kPanes all rays but shadow rays, and kAlpha (cut
  /// out, blended) some. Hidden triangles come last. A triangle is identified by its index here.
  std::vector<TracedTriangle> triangles;
  enum Mesh : std::size_t { kOpaque, kPanes, kAlpha, kHidden };
  std::array<std::uint32_t, kHidden + 1> mesh_begin{};  ///< first triangle of each mesh
  /// Number of triangle pairs in each mesh. Pairs come first, and the ray tracer takes them as quads
  /// (triangle_pairs.h).
  std::array<std::uint32_t, kHidden> pair_count{};
  bool quads = false;  ///< the ray tracer's primitives are quads (unpaired triangles degenerate ones), else triangles
  std::vector<std::uint32_t> triangle_light;  ///< [triangle] light of `lights`, kNoTriangle: none; may be empty
  /// [triangle of the geometry] side on the surface of the square of texture coordinates [0, 1]^2, the mean over its
  /// primitive; 0: it has none. Empty without BTFs.
  std::vector<float> metres_per_uv;
  TextureAtlas atlas;
  LightGrid lights;
  std::vector<std::uint32_t> light_triangles;  ///< [light] its triangle; kNoTriangle: none
  TracedEnvironment environment;
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, EmbreeRelease> device;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, EmbreeRelease> embree;

  /// For benchmarks: called with every ray that is traced. Null otherwise.
  mutable std::function<void(const LoggedRay&)> log;

  const TracedMaterial& material_of(std::uint32_t triangle) const {
    return materials[triangles[triangle].material & ~kBothSides];
  }
  const std::uint32_t* corners(std::uint32_t triangle) const {
    return geometry.indices.data() + 3 * static_cast<std::size_t>(triangles[triangle].source);
  }
};

/// Alpha of a surface at barycentric coordinates of its triangle, texture unfiltered.
float alpha_at(const PathScene& scene, std::uint32_t triangle, const glm::vec2& barycentric);

}  // namespace maquette
