#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

namespace maquette::test {

/// A Lambertian triangle, visible and emitting on the side of cross(b - a, c - a).
struct DiffuseTriangle {
  glm::dvec3 corners[3]{};
  glm::dvec3 albedo{0.0};
  glm::dvec3 emission{0.0};  ///< radiance
};

struct RadiosityOptions {
  double largest_edge = 0.5;  ///< triangles are split into equal ones until no edge is longer
  int rays = 4096;            ///< an element, cosine-distributed and low-discrepancy over element and hemisphere
  int light_cells = 16;       ///< along each edge of an emitting triangle, for shadows
  bool far_lights = true;     ///< sample one-bounce light, one point of a light a ray; else sum over the lights, for
                              ///< surfaces close to them
  std::uint32_t seed = 0;
};

struct SurfaceHit {
  glm::dvec3 position{}, normal{};  ///< geometric normal, unit
  glm::dvec3 albedo{}, emission{};
  bool front = false;  ///< hit on the visible side
};

/// Radiosity of a closed or open scene of diffuse triangles: an independent check for the path tracer that shares
/// nothing with it but the intersection of a ray with a triangle.
///
/// The irradiance of constant elements solves E = D + F diag(albedo) E, where F are the form factors and D is the
/// direct irradiance. D is Lambert's formula for each cell of the emitters that is visible. At a point, the light of
/// the elements is gathered again, with its direct part computed at the points that the rays hit: only light after two
/// or more bounces is constant over an element. Source: Goral et al. 1984, "Modeling the Interaction of Light Between
/// Diffuse Surfaces"; Baum et al. 1989 (point to polygon).
class Radiosity {
 public:
  Radiosity(const std::vector<DiffuseTriangle>& triangles, const RadiosityOptions& options);
  ~Radiosity();
  /// Irradiance at a point of the surface by all paths.
  glm::dvec3 irradiance(const glm::dvec3& position, const glm::dvec3& normal, int rays) const;
  glm::dvec3 direct_irradiance(const glm::dvec3& position, const glm::dvec3& normal) const;
  std::optional<SurfaceHit> first_hit(const glm::dvec3& origin, const glm::dvec3& direction) const;
  std::size_t element_count() const;
  double residual() const;  ///< of the linear system, relative, largest channel

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace maquette::test
