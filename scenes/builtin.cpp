#include "scenes/builtin.h"

#include <array>
#include <utility>

#include "scenes/error.h"
#include "scenes/modelling.h"

namespace maquette {

namespace builtin {

using namespace modelling;

Scene build_sphere() {
  SceneBuilder builder("builtin:sphere");
  const int paint =
      builder.add_material(measured_material("Sphere", "paint-red-metallic", srgb(150, 16, 22), 0.6f, 0.3f));
  builder.add_part("sphere", make_sphere(1.0, 128), paint);
  // The silhouette is at asin(1/d) from the axis: 85 % of the height of a 30 degree view puts the eye at 4.50 m.
  builder.add_camera("front", {0.0, 0.0, 4.5}, {0.0, 0.0, 0.0}, 30.0);
  return std::move(builder.scene());
}

Scene build_cornell() {
  // Measured data of the Cornell box (Cornell University Program of Computer Graphics), 1 unit = 1 cm, centred and
  // mirrored so that the view is along -Z.
  SceneBuilder builder("builtin:cornell");
  const int white = builder.add_material(plain_material("White", {0.73f, 0.73f, 0.73f}, 0.0f, 1.0f));
  const int red = builder.add_material(plain_material("Red", {0.63f, 0.065f, 0.05f}, 0.0f, 1.0f));
  const int green = builder.add_material(plain_material("Green", {0.14f, 0.45f, 0.091f}, 0.0f, 1.0f));
  Material light = plain_material("Light", {0.78f, 0.78f, 0.78f}, 0.0f, 1.0f);
  light.emissive = {17.0f, 12.0f, 4.0f};
  const int lamp = builder.add_material(light);
  for (const int i : {white, red, green, lamp}) builder.scene().materials[static_cast<std::size_t>(i)].specular = 0.0f;

  const double w = 2.78, h = 5.488, d = 2.796;
  builder.add_part("floor", make_quad({-w, 0, d}, {2 * w, 0, 0}, {0, 0, -2 * d}, 16), white);
  builder.add_part("ceiling", make_quad({-w, h, -d}, {2 * w, 0, 0}, {0, 0, 2 * d}, 16), white);
  builder.add_part("back_wall", make_quad({-w, 0, -d}, {2 * w, 0, 0}, {0, h, 0}, 16), white);
  builder.add_part("left_wall", make_quad({-w, 0, d}, {0, 0, -2 * d}, {0, h, 0}, 16), red);
  builder.add_part("right_wall", make_quad({w, 0, -d}, {0, 0, 2 * d}, {0, h, 0}, 16), green);
  builder.add_part("ceiling_light", make_quad({-0.65, h - 0.005, -0.525}, {1.3, 0, 0}, {0, 0, 1.05}, 4), lamp);
  const auto box = [&](const char* name, double size, double height, const Vec3& at, double degrees) {
    builder.add_part(name, make_rounded_box({size, height, size}, 0.004, 1), white,
                     translation(at.x, at.y, at.z) * rotation(degrees, {0, 1, 0}));
  };
  box("short_box", 1.65, 1.65, {0.93, 0.825, 1.1}, -17.0);
  box("tall_box", 1.65, 3.3, {-0.91, 1.65, -0.72}, 17.5);
  builder.add_camera("front", {0.0, 2.73, 10.8}, {0.0, 2.73, 0.0}, 39.3);
  return std::move(builder.scene());
}

}  // namespace builtin

Scene build_builtin_scene(const std::string& name) {
  using Maker = Scene (*)();
  static constexpr std::array<std::pair<const char*, Maker>, 6> kMakers{{
      {"cockpit", builtin::build_cockpit},
      {"sphere", builtin::build_sphere},
      {"plate", builtin::build_plate},
      {"cornell", builtin::build_cornell},
      {"seat", builtin::build_seat},
      {"open-seat", builtin::build_open_seat},
  }};
  std::string names;
  for (const auto& [maker_name, maker] : kMakers) {
    if (name == maker_name) return maker();
    names += (names.empty() ? "" : ", ") + std::string(maker_name);
  }
  throw UsageError("builtin:" + name, "there is no such built-in scene", "use one of " + names);
}

}  // namespace maquette
