#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "render/octree/octree_clip.h"
#include "scenes/brdf.h"
#include "scenes/scene.h"

namespace maquette {

/// A cell's BRDF vector: [pair 4851][RGB], then [direction 98].
/// The first part is E(v, l) = sum over the cell's surface of area |n.v| |n.l| f(v, l), as far as v and l see it, over
/// the area of a face of the cell: it is symmetric. The second is C(v), the area seen from v over the same.
/// Radiance towards v is integral of E(v, l) L(l) dl over the outline that v sees; C over that outline is opacity.
/// Frame, directions and pairs: shaders/shared/cell_brdf.glsl.
inline constexpr int kCellBrdfDimension = 3 * 4851 + 98;

/// How a cell's frame stands around its normal, so that cells that are bent alike have vectors that are alike.
struct CellTurn {
  static constexpr int kBits = 14;
  std::uint32_t steps = 0;  ///< of a turn, 2^kBits
  bool mirrored = false;    ///< the bitangent is turned over: BRDFs of isotropic materials do not tell

  bool operator==(const CellTurn&) const = default;
};
/// Frame of a cell: columns tangent, bitangent, normal.
glm::mat3 cell_frame(const glm::vec3& normal, const CellTurn& turn = {});

/// A local direction with its place in the tables of CellMaterial::fast_brdf, which many pairs of directions share.
struct CellDirection {
  CellDirection(const glm::vec3& direction);  // NOLINT(google-explicit-constructor): a direction is one
  operator const glm::vec3&() const { return d; }
  glm::vec3 d;
  glm::vec2 azimuth{0.0f};  ///< unit; 0 along the normal
  float elevation = 0.0f;   ///< continuous index
};
/// BRDF, 1/sr.
using CellReflectance = std::function<glm::vec3(const CellDirection& wi, const CellDirection& wo)>;

/// What a cell's surface is made of, ready to be evaluated.
class CellMaterial {
 public:
  /// `table`: of a measured material, else null.
  explicit CellMaterial(const Material& material, std::shared_ptr<const BrdfTable> table = nullptr);
  /// BRDF, 1/sr, for a surface of base colour `color` times the material's; directions local, z above 0. Lobes narrower
  /// than the 98 directions are apart are widened to what those can hold. Slow: the definition.
  CellReflectance brdf(const glm::vec3& color) const;
  /// The same from a table over the two elevations and the angle between, made by make_grid(): what bakes
  /// use. Linear in `color`, as BRDFs are but where dielectric and metal are mixed. The material must outlive it.
  CellReflectance fast_brdf(const glm::vec3& color) const;
  void make_grid();
  bool glows() const { return glows_; }
  /// Of all that brdf() depends on.
  std::uint64_t content() const { return content_; }

 private:
  Material material_;
  std::shared_ptr<const BrdfTable> table_;
  bool glows_ = false;
  std::uint64_t content_ = 0;
  /// [elevation][elevation][azimuth]: R, G, B, unused for base colour 0, and what base colour 1 adds.
  std::vector<std::array<float, 8>> grid_;
};

/// One point of a cell's surface that stands for `area` of it.
struct CellSample {
  glm::dvec3 position{0.0};
  glm::dvec3 normal{0.0};  ///< geometric, unit
  double area = 0.0;       ///< over that of a face of the cell
  int piece = 0;           ///< samples of one piece follow each other
};

/// Points of polygons, by area; `face`: area of a face of the cell. Positions in the polygons' own units.
std::vector<CellSample> sample_polygons(std::span<const ClipPolygon* const> polygons, double face, int count,
                                        std::uint32_t seed);

/// Along the way that the normals spread most, and towards the side where they spread farther, on both axes.
CellTurn find_cell_turn(std::span<const CellSample> samples, const glm::vec3& normal);

/// True when nothing of the cell is in the way from `position` along `direction` (world axes).
using CellVisibility = std::function<bool(const CellSample& sample, const glm::vec3& direction)>;

/// The vector of a cell with this frame from samples of its surface; `reflectance[piece]`. An empty `visible` says that
/// all of the surface sees everything above it.
Eigen::VectorXf compute_cell_brdf(std::span<const CellSample> samples, std::span<const CellReflectance> reflectance,
                                  const glm::mat3& frame, const CellVisibility& visible);

/// What each entry of the vector counts in an error: solid angles of its directions.
Eigen::VectorXf cell_brdf_measure();
/// Solid angle of a direction: integral of its bilinear weight over the sphere. They sum to 4 pi.
std::span<const float> cell_solid_angles();

}  // namespace maquette
