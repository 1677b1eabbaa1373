#include <algorithm>
#include <cmath>

#include "scenes/cockpit.h"
#include "scenes/cockpit_surface.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

constexpr double kHalfWidth_m = 0.738;
constexpr double kDriver_m = 0.37;  ///< x of the driver

/// 1 behind the steering wheel, 0 elsewhere: where the top pad rises to shade the instruments.
double hood_weight(double x) {
  const double t = (x - kDriver_m) / 0.185;
  return std::exp(-t * t * t * t);
}

/// The fascia wraps towards the doors.
double wrap(double x) { return -0.10 * std::pow(std::abs(x) / kHalfWidth_m, 4.0); }

/// Across the car at u in [0, 1] from right to left, so that rows x columns face the cabin.
double across(double u) { return mix(-kHalfWidth_m, kHalfWidth_m, u); }

Vec3 top_pad(double u, double v) {
  const double x = across(u), h = hood_weight(x), w = wrap(x);
  const double glass = std::min(0.79 - 0.46 * x * x, 0.79);
  const double rise = 0.062 * h, reach = -0.060 * h + w;
  const double base = 0.902 - 0.03 * x * x;
  return b_spline({{x, base - 0.030, glass + 0.01},
                   {x, base - 0.006, glass - 0.03},
                   {x, base + 0.004, mix(glass, 0.44 + w, 0.45)},
                   {x, base + 0.006 + 0.35 * rise, 0.485 + 0.3 * w},
                   {x, base + 0.004 + 0.9 * rise, 0.435 + 0.6 * reach},
                   {x, base + 0.002 + rise, 0.400 + reach},
                   {x, base - 0.010 + rise, 0.382 + reach},
                   {x, base - 0.026 + rise, 0.386 + reach},
                   {x, base - 0.034 + 0.9 * rise, 0.405 + 0.9 * reach},
                   {x, base - 0.046 + 0.2 * rise, 0.430 + w},
                   {x, base - 0.060, 0.432 + w}},
                  v);
}

Vec3 decor_strip(double u, double v) {
  const double x = across(u), w = wrap(x), base = 0.902 - 0.03 * x * x;
  return b_spline({{x, base - 0.058, 0.428 + w},
                   {x, base - 0.064, 0.414 + w},
                   {x, base - 0.085, 0.408 + w},
                   {x, base - 0.105, 0.404 + w},
                   {x, base - 0.118, 0.404 + w},
                   {x, base - 0.124, 0.415 + w}},
                  v);
}

Vec3 lower_pad(double u, double v) {
  const double x = across(u), w = wrap(x), base = 0.902 - 0.03 * x * x;
  return b_spline({{x, base - 0.122, 0.424 + w},
                   {x, base - 0.124, 0.400 + w},
                   {x, base - 0.135, 0.374 + w},
                   {x, base - 0.170, 0.356 + w},
                   {x, base - 0.225, 0.362 + w},
                   {x, base - 0.270, 0.392 + w},
                   {x, base - 0.300, 0.440 + 0.8 * w},
                   {x, base - 0.330, 0.520 + 0.5 * w},
                   {x, 0.50, 0.60},
                   {x, 0.40, 0.66}},
                  v);
}

/// Vent in the xy plane, facing +z: frame, dark inside, slats and a thumb wheel.
struct Vent {
  Primitive frame, inside, slats;
};
Vent make_vent(double width, double height) {
  const double w = width / 2.0, h = height / 2.0;
  const std::vector<Vec2> outline{{-w, -h}, {w, -h}, {w, h}, {-w, h}};
  const Profile ring = round_corners(outline, 0.4 * height, 6, true);
  std::vector<Frame> frames;
  for (const ProfilePoint& q : ring) frames.push_back({{q.position, 0.0}, {q.normal, 0.0}, {0.0, 0.0, 1.0}});
  Vent vent;
  vent.frame = sweep(frames, make_ellipse(0.005, 0.006, 10), true, true);
  vent.inside = transformed(extrude(ring, 0.004, 0.001), translation(0, 0, -0.016));
  const int count = std::max(3, static_cast<int>(std::lround(height / 0.014)));
  for (int i = 0; i < count; ++i) {
    const double y = mix(-h, h, (i + 0.5) / count);
    const double half = std::abs(y) > 0.6 * h ? w - 0.18 * height : w - 0.004;
    append(&vent.slats, transformed(make_rounded_box({2.0 * half, 0.0035, 0.018}, 0.0016, 1),
                                    translation(0, y, -0.006) * rotation(18.0, {1, 0, 0})));
  }
  append(&vent.slats, transformed(make_rounded_box({0.016, 0.010, 0.010}, 0.003, 2), translation(0.1 * w, 0.0, 0.002)));
  return vent;
}

void add_vent(SceneBuilder* builder, const CockpitMaterials& m, const std::string& name, const glm::dmat4& pose,
              double width, double height) {
  const Vent vent = make_vent(width, height);
  builder->add_part(name + "_frame", transformed(vent.frame, pose), m.chrome);
  builder->add_part(name + "_inside", transformed(vent.inside, pose), m.hard);
  builder->add_part(name + "_slats", transformed(vent.slats, pose), m.piano);
}

/// A display `size` wide and high in a thin dark housing; local frame: x right, y up, z towards the viewer.
void add_display(SceneBuilder* builder, const std::string& name, const glm::dmat4& pose, const Vec2& size, int screen,
                 int housing) {
  builder->add_part(name + "_housing",
                    transformed(make_rounded_box({size.x + 0.016, size.y + 0.016, 0.016}, 0.006, 2), pose), housing);
  const Primitive picture = make_quad({-size.x / 2.0, -size.y / 2.0, 0.0086}, {size.x, 0, 0}, {0, size.y, 0}, 8);
  builder->add_part(name, transformed(picture, pose), screen);
}

}  // namespace

void add_dashboard(SceneBuilder* builder, const CockpitMaterials& m) {
  builder->add_part("dashboard_top", make_grid(88, 30, top_pad), m.soft);
  builder->add_part("dashboard_decor", make_grid(64, 8, decor_strip), m.decor);
  builder->add_part("dashboard_lower", make_grid(64, 26, lower_pad), m.trim);
  std::vector<Vec3> seam;
  for (int i = 0; i <= 40; ++i) seam.push_back(decor_strip(i / 40.0, 0.985) + Vec3(0.0, 0.001, -0.004));
  builder->add_part("ambient_strip", make_tube(seam, 0.0022, 6, 80), m.ambient);

  std::vector<Vec3> thread;
  for (int i = 0; i <= 60; ++i) thread.push_back(lower_pad(i / 60.0, 0.235) + Vec3(0.0, 0.0005, -0.0006));
  builder->add_part("dashboard_stitching", make_tube(thread, 0.0012, 5, 90), m.stitch);

  // Displays face the driver's eye.
  const glm::dmat4 cluster = look_at_frame({kDriver_m, 0.868, 0.398}, {kDriver_m, 0.620, 1.20});
  add_display(builder, "cluster_display", cluster, {0.28, 0.105}, m.cluster, m.piano);
  builder->add_part("cluster_base", make_rounded_box({0.22, 0.09, 0.05}, 0.015, 2), m.hard,
                    translation(kDriver_m, 0.845, 0.428));
  const glm::dmat4 center = look_at_frame({0.0, 0.868, 0.356}, {-0.13, 0.72, 1.184});
  add_display(builder, "center_display", center, {0.272, 0.17}, m.center_screen, m.piano);
  builder->add_part("center_display_stem", make_rounded_box({0.10, 0.09, 0.05}, 0.015, 2), m.hard,
                    translation(0.0, 0.855, 0.390));

  for (const double side : {1.0, -1.0}) {
    const double x = side * 0.628;
    const Vec3 at = decor_strip(0.5 + 0.5 * x / kHalfWidth_m, 0.55);
    add_vent(builder, m, side > 0.0 ? "vent_left" : "vent_right",
             look_at_frame(at + Vec3(0, 0, -0.004), at + Vec3(side * 0.35, -0.1, 1.0)), 0.125, 0.054);
  }
  add_vent(builder, m, "vent_center", look_at_frame({0.0, 0.736, 0.352}, {0.0, 0.700, 1.35}), 0.25, 0.044);
  // Glove box line and its handle.
  builder->add_part("glove_box_handle", make_rounded_box({0.11, 0.014, 0.012}, 0.005, 2), m.chrome,
                    translation(-0.38, 0.735, 0.352));
  builder->add_part("dashboard_speaker",
                    transformed(revolve(round_corners({{0.05, 0.0}, {0.05, 0.006}, {0.0, 0.009}}, 0.003, 3, false), 40),
                                translation(0.0, 0.898, 0.60)),
                    m.gunmetal);
}

void add_console(SceneBuilder* builder, const CockpitMaterials& m) {
  // Side view (x: forward, y: up), counter-clockwise.
  const std::vector<Vec2> side{{-0.62, 0.215}, {0.60, 0.215},  {0.60, 0.55},   {0.42, 0.66},
                               {0.375, 0.70},  {0.345, 0.695}, {0.235, 0.605}, {0.02, 0.575},
                               {-0.04, 0.578}, {-0.10, 0.645}, {-0.43, 0.645}, {-0.62, 0.60}};
  const double half = 0.112;
  const Primitive tunnel = extrude(round_corners(side, 0.022, 4, true), 2.0 * half, 0.016, 3);
  // Extrusion runs along +z; the side view's x is the car's z.
  const glm::dmat4 turn(glm::dvec4(0, 0, 1, 0), glm::dvec4(0, 1, 0, 0), glm::dvec4(-1, 0, 0, 0),
                        glm::dvec4(half, 0, 0, 1));
  builder->add_part("console", transformed(tunnel, turn), m.trim);
  const auto plate = [&](const char* name, const Vec3& at, const Vec3& size, double tilt_deg, double radius,
                         int material) {
    builder->add_part(name, make_rounded_box(size, radius, 2), material,
                      translation(at.x, at.y, at.z) * rotation(tilt_deg, {1, 0, 0}));
  };
  plate("climate_panel", {0.0, 0.652, 0.290}, {0.20, 0.010, 0.125}, -39.0, 0.004, m.piano);
  plate("console_plate", {0.0, 0.590, 0.112}, {0.196, 0.010, 0.225}, -8.0, 0.004, m.decor);
  plate("armrest", {0.0, 0.655, -0.265}, {0.226, 0.045, 0.345}, 0.0, 0.020, m.seat);
  // Climate knobs on the sloped panel.
  const Primitive knob =
      revolve(round_corners({{0.021, 0.0}, {0.019, 0.016}, {0.014, 0.018}, {0.0, 0.018}}, 0.003, 3, false), 40);
  for (int i = 0; i < 3; ++i)
    builder->add_part("climate_knob_" + std::to_string(i),
                      transformed(knob, translation(-0.062 + 0.062 * i, 0.657, 0.286) * rotation(-39.0, {1, 0, 0})),
                      i == 1 ? m.brushed : m.chrome);
  for (const double x : {-0.043, 0.043}) {
    const Primitive cup = revolve(
        round_corners({{0.040, 0.0}, {0.040, 0.005}, {0.034, 0.005}, {0.033, -0.004}, {0.0, -0.004}}, 0.002, 2, false),
        40);
    builder->add_part(x < 0 ? "cup_holder_right" : "cup_holder_left",
                      transformed(cup, translation(x, 0.598, 0.165) * rotation(-8.0, {1, 0, 0})), m.chrome);
  }
  builder->add_part(
      "gear_selector_boot",
      transformed(
          revolve(round_corners({{0.034, 0.0}, {0.032, 0.006}, {0.016, 0.018}, {0.012, 0.03}}, 0.004, 3, false), 32),
          translation(0.0, 0.588, 0.058)),
      m.piano);
  builder->add_part("gear_selector", make_rounded_box({0.036, 0.072, 0.048}, 0.016, 2), m.seat,
                    translation(0.0, 0.640, 0.055) * rotation(14.0, {1, 0, 0}));
  builder->add_part("gear_selector_cap", make_rounded_box({0.030, 0.006, 0.040}, 0.003, 2), m.chrome,
                    translation(0.0, 0.676, 0.064) * rotation(14.0, {1, 0, 0}));
  builder->add_part("drive_dial", transformed(knob, translation(0.062, 0.586, 0.050) * rotation(-8.0, {1, 0, 0})),
                    m.brushed);
  builder->add_part(
      "start_button",
      transformed(revolve(round_corners({{0.016, 0.0}, {0.016, 0.005}, {0.0, 0.007}}, 0.002, 3, false), 32),
                  translation(-0.062, 0.588, 0.052) * rotation(-8.0, {1, 0, 0})),
      m.caliper);
}

}  // namespace maquette::builtin
