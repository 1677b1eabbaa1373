#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <vector>

#include "render/frame/frame_constants.h"
#include "render/raytraced/ray_scene.h"
#include "render/reflections/clusters.h"
#include "render/reflections/lobe_bound.h"
#include "render/reflections/reflectors.h"
#include "render/reflections/sky_bound.h"

namespace maquette {

/// What an item may emit or reflect, for `MirroredBound`.
struct BoundSurface {
  int lobe = -1;               ///< in BoundLight::lobes
  float emission = 0.0f;       ///< cd/m2, of the largest channel
  bool normal_mapped = false;  ///< its normals come from a texture: they may point anywhere
};

/// The lights of a scene, for `MirroredBound`.
struct BoundLight {
  const SkyBound* sky = nullptr;
  float cosine = 1.0f, sine = 0.0f;  ///< of the environment's rotation
  float scale = 1.0f;                ///< cd/m2 per stored unit
  bool shadows = false;              ///< test the lamps for shadows, cluster by cluster
  std::vector<LobeBound> lobes;
  std::vector<BoundSurface> surfaces;  ///< [item]
};

/// Bound of the radiance of small bright things in the parts of panes, seen from an eye: emitters, the sky, and the
/// sky's lamps reflected in glossy surfaces. Test rays find what a part sees, in direction cells of 5 degrees: the
/// bound of a part is the largest radiance that the triangles found in the cells of its rays, and in the cells around,
/// can send into the cell. Objects smaller than the distance of the test rays (about 2 cm at arm's length) may be
/// missed. No OpenGL. Source: Mueller et al. 2007, "Towards predictive virtual prototyping", Sec. 11.3.3 (the rule).
/// Differs: their bound is the brightest light source, which a sun makes useless. Slow variations are not covered: for
/// those the caller traces a subset of the rays.
class MirroredBound {
 public:
  /// `occluding[i]`: rays end at item i. Copies what it needs.
  void set_geometry(const FlatGeometry& geometry, const std::vector<bool>& occluding,
                    const std::vector<Reflector>& reflectors);
  void set_light(const BoundLight& light);
  /// Bound of each part, cd/m2, of the largest channel; 0 for a part out of view.
  std::vector<float> compute(const FrameConstants& frame);

  std::size_t part_count() const { return parts_.size(); }
  /// Part of each triangle of the reflectors, one reflector after the other.
  const std::vector<std::uint32_t>& part_of_triangle() const { return part_of_triangle_; }
  /// First entry of each reflector in part_of_triangle().
  const std::vector<std::uint32_t>& first_of_reflector() const { return first_of_reflector_; }

 private:
  static constexpr int kColumns = 72, kRows = 36, kTests = 16;
  struct Met {
    std::uint32_t cluster = 0;
    glm::vec3 normal{0.0f}, wo{0.0f};  ///< mean normal and direction of the ray, both towards the part
    float normal_spread_rad = 0.0f;    ///< largest angle between the triangle's normals and `normal`
  };
  struct Cell {
    std::vector<Met> met;
    bool sky = false;
    std::uint32_t light = 0;  ///< version of the light that `bound` belongs to
    float bound = 0.0f;       ///< cd/m2
  };
  struct Part {
    std::size_t item = 0;
    Bounds bounds;
    std::vector<glm::vec3> positions, normals;
    std::map<std::size_t, Cell> seen;  ///< by direction cell: hits of the test rays
  };
  struct Lit {
    std::size_t item = 0;
    glm::vec3 center{0.0f};
    std::vector<std::uint32_t> lamps;  ///< lamps that may illuminate it
  };
  void add_parts(const FlatGeometry& geometry, const Reflector& reflector);
  Cell test_cell(const Part& part, std::size_t number) const;
  float bound_of_cell(Part* part, std::size_t number) const;
  void light_cluster(Lit* lit, std::size_t cluster) const;
  float radiance_of(const Met& met) const;
  float bound_of(Part* part, const FrameConstants& frame) const;

  std::vector<Part> parts_;
  std::vector<std::uint32_t> part_of_triangle_, first_of_reflector_;
  ClusterSet clusters_;
  std::vector<Lit> lit_;  ///< [cluster]
  RayScene rays_;
  std::vector<std::uint32_t> cluster_of_;  ///< [triangle of `rays_`]
  std::vector<float> sky_out_;             ///< [kRows][kColumns] largest radiance of the sky in a cell, world
  BoundLight light_;
  std::vector<SkyBound::Lamp> lamps_;  ///< world, lux
  std::vector<glm::vec3> positions_;   ///< [vertex]
  std::vector<glm::vec4> normals_;     ///< [triangle] mean of its vertex normals; w: their largest angle from it
  std::uint32_t light_version_ = 0;
};

}  // namespace maquette
