// Two-dimensional local bandwidth b = (nu_x, nu_theta): cycles per metre and per radian, the box that holds 95 % of the local
// spectral energy. Source: Bagher et al. 2012, "Interactive rendering of acquired materials on dynamic geometry using bandwidth
// prediction", Sec. 4; Durand et al. 2005.
// Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

/// To the frame of a surface of curvature k (1/m), and back.
MAQUETTE_FN vec2 bandwidth_curvature(vec2 b, float curvature) { return vec2(b.x + abs(curvature) * b.y, b.y); }

/// Reflection: the BRDF limits the angular bandwidth. Differs: for one bounce from a distant light the spectrum lies on the line
/// nu_x = k nu_theta, which the source's boxes do not represent, so the nu_x caused by curvature is limited as well (tighter, and still safe).
MAQUETTE_FN vec2 bandwidth_brdf(vec2 b, float nu_rho, float curvature) {
  float nu_theta = min(b.y, nu_rho);
  return vec2(min(b.x, abs(curvature) * nu_theta), nu_theta);
}

MAQUETTE_FN vec2 bandwidth_texture(vec2 b, float nu_texture) { return vec2(b.x + nu_texture, b.y); }

/// Off the surface plane, for a screen axis along which one pixel covers `footprint_m` metres of surface.
/// Cycles per pixel at the pinhole: the angular part over the pixel's angle plus the spatial part over its footprint
/// (footprint = distance * pixel angle / cos, so this is travel and projection in one step).
MAQUETTE_FN float bandwidth_at_pixel(vec2 b, float pixel_angle, float footprint_m) {
  return b.y * pixel_angle + b.x * footprint_m;
}

/// The whole chain for one bounce from a distant light. `nu_theta`: mean over incident directions of the light's bandwidth after filtering by
/// the lobe (render/environment/bandwidth.h). Every operator is linear in nu_theta for given geometry, so the mean may be taken first.
MAQUETTE_FN float bandwidth_one_bounce(float nu_theta, float curvature, float nu_surface, float pixel_angle, float footprint_m) {
  vec2 b = vec2(0.0f, nu_theta);
  b = bandwidth_curvature(b, curvature);
  b = bandwidth_brdf(b, nu_theta, curvature);
  b = bandwidth_texture(b, nu_surface);
  b = bandwidth_curvature(b, curvature);
  return bandwidth_at_pixel(b, pixel_angle, footprint_m);
}

/// Bandwidth of the GGX lobe around its peak in cycles per radian of direction: the 95 % box of D(h) as a function of wi, fitted to
/// wavelet bandwidths of tabulated lobes (tests/render). kBandwidthLambert is that of a Lambert lobe, which varies over the half sphere.
const float kBandwidthLambert = 0.35f;
MAQUETTE_FN float bandwidth_ggx(float alpha) { return 0.16f / alpha + kBandwidthLambert; }
