#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/cockpit.h"
#include "scenes/cockpit_surface.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

/// Floor from the rear bench to the pedals and up the bulkhead; u from right to left, v from back to front.
Vec3 floor_pan(double u, double v) {
  const double x = mix(-0.80, 0.80, u);
  return b_spline({{x, 0.36, -1.10},
                   {x, 0.30, -1.00},
                   {x, 0.216, -0.95},
                   {x, 0.214, -0.60},
                   {x, 0.214, -0.20},
                   {x, 0.214, 0.20},
                   {x, 0.214, 0.52},
                   {x, 0.226, 0.62},
                   {x, 0.32, 0.70},
                   {x, 0.45, 0.76},
                   {x, 0.60, 0.80},
                   {x, 0.86, 0.82}},
                  v);
}

void add_rear_bench(SceneBuilder* builder, const CockpitMaterials& m) {
  const auto pad = [&](const std::string& name, const Vec3& size, double radius, const glm::dmat4& pose, int material) {
    builder->add_part(name, make_rounded_box(size, radius, 4), material, pose);
  };
  pad("rear_cushion_left", {0.56, 0.16, 0.46}, 0.055, translation(0.315, 0.375, -1.02) * rotation(-8.0, {1, 0, 0}),
      m.seat);
  pad("rear_cushion_right", {0.56, 0.16, 0.46}, 0.055, translation(-0.315, 0.375, -1.02) * rotation(-8.0, {1, 0, 0}),
      m.seat);
  pad("rear_back_left", {0.56, 0.54, 0.14}, 0.055, translation(0.315, 0.655, -1.30) * rotation(-25.0, {1, 0, 0}),
      m.seat);
  pad("rear_back_right", {0.56, 0.54, 0.14}, 0.055, translation(-0.315, 0.655, -1.30) * rotation(-25.0, {1, 0, 0}),
      m.seat);
  pad("rear_console", {0.12, 0.30, 0.60}, 0.03, translation(0.0, 0.36, -1.05), m.trim);
  for (const double side : {1.0, -1.0}) {
    const std::string suffix = side > 0.0 ? "_left" : "_right";
    pad("rear_insert" + suffix, {0.32, 0.42, 0.05}, 0.022,
        translation(side * 0.315, 0.665, -1.236) * rotation(-25.0, {1, 0, 0}), m.insert);
    pad("rear_cushion_insert" + suffix, {0.32, 0.05, 0.38}, 0.022,
        translation(side * 0.315, 0.445, -1.00) * rotation(-8.0, {1, 0, 0}), m.insert);
    pad("rear_headrest" + suffix, {0.24, 0.11, 0.085}, 0.038,
        translation(side * 0.315, 0.945, -1.40) * rotation(-20.0, {1, 0, 0}), m.seat);
  }
  // Shelf under the rear glass and the bulkhead below it.
  builder->add_part("parcel_shelf", make_quad({-0.70, 0.905, -1.36}, {1.40, 0, 0}, {0, 0.045, -0.52}, 6), m.carpet);
  builder->add_part("rear_bulkhead", make_quad({-0.75, 0.20, -1.13}, {1.50, 0, 0}, {0, 0.72, -0.33}, 4), m.carpet);
}

/// Points of the inner side from the sill up, on the left; `armrest` 0..1 pushes the rest into the cabin.
Vec3 side_trim(double z, double v) {
  const double armrest = smoother(-0.62, -0.45, z) * smoother(0.42, 0.15, z),
               pocket = smoother(-0.60, -0.40, z) * smoother(0.62, 0.45, z);
  const double top = belt_height(z) - 0.002 - 0.08 * smoother(0.36, 0.56, z),
               narrow = canopy_side({0.0, 0.95, z}) + 0.793;
  const auto at = [&](double x, double y) { return Vec3(x - narrow, y, z); };
  return b_spline({at(0.800, 0.20),
                   at(0.770, 0.235),
                   at(0.735 - 0.02 * pocket, 0.26),
                   at(0.725 - 0.050 * pocket, 0.30),
                   at(0.722 - 0.056 * pocket, 0.36),
                   at(0.722 - 0.050 * pocket, 0.42),
                   at(0.724 - 0.012 * pocket, 0.46),
                   at(0.728, 0.52),
                   at(0.728 - 0.006 * armrest, 0.57),
                   at(0.722 - 0.035 * armrest, 0.605),
                   at(0.722 - 0.075 * armrest, 0.630),
                   at(0.722 - 0.085 * armrest, 0.662),
                   at(0.722 - 0.068 * armrest, 0.684),
                   at(0.724 - 0.020 * armrest, 0.690),
                   at(0.730, 0.715),
                   at(0.734, std::min(0.77, top - 0.105)),
                   at(0.732, std::min(0.82, top - 0.08)),
                   at(0.722, std::min(0.858, top - 0.055)),
                   at(0.714, std::min(0.885, top - 0.032)),
                   at(0.722, top - 0.012),
                   at(0.748, top + 0.001),
                   at(0.775, top - 0.004),
                   at(0.782, top - 0.03)},
                  v);
}

/// Part of the side between v0 and v1; rows forward, columns up: the outside of the grid faces the cabin.
Primitive make_side_trim(double z0, double z1, int nz, double v0, double v1, int nv) {
  return make_grid(nz, nv, [=](double u, double v) { return side_trim(mix(z0, z1, u), mix(v0, v1, v)); });
}

void add_door_trim(SceneBuilder* builder, const CockpitMaterials& m) {
  const double lower = 0.36, upper = 0.70;
  add_pair(builder, "door_trim_lower", make_side_trim(-0.655, 0.70, 44, 0.0, lower, 18), m.hard);
  add_pair(builder, "door_trim_middle", make_side_trim(-0.655, 0.70, 44, lower, upper, 24), m.trim);
  add_pair(builder, "door_trim_upper", make_side_trim(-0.655, 0.70, 44, upper, 1.0, 18), m.soft);
  add_pair(builder, "quarter_trim_lower", make_side_trim(-1.42, -0.665, 24, 0.0, lower, 14), m.hard);
  add_pair(builder, "quarter_trim_middle", make_side_trim(-1.42, -0.665, 24, lower, upper, 16), m.trim);
  add_pair(builder, "quarter_trim_upper", make_side_trim(-1.42, -0.665, 24, upper, 1.0, 14), m.soft);
  // Decor blade with the light line under it, pull handle, window switches, loudspeaker.
  const auto blade = [](double u, double v) {
    return side_trim(mix(-0.60, 0.62, u), mix(0.672, 0.700, v)) -
           Vec3(0.006 * std::sin(std::numbers::pi * std::clamp(v, 0.0, 1.0)), 0, 0);
  };
  add_pair(builder, "door_decor", make_grid(44, 6, blade), m.decor);
  std::vector<Vec3> line;
  for (int i = 0; i <= 24; ++i) line.push_back(side_trim(mix(-0.58, 0.60, i / 24.0), 0.666) - Vec3(0.003, 0, 0));
  add_pair(builder, "door_ambient", make_tube(line, 0.002, 6, 48), m.ambient);
  add_pair(builder, "door_pull",
           make_tube({{0.728, 0.742, 0.30},
                      {0.690, 0.748, 0.27},
                      {0.682, 0.752, 0.20},
                      {0.682, 0.752, 0.12},
                      {0.690, 0.748, 0.05},
                      {0.730, 0.742, 0.02}},
                     0.009, 14, 40),
           m.chrome);
  Primitive switches;
  for (int i = 0; i < 3; ++i)
    append(&switches,
           transformed(make_rounded_box({0.024, 0.010, 0.036}, 0.004, 2), translation(0.668, 0.687, 0.10 - 0.05 * i)));
  add_pair(builder, "window_switches", switches, m.piano);
  const Primitive speaker =
      revolve(round_corners({{0.078, 0.0}, {0.078, 0.008}, {0.066, 0.010}, {0.0, 0.013}}, 0.003, 3, false), 48);
  add_pair(builder, "door_speaker", transformed(speaker, translation(0.712, 0.395, 0.53) * rotation(90.0, {0, 0, 1})),
           m.gunmetal);
}

/// A reflector in the plane z = 0 of `pose`, facing +z; `size` in metres.
BezierPatch flat_patch(const std::string& name, const glm::dmat4& pose, const glm::dvec2& size, int material) {
  BezierPatch patch;
  patch.name = name;
  patch.material = material;
  for (std::size_t i = 0; i < 16; ++i) {
    const glm::dvec2 at = size * (glm::dvec2(i % 4, i / 4) / 3.0 - 0.5);
    patch.points[i] = glm::vec3(pose * glm::dvec4(at, 0.0, 1.0));
  }
  return patch;
}

void add_overhead(SceneBuilder* builder, const CockpitMaterials& m) {
  // Halfway between the driver's eye and the rear window, which he sees in it.
  const Vec3 at(0.0, 1.222, 0.125), rear_window(0.0, 1.10, -1.55);
  const glm::dmat4 mirror =
      look_at_frame(at, at - glm::normalize(kDriverEye_m - at) - glm::normalize(rear_window - at));
  builder->add_part("interior_mirror_housing", make_rounded_box({0.245, 0.070, 0.030}, 0.0149, 2), m.piano,
                    mirror * translation(0, 0, -0.010));
  builder->add_part("interior_mirror_rim", make_rounded_box({0.236, 0.062, 0.006}, 0.0029, 2), m.piano,
                    mirror * translation(0, 0, 0.0035));
  builder->add_patch(flat_patch("interior_mirror", mirror * translation(0, 0, 0.0068), {0.226, 0.052}, m.mirror));
  builder->add_part("interior_mirror_stem",
                    make_tube({{0.0, 1.232, 0.135}, {0.0, 1.252, 0.155}, {0.0, 1.272, 0.160}}, 0.009, 12, 8), m.hard);
  add_pair(builder, "sun_visor",
           transformed(make_rounded_box({0.31, 0.016, 0.13}, 0.007, 2),
                       translation(0.325, 1.248, -0.015) * rotation(12.0, {1, 0, 0})),
           m.headliner);
  builder->add_part("overhead_console", make_rounded_box({0.15, 0.030, 0.17}, 0.012, 2), m.hard,
                    translation(0.0, 1.290, -0.04) * rotation(7.0, {1, 0, 0}));
  Primitive lamps;
  for (const double x : {-0.035, 0.035})
    append(&lamps, transformed(make_rounded_box({0.045, 0.006, 0.045}, 0.0029, 2),
                               translation(x, 1.274, -0.055) * rotation(7.0, {1, 0, 0})));
  builder->add_part("reading_lamps", lamps, m.lens);
}

void add_footwell(SceneBuilder* builder, const CockpitMaterials& m) {
  builder->add_part("floor_carpet", make_grid(24, 40, floor_pan, {false, false, {1, 1}, true}), m.carpet);
  const auto pedal = [&](const char* name, double x, double y, double z, const Vec2& size) {
    builder->add_part(name, make_rounded_box({size.x, size.y, 0.012}, 0.005, 2), m.brushed,
                      translation(x, y, z) * rotation(35.0, {1, 0, 0}));
  };
  pedal("pedal_brake", 0.36, 0.375, 0.60, {0.085, 0.060});
  pedal("pedal_throttle", 0.235, 0.345, 0.615, {0.050, 0.140});
  pedal("foot_rest", 0.555, 0.330, 0.640, {0.080, 0.200});
  add_pair(builder, "floor_mat",
           transformed(make_rounded_box({0.44, 0.010, 0.52}, 0.0049, 2), translation(0.40, 0.219, 0.33)), m.rubber);
}

}  // namespace

void add_cabin(SceneBuilder* builder, const CockpitMaterials& m) {
  add_footwell(builder, m);
  add_door_trim(builder, m);
  add_rear_bench(builder, m);
  add_overhead(builder, m);
}

}  // namespace maquette::builtin
