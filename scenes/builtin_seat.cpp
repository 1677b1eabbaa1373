#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scenes/builtin.h"
#include "scenes/cockpit.h"
#include "scenes/modelling.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

/// The box, m: open towards +z, its floor under the seat's rails.
constexpr double kHalfWidth = 1.1, kFloor = 0.215, kCeiling = 2.0, kBack = -1.1, kFront = 1.2;
/// Half the side of the lamp: seen from the middle of the cushion, 1.5 m below, its half angle is 15 degrees.
constexpr double kLampHalf = 0.4;

void add_box(SceneBuilder* builder) {
  const int white = builder->add_material(plain_material("WhiteWall", {0.75f, 0.75f, 0.75f}, 0.0f, 1.0f));
  const int red = builder->add_material(plain_material("RedWall", {0.65f, 0.12f, 0.09f}, 0.0f, 1.0f));
  for (const int m : {white, red}) builder->scene().materials[static_cast<std::size_t>(m)].specular = 0.0f;
  const int mirror = builder->add_material(plain_material("MirrorWall", {0.9f, 0.9f, 0.9f}, 1.0f, 0.0f));
  Material glow = plain_material("Lamp", {0.0f, 0.0f, 0.0f}, 0.0f, 1.0f);
  glow.specular = 0.0f;
  glow.emissive = {40000.0f, 34000.0f, 22000.0f};  // cd/m2
  const int lamp = builder->add_material(glow);

  const double w = kHalfWidth, h = kCeiling - kFloor, d = kFront - kBack;
  builder->add_part("floor", make_quad({-w, kFloor, kFront}, {2 * w, 0, 0}, {0, 0, -d}, 16), white);
  builder->add_part("ceiling", make_quad({-w, kCeiling, kBack}, {2 * w, 0, 0}, {0, 0, d}, 16), white);
  builder->add_part("back_wall", make_quad({-w, kFloor, kBack}, {2 * w, 0, 0}, {0, h, 0}, 16), white);
  builder->add_part("red_wall", make_quad({-w, kFloor, kFront}, {0, 0, -d}, {0, h, 0}, 16), red);
  const int node = builder->add_part("mirror_wall", make_quad({w, kFloor, kBack}, {0, 0, d}, {0, h, 0}, 16), mirror);
  builder->scene().nodes[static_cast<std::size_t>(node)].reflector = true;
  builder->add_part(
      "lamp", make_quad({-kLampHalf, kCeiling - 0.01, 0.05 - kLampHalf}, {2 * kLampHalf, 0, 0}, {0, 0, 2 * kLampHalf}),
      lamp);
}

}  // namespace

namespace {

SceneBuilder seat_scene(const std::string& name) {
  SceneBuilder builder(name);
  CockpitMaterials m{};
  m.seat = builder.add_material(measured_material("Seat", "leather-black", srgb(38, 37, 37), 0.0f, 0.55f));
  m.insert = builder.add_material(measured_material("SeatInsert", "fabric-grey", srgb(112, 112, 114), 0.0f, 0.9f));
  m.chrome = builder.add_material(measured_material("Chrome", "metal-chrome", srgb(215, 215, 218), 1.0f, 0.08f));
  m.hard = builder.add_material(measured_material("Plastic", "plastic-matte-black", srgb(28, 28, 29), 0.0f, 0.6f));
  add_seat(&builder, m, "seat", 0.0);
  return builder;
}

/// Outwards by equal steps, so that the seat's shadow falls on vertices that are equally dense.
Primitive make_turntable() {
  constexpr int kRings = 52, kAround = 160;
  constexpr double kRadius = 0.85, kThickness = 0.03;
  return make_grid(kRings + 1, kAround, [](double u, double v) {
    const double rings = u * (kRings + 1), radius = kRadius * std::min(rings / kRings, 1.0),
                 angle = 2.0 * std::numbers::pi * v;
    return Vec3(radius * std::sin(angle), kFloor - kThickness * std::max(rings - kRings, 0.0),
                radius * std::cos(angle));
  });
}

}  // namespace

/// The test scene of surface light fields: a seat in an open box of white walls, a red wall and a mirror wall, below a
/// yellowish lamp. Source: seed 001, Fig. 10.1.
Scene build_seat() {
  SceneBuilder builder = seat_scene("builtin:seat");
  add_box(&builder);
  builder.add_camera("front", {0.75, 1.35, 2.6}, {0.0, 0.72, -0.2}, 36.0);
  builder.add_camera("left", {0.85, 0.95, 1.0}, {-0.1, 0.62, -0.15}, 45.0);
  builder.add_camera("right", {-0.85, 1.0, 1.0}, {0.1, 0.62, -0.15}, 45.0);
  builder.add_camera("cushion", {0.35, 0.95, 0.85}, {0.0, 0.40, -0.05}, 36.0);
  builder.add_camera("top", {0.0, 1.75, 0.75}, {0.0, 0.45, -0.1}, 45.0);
  return std::move(builder.scene());
}

/// The seat on a turntable, for a sky that turns.
Scene build_open_seat() {
  SceneBuilder builder = seat_scene("builtin:open-seat");
  const int grey = builder.add_material(plain_material("Turntable", {0.42f, 0.42f, 0.43f}, 0.0f, 0.9f));
  builder.scene().materials[static_cast<std::size_t>(grey)].specular = 0.0f;
  builder.add_part("turntable", make_turntable(), grey);
  builder.add_camera("front", {1.05, 1.15, 2.05}, {0.0, 0.58, -0.12}, 36.0);
  builder.add_camera("left", {0.85, 0.95, 1.0}, {-0.1, 0.62, -0.15}, 45.0);
  builder.add_camera("back", {-1.2, 1.2, -2.1}, {0.0, 0.58, -0.2}, 36.0);
  builder.add_camera("cushion", {0.35, 0.95, 0.85}, {0.0, 0.40, -0.05}, 36.0);
  return std::move(builder.scene());
}

}  // namespace maquette::builtin
