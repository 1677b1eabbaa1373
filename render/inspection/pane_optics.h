#pragma once

namespace maquette {

/// A quantity for light polarised perpendicular (s) and parallel (p) to the plane of incidence.
struct Polarised {
  double s = 0.0, p = 0.0;
  double mean() const { return 0.5 * (s + p); }
};

/// Shares of the light that arrives at a pane, in [0, 1].
struct PaneOptics {
  Polarised surface;      ///< reflectance of the front face alone
  Polarised reflected;    ///< of the pane: all bounces, incoherent
  Polarised transmitted;  ///< of the pane
};
/// The renderer's formula in double. `inside`: internal transmittance of one crossing, in [0, 1].
PaneOptics pane_optics(double incidence_rad, double refractive_index, double inside);

/// Lateral distance of the two reflections of a parallel ray, m: d sin(2 theta) / sqrt(n^2 - sin^2 theta).
double ghost_offset_m(double incidence_rad, double refractive_index, double thickness_m);

/// A pane seen by an eye; in the plane of incidence. The wedge is positive where the pane gets thicker towards the eye:
/// for a windshield and a dashboard upwards, as the setting reflections.wedge.
struct GhostView {
  double incidence_rad = 0.0;
  double refractive_index = 1.52;
  double thickness_m = 0.005;
  double wedge_rad = 0.0;
  double object_m = 1.0;  ///< from the pane to what is mirrored, along the ray; infinity: far away
  double eye_m = 1.0;     ///< from the pane to the eye
};
/// Angle between the two images of a point that a flat pane mirrors, as the eye sees them, rad; positive where the
/// second image is seen at less incidence. Traced in double by the renderer's own formula of the second
/// ray; NaN where that ray does not leave the pane.
double ghost_angle_rad(const GhostView& view);
/// The same to first order: (s - 2 alpha a sqrt(n^2 - sin^2 theta) / cos theta) / (a + b), s of ghost_offset_m, a and b
/// the distances of object and eye.
double ghost_angle_first_order_rad(const GhostView& view);
/// The wedge at which both images of the point coincide, rad, to first order: d sin theta cos^2 theta /
/// ((n^2 - sin^2 theta) a).
double wedge_without_ghost_rad(const GhostView& view);

/// Secondary image angle of a pane, a property of the pane alone: between the direct image and that of two reflections
/// inside, of a far source seen through it, rad. `radius_m`: of curvature in the plane of incidence; infinity: flat.
/// Source: UN ECE R43, Annex 3, 9.3 for its use; 2 alpha sqrt(n^2 - sin^2 theta) / cos theta for a flat wedge, less
/// 2 d sin theta / (Rc sqrt(n^2 - sin^2 theta)) by curvature.
double secondary_image_angle_rad(double incidence_rad, double refractive_index, double thickness_m, double wedge_rad,
                                 double radius_m);

/// Luminance that a flat pane adds by mirroring a Lambertian surface that the sun lights through it, cd/m2: E tau
/// rho / pi R. `illuminance_lx`: on the pane's outer face; `transmittance`: on the way to the surface.
double flat_veil_cdm2(double illuminance_lx, double transmittance, double reflectance, double pane_reflectance);
/// Share of an object's contrast that is left when `veil_cdm2` is added to `seen_cdm2`, the background seen through the
/// pane. 1 without a veil; 0 for black on black.
double contrast_kept(double seen_cdm2, double veil_cdm2);

constexpr double kArcMinute_rad = 2.908882086657216e-4;

}  // namespace maquette
