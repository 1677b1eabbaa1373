#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scenes/btf/direction_mesh.h"

namespace maquette {

/// Limits of a BTF that is read; larger counts are taken for a damaged file.
inline constexpr int kMostBtfSide = 8192;  ///< texels
inline constexpr std::uint32_t kMostBtfViews = 4096, kMostBtfLights = 4096;

/// Numbers of a view that its factorisation drops or that describe its images; kept in the file.
struct BtfViewFigures {
  std::vector<float> spectrum;  ///< energy of the first kBtfSpectrum components, whether stored or not
  double energy = 0.0;          ///< about the mean: of all components. Sums over RGB, mean over lights and texels
  double mean_energy = 0.0;     ///< of the mean texture
  double contrast = 0.0;        ///< standard deviation of luminance over texels, mean over lights, over mean luminance
  double shadowed = 0.0;        ///< share of texels darker than a quarter of their image's mean, mean over lights
};
inline constexpr std::size_t kBtfSpectrum = 16;
inline constexpr int kMostBtfComponents = 16;

/// All images of one view: mean texture + sum over components of light weight * eigen-texture. RGB is on the texel
/// axis: light weights are scalars, eigen-textures coloured.
struct BtfView {
  glm::dvec3 direction{0.0, 0.0, 1.0};
  std::shared_ptr<const DirectionMesh> lights;  ///< views may have different ones
  std::vector<float> light_weights;             ///< [light][component]
  /// Half floats, [level][y][x][1 + component][rgb]: the mean first. Row 0 lies at +y. Level k + 1 is the box-filtered
  /// half of level k, down to one texel; factors are linear, so that it factorises the filtered images.
  std::vector<std::uint16_t> factors;
  BtfViewFigures figures;
};

/// A bidirectional texture function: reflectance by texel, light and view, rectified to the base plane, in factorised
/// form. Holds rho = radiance / (irradiance of the base plane) in 1/sr: the light's cosine is not in the values.
/// Local frame: x along growing u (the tangent), y up in the images, z the normal of the base plane.
struct Btf {
  std::string name;
  int width = 0, height = 0;  ///< texels
  int components = 0;
  double texel_m = 0.0;                           ///< side of a texel on the surface
  std::map<std::string, std::string> provenance;  ///< what it was made from: source, btf.cosine, btf.gamma, ...
  std::vector<BtfView> views;
  DirectionMesh view_mesh;  ///< of the views' directions, in their order
  std::uint64_t hash = 0;   ///< of all factors and directions; key of what is derived from it
  double width_m() const { return texel_m * width; }
  double height_m() const { return texel_m * height; }
};

/// Place of one level in BtfView::factors.
struct BtfLevel {
  int width = 0, height = 0;
  std::size_t offset = 0;  ///< in half floats
};
std::vector<BtfLevel> btf_levels(int width, int height, int components);

/// Where and how finely a BTF is read. `uv`: in tiles, v downwards, wraps. `footprint`: side of the filter in tiles; 0
/// reads the finest level, 1 and more the mean over the tile.
struct BtfLookup {
  glm::vec2 uv{0.0f};
  float footprint = 0.0f;
};

/// Factors of one view there, filtered: texels bilinear, levels linear. Writes 1 + components colours to `colors`.
void read_btf_factors(const Btf& btf, const BtfView& view, const BtfLookup& at, glm::vec3* colors);

/// rho (1/sr, without the cosine) by linear interpolation over texels, levels, lights and views. wi, wo: unit, local.
/// Beyond the outermost directions rho is that of the nearest direction within. Never negative; 0 below the horizon.
glm::vec3 evaluate_btf(const Btf& btf, const BtfLookup& at, const glm::vec3& wi, const glm::vec3& wo);

/// Fills levels, view_mesh and hash, after the finest level of all views is there.
void complete_btf(Btf* btf);

/// Share of the images' energy about the mean that `components` keep, over all views.
double btf_energy_kept(const Btf& btf, int components);

}  // namespace maquette
