#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "render/reference/reference.h"
#include "render/slf/atlas.h"
#include "render/slf/lumisphere.h"

namespace maquette {

struct IncidentOptions {
  int side = Lumisphere::kDefaultSide;  ///< of the lumispheres
  int paths = 4;                        ///< of a bin
  std::uint32_t seed = 0;
  float env_rotation_rad = 0.0f, env_scale = 1.0f;
};

/// Light that arrives at the texels of an atlas, in their local frames.
struct IncidentField {
  int side = Lumisphere::kDefaultSide;
  int bins = 0;
  std::vector<float> radiance;  ///< [texel][bin][RGB] cosine-weighted mean radiance over the bin's solid angle, cd/m2
  std::vector<bool> masked;     ///< [texel] inside another body
  std::size_t texel_count() const { return masked.size(); }
  std::span<const float> texel(std::size_t t) const {
    const auto stride = static_cast<std::size_t>(3 * bins);
    return std::span(radiance).subspan(t * stride, stride);
  }
};

/// Where a texel is, and its local frame.
struct TexelFrame {
  glm::vec3 position{0.0f};
  glm::vec3 origin{0.0f};               ///< off the surface, for rays
  glm::vec3 geometric{0.0f};            ///< unit normal of the plane, on its side
  glm::vec3 t{0.0f}, b{0.0f}, n{0.0f};  ///< n: of the shading
  glm::vec3 to_world(const glm::vec3& w) const { return t * w.x + b * w.y + n * w.z; }
  glm::vec3 to_local(const glm::vec3& d) const { return {glm::dot(t, d), glm::dot(b, d), glm::dot(n, d)}; }
};
TexelFrame frame_of_texel(const FlatGeometry& geometry, const LightFieldAtlas& atlas, std::size_t texel);

/// Traces what arrives at texels: paths of full transport through every bin (coverage sampling, not its centre), and
/// light samples for what is small or has no extent, weighted by the balance heuristic. What a texel gets depends on
/// its index and the options alone, not on threads or on who traced the others. Thread-safe.
/// Source of the heuristic: Veach and Guibas 1995.
class IncidentTracer {
 public:
  IncidentTracer(std::shared_ptr<const PathScene> scene, std::shared_ptr<const LightFieldAtlas> atlas,
                 const IncidentOptions& options);
  ~IncidentTracer();
  const Lumisphere& lumisphere() const { return lumisphere_; }
  /// `out`: [bin][RGB]. Returns whether the texel is inside another body; then out is 0.
  bool trace(std::size_t texel, std::span<float> out) const;

 private:
  struct Lights;
  bool is_inside(const TexelFrame& frame, std::uint32_t seed) const;
  void add_paths(const TexelFrame& frame, std::uint32_t seed, std::span<float> out) const;
  void add_light_samples(const TexelFrame& frame, std::uint32_t seed, std::span<float> out) const;

  std::shared_ptr<const PathScene> scene_;
  std::shared_ptr<const LightFieldAtlas> atlas_;
  IncidentOptions options_;
  Lumisphere lumisphere_;
  std::unique_ptr<const Lights> lights_;
};

}  // namespace maquette
