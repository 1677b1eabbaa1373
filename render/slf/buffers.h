#pragma once

#include "render/gl/objects.h"
#include "render/slf/light_field.h"

namespace maquette {

/// Texels along a side of the table from which a lumisphere of `side` bins is read bilinearly: 7/4 of them, with which
/// a field of 1024 x 1024 texels stays 40 times smaller than its slices.
inline int lumisphere_table_side(int side) { return (7 * side + 3) / 4; }

/// A light field on the GPU, as shaders/slf/light_field.glsl reads it.
class LightFieldBuffers {
 public:
  /// `triangles`: of the geometry. Throws Error where the driver cannot hold it.
  LightFieldBuffers(const LightField& field, std::size_t triangles);
  void bind() const;
  std::size_t bytes() const;

 private:
  void upload_sides(const LightField& field, std::size_t triangles);
  void upload_codes(const LightField& field);
  /// Of each cell a cluster, and the normal of the texel that is read there.
  void upload_clusters(const LightField& field, const std::vector<std::uint8_t>& clusters);
  void upload_lumispheres(const LightField& field);
  void upload_stored(const LightField& field);
  void upload_interactions(const LightField& field);
  /// Coefficients of directions [3 bin + channel][column] by cells, for texelFetch.
  void upload_coefficients(const char* name, const Eigen::MatrixXf& columns, int side);

  float scale_ = 1.0f;  ///< cd/m2 of a stored unit
  Buffer slots_, sides_, radiance_;
  Texture slot_view_, side_view_, radiance_view_;
  Texture clusters_, weights_, lumispheres_, cells_, errors_;
};

}  // namespace maquette
