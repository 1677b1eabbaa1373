#include "scenes/cockpit.h"

#include <utility>

#include "scenes/builtin.h"
#include "scenes/cockpit_surface.h"

namespace maquette::builtin {

using namespace modelling;

void add_pair(SceneBuilder* builder, const std::string& name, const Primitive& left, int material) {
  builder->add_part(name + "_left", left, material);
  builder->add_part(name + "_right", mirrored_x(left), material);
}

Scene build_cockpit() {
  SceneBuilder builder("builtin:cockpit");
  const CockpitMaterials materials = add_cockpit_materials(&builder);
  add_ground(&builder, materials);
  add_body(&builder, materials);
  add_doors(&builder, materials);
  add_wheels(&builder, materials);
  add_dashboard(&builder, materials);
  add_console(&builder, materials);
  add_steering_wheel(&builder, materials);
  add_cabin(&builder, materials);
  add_seat(&builder, materials, "seat_driver", 0.37);
  add_seat(&builder, materials, "seat_passenger", -0.37);
  add_variants(&builder, materials);
  builder.add_empty("r_point", {0.37, 0.47, -0.23});  // of the driver
  builder.add_camera("driver", kDriverEye_m, {0.27, 0.93, 0.60}, 58.0);
  builder.add_camera("passenger", {-0.37, 1.12, -0.34}, {0.06, 0.86, 0.50}, 58.0);
  builder.add_camera("exterior", {3.7, 1.30, 4.5}, {0.05, 0.60, 0.10}, 27.0);
  builder.add_camera("door", {2.9, 1.05, 0.75}, {0.85, 0.64, 0.02}, 28.0);
  return std::move(builder.scene());
}

}  // namespace maquette::builtin
