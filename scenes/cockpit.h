#pragma once

#include "scenes/modelling.h"

/// Parts of the built-in car; each adds its nodes to the scene. Frame and units as in cockpit_surface.h; left-hand
/// drive.
namespace maquette::builtin {

/// Position of the camera `driver`, for which the mirrors are adjusted: 63 cm above the R-point and a little behind it.
inline const modelling::Vec3 kDriverEye_m(0.37, 1.10, -0.30);

/// Materials by purpose, indices into the scene; variants exchange them.
struct CockpitMaterials {
  int paint, paint_touring, paint_atelier;
  int seat, seat_touring, seat_atelier;
  int insert, insert_touring, insert_atelier;
  int trim, trim_touring, trim_atelier;
  int decor, decor_touring, decor_atelier;
  int soft, hard, piano, chrome, brushed, gunmetal, rubber, carpet, headliner, stitch;
  int glass, mirror, cluster, center_screen, ambient, daylight_lamp, tail_lamp, amber, lens, caliper, asphalt, disc;
};

CockpitMaterials add_cockpit_materials(modelling::SceneBuilder* builder);
/// Gives the part of `node` its three variants of material, if its material is one that varies.
void add_variants(modelling::SceneBuilder* builder, const CockpitMaterials& materials);

void add_body(modelling::SceneBuilder* builder, const CockpitMaterials& materials);
void add_doors(modelling::SceneBuilder* builder, const CockpitMaterials& materials);
void add_wheels(modelling::SceneBuilder* builder, const CockpitMaterials& materials);
void add_dashboard(modelling::SceneBuilder* builder, const CockpitMaterials& materials);
void add_console(modelling::SceneBuilder* builder, const CockpitMaterials& materials);
void add_steering_wheel(modelling::SceneBuilder* builder, const CockpitMaterials& materials);
void add_cabin(modelling::SceneBuilder* builder, const CockpitMaterials& materials);
/// Front seat on x = `x`; `name` prefixes its nodes.
void add_seat(modelling::SceneBuilder* builder, const CockpitMaterials& materials, const std::string& name, double x);
void add_ground(modelling::SceneBuilder* builder, const CockpitMaterials& materials);

/// Left part and its mirror image, as `name_left` and `name_right`.
void add_pair(modelling::SceneBuilder* builder, const std::string& name, const Primitive& left, int material);

}  // namespace maquette::builtin
