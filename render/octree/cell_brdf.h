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

/// Layout of a cell's BRDF vector: [pair 4851][RGB], then [direction 98].
/// The first part is E(v, l) = sum over the cell's surface of area |n.v| |n.l| f(v, l), where both v and l see it, over
/// the area of a face of the cell: it is symmetric. The second is C(v), the area seen from v over the same. Radiance
/// towards v is the integral of E(v, l) L(l) dl, divided by the area of the cell's outline seen from v; C over that
/// outline is opacity.
/// Frame, directions and pairs: shaders/shared/cell_brdf.glsl.
inline constexpr int kCellBrdfDimension = 3 * 4851 + 98;

/// Rotation of a cell's frame about its normal, chosen so that cells of the same shape have the same vectors.
struct CellRotation {
  static constexpr int kBits = 14;
  std::uint32_t steps = 0;  ///< in units of 1 / 2^kBits of a full rotation
  bool mirrored = false;    ///< the bitangent is reversed, which isotropic BRDFs do not notice

  bool operator==(const CellRotation&) const = default;
};
/// Frame of a cell: columns tangent, bitangent, normal.
glm::mat3 cell_frame(const glm::vec3& normal, const CellRotation& turn = {});

/// A local direction with its position in the tables of CellMaterial::fast_brdf; many pairs of directions share it.
struct CellDirection {
  CellDirection(const glm::vec3& direction);  // NOLINT(google-explicit-constructor): a direction is one
  operator const glm::vec3&() const { return d; }
  glm::vec3 d{};
  glm::vec2 azimuth{0.0f};  ///< unit; 0 along the normal
  float elevation = 0.0f;   ///< continuous index
};
/// BRDF, 1/sr.
using CellReflectance = std::function<glm::vec3(const CellDirection& wi, const CellDirection& wo)>;

/// The material of a cell's surface, prepared for evaluation.
class CellMaterial {
 public:
  /// `table`: of a measured material, else null.
  explicit CellMaterial(const Material& material, std::shared_ptr<const BrdfTable> table = nullptr);
  /// BRDF, 1/sr, of a surface with base colour `color` times the material's; directions local, z above 0. Lobes
  /// narrower than the spacing of the 98 directions are widened to that spacing. Slow: the reference definition.
  CellReflectance brdf(const glm::vec3& color) const;
  /// The same from a table over the two elevations and the azimuth between, made by make_grid(), for bakes. Linear in
  /// `color`, which BRDFs are except where dielectric and metal are mixed. The material must outlive it.
  CellReflectance fast_brdf(const glm::vec3& color) const;
  void make_grid();
  bool glows() const { return glows_; }
  /// Hash of everything that brdf() depends on.
  std::uint64_t content() const { return content_; }

 private:
  Material material_;
  std::shared_ptr<const BrdfTable> table_;
  bool glows_ = false;
  std::uint64_t content_ = 0;
  /// [elevation][elevation][azimuth]: R, G, B, unused for base colour 0, and the increments for base colour 1.
  std::vector<std::array<float, 8>> grid_;
};

/// One point of a cell's surface, representing `area` of it.
struct CellSample {
  glm::dvec3 position{0.0};
  glm::dvec3 normal{0.0};  ///< geometric, unit
  double area = 0.0;       ///< relative to a face of the cell
  int piece = 0;           ///< samples of one piece are consecutive
};

/// Sample points of polygons, uniform in area; `face`: area of a face of the cell. Positions in the polygons' own
/// units.
std::vector<CellSample> sample_polygons(std::span<const ClipPolygon* const> polygons, double face, int count,
                                        std::uint32_t seed);

/// Aligns the frame with the direction in which the normals spread most; each axis points to the side where they spread
/// farther.
CellRotation find_cell_rotation(std::span<const CellSample> samples, const glm::vec3& normal);

/// True when nothing of the cell blocks `direction` (world axes) from the sample.
using CellVisibility = std::function<bool(const CellSample& sample, const glm::vec3& direction)>;

/// The vector of a cell with this frame from samples of its surface; `reflectance[piece]`. An empty `visible` means no
/// self-occlusion.
Eigen::VectorXf compute_cell_brdf(std::span<const CellSample> samples, std::span<const CellReflectance> reflectance,
                                  const glm::mat3& frame, const CellVisibility& visible);

/// Weight of each entry of the vector in an error: solid angles of its directions.
Eigen::VectorXf cell_brdf_measure();
/// Solid angle of each direction: integral of its bilinear weight over the sphere. They sum to 4 pi.
std::span<const float> cell_solid_angles();

}  // namespace maquette
