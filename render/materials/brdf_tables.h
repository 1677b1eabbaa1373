#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scenes/brdf.h"

namespace maquette {

inline constexpr int kElevationCount = 32;  ///< view elevations theta_o = (e + 0.5) / 32 * pi/2
inline constexpr int kThetaCellCount = 96;  ///< cells of t = 1 - cos(theta_h); see theta_cell_mass
inline constexpr int kPhiCellCount = 16;    ///< equal-mass cells of phi_h in [0, pi] (the other half by symmetry)
inline constexpr int kAlbedoCount = 64;     ///< theta_o = i / 63 * pi/2

/// Tables derived once per BRDF and cached by content. No OpenGL.
///
/// Importance of the half vector h for one view elevation (wo in the xz plane, +x side), with density proportional to
/// Y(f) cos(theta_i) d omega_i / d omega_h (plus a small floor so that every cell is positive). The marginal over t = 1
/// - cos(theta_h) is divided into cells of *fixed* probability (theta_cell_mass: equal, then geometric towards the
/// tail, so that sampling needs no search), and each cell's conditional over phi_h into 16 equal-mass cells. The
/// density is constant over solid angle within a cell (d omega_h = dt dphi).
struct BrdfTables {
  std::vector<glm::vec2>
      theta_cells;  ///< [elevation 32][96] (t_begin, t_end), partition of the t that can reflect above the horizon
  std::vector<glm::vec2>
      phi_cells;  ///< [elevation 32][96][16] (phi_begin, phi_end), partition of the usable part of [0, pi]
  std::vector<glm::vec3> albedo;  ///< [64] directional albedo, linear RGB
  /// [theta_h 90][theta_d 90] local angular bandwidth nu_rho: cycles per radian of *direction* (of wi or wo, the other
  /// fixed) below which 95 % of the local spectral energy lies; energy-weighted over phi_d. Daubechies-4 wavelets.
  std::vector<float> bandwidth;
};
BrdfTables compute_brdf_tables(const BrdfTable& brdf);
/// compute_brdf_tables through the disk cache.
BrdfTables load_brdf_tables(const BrdfTable& brdf);

inline constexpr int kGgxBandwidthCount = 64;
/// Roughness (alpha) of row i of ggx_bandwidth: perceptual roughness (i + 0.5) / 64, squared.
constexpr double ggx_bandwidth_alpha(int i) {
  return (i + 0.5) / kGgxBandwidthCount * ((i + 0.5) / kGgxBandwidthCount);
}
/// Local angular bandwidth of analytic GGX lobes, computed from tabulated lobes by the same code: [alpha 64][theta_h
/// 90], cycles per radian of direction.
std::vector<float> ggx_bandwidth();

/// Lambert + one GGX lobe with Smith masking and Schlick Fresnel, fitted by least squares in cube-root space over
/// cos-weighted bins: the material model of other viewers.
struct GgxFit {
  glm::vec3 diffuse{0.0f};   ///< albedo
  glm::vec3 specular{0.0f};  ///< F0
  float alpha = 1.0f;        ///< roughness squared
  float relative_error = 0.0f;
};
GgxFit fit_ggx(const BrdfTable& brdf);

/// Per channel f = diffuse / pi + sum over 3 lobes of amplitude * exp(sharpness (cos(theta_h) - 1)); least squares in
/// cube-root space over cos-weighted bins. Source: Wang et al. 2009, Sec. 4. Differs: no Fresnel or masking factor on
/// the lobes.
struct SgFit {
  struct Lobe {
    glm::vec3 amplitude{0.0f};  ///< per channel
    glm::vec3 sharpness{1.0f};  ///< per channel; exp(sharpness (cos(theta_h) - 1))
  };
  glm::vec3 diffuse{0.0f};
  std::vector<Lobe> lobes;
  float relative_error = 0.0f;
};
/// Through the disk cache.
SgFit fit_sg(const BrdfTable& brdf);

}  // namespace maquette
