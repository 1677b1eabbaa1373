#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <type_traits>
#include <vector>

#include "render/btf/small_geometry.h"
#include "scenes/btf/btf_reading.h"

namespace maquette {

/// Rays over the infinitely repeated tile of a SmallGeometry.
class TileRays {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  explicit TileRays(const SmallGeometry& geometry);
  /// Cell of the first surface along a unit direction, kNone where nothing is.
  std::uint32_t first_cell(const glm::vec3& origin, const glm::vec3& direction) const;
  /// Cell that is seen at a point (x, y) of the base plane from direction `wo` (z > 0): rectification.
  std::uint32_t seen_cell(const glm::vec2& point, const glm::vec3& wo) const;
  glm::vec3 normal(std::uint32_t cell) const { return normals_[cell]; }
  /// Where rays of a cell begin: the middle of its diagonal, just above the surface.
  glm::vec3 origin(std::uint32_t cell) const { return origins_[cell]; }
  std::size_t cell_count() const { return normals_.size(); }

 private:
  struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  };
  struct ReleaseScene {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  void build_cells(const SmallGeometry& geometry);

  int side_ = 0, border_ = 0;  ///< cells; those of the border are repeated around the tile
  float lowest_ = 0.0f, highest_ = 0.0f;
  std::vector<glm::vec3> normals_, origins_;
  std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene> scene_;
};

struct SmallLightOptions {
  int gather_rays = 64;  ///< of each cell, for interreflection; 0: direct light only
  int most_bounces = 24;
  std::uint32_t seed = 1;
};

/// What every cell sends under each of many distant lights of unit irradiance (on a plane across the light): computed
/// once a light, then looked up for any view. Light that was reflected before arrives and leaves diffusely; light that
/// comes straight from the lamp is reflected by the lobe too.
/// Source: gathering by cosine-distributed rays, Keller 1997 ("Instant Radiosity") and Goral et al. 1984; all bounces
/// by Jacobi's iteration, until one adds less than 0.1 %.
class SmallScaleLight {
 public:
  SmallScaleLight(const SmallGeometry& geometry, const TileRays& rays, std::vector<glm::dvec3> lights,
                  const SmallLightOptions& options, const BtfTask& task = {});
  /// Radiance of a cell towards `wo` (z > 0) under all lights, added to `sums` times `share`. Cells that face away from
  /// `wo` send nothing.
  void add_radiance(std::uint32_t cell, const glm::vec3& wo, float share, glm::vec3* sums) const;
  std::size_t light_count() const { return directions_.size(); }
  const glm::vec3& light(std::size_t l) const { return directions_[l]; }
  /// Whether a light reaches a cell without being reflected.
  bool lit(std::uint32_t cell, std::size_t l) const { return visible_[cell * directions_.size() + l] != 0; }
  /// Diffusely sent radiance.
  const glm::vec3& diffuse(std::uint32_t cell, std::size_t l) const { return radiance_[cell * directions_.size() + l]; }

 private:
  void light_directly();
  void gather(const SmallLightOptions& options, const BtfTask& task);

  const SmallGeometry& geometry_;
  const TileRays& rays_;
  std::vector<glm::vec3> directions_;
  std::vector<float> x_, y_, z_;       ///< the same by coordinate
  std::vector<std::uint8_t> visible_;  ///< [cell][light]
  std::vector<glm::vec3> radiance_;    ///< [cell][light] sent diffusely
};

}  // namespace maquette
