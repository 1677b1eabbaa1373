#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/angles.h"
#include "scenes/cockpit.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

constexpr double kSteeringRadius_m = 0.176;

/// Angle a from the top, clockwise as the driver sees it; the bottom of the rim is flattened.
Vec3 rim_centre(double a) {
  const Vec3 p(kSteeringRadius_m * std::sin(a), kSteeringRadius_m * std::cos(a), 0.0);
  const double floor = -0.150;
  return {p.x, smooth_max(p.y, floor, 0.05), 0.0};
}

Frame rim_frame(double a) {
  const Vec3 p = rim_centre(a), tangent = glm::normalize(rim_centre(a + 1e-4) - rim_centre(a - 1e-4));
  const Vec3 out = glm::normalize(glm::cross(tangent, Vec3(0, 0, -1)));
  // Thumb rests at ten to two.
  const double thumb = std::exp(-std::pow((std::abs(std::remainder(a, 2.0 * std::numbers::pi)) - 1.05) / 0.22, 2.0));
  return {p, out, Vec3(0, 0, 1), {1.0 + 0.16 * thumb, 1.0 + 0.10 * thumb}};
}

/// Seen from the driver: x right, y up, z towards the driver.
Primitive make_rim() {
  std::vector<Frame> frames;
  for (int i = 0; i < 128; ++i) frames.push_back(rim_frame(-2.0 * std::numbers::pi * i / 128));
  return sweep(frames, make_ellipse(0.0145, 0.0165, 20), true, true);
}

/// Flat blade from the hub to the rim along `direction_deg` (clockwise from the top).
Primitive make_spoke(double direction_deg, double hub_width, double rim_width, double lift) {
  const double a = radians(direction_deg);
  const Vec3 out(std::sin(a), std::cos(a), 0.0), side(out.y, -out.x, 0.0);
  const double end = glm::length(rim_centre(a)) - 0.003;
  std::vector<Frame> frames;
  const int n = 10;
  for (int i = 0; i <= n; ++i) {
    const double t = static_cast<double>(i) / n;
    const double width = mix(hub_width, rim_width, smoother(0.0, 0.8, t)) + 0.012 * smoother(0.8, 1.0, t);
    frames.push_back({out * mix(0.045, end, t) + Vec3(0, 0, lift * std::pow(1.0 - t, 1.5)),
                      side,
                      Vec3(0, 0, 1),
                      {width / 0.04, 1.0}});
  }
  const Profile section =
      round_corners({{-0.020, -0.007}, {0.020, -0.007}, {0.020, 0.007}, {-0.020, 0.007}}, 0.005, 3, true);
  return sweep(frames, section, true, false);
}

/// Cushion of the airbag: a shield with a full, soft face.
SubdivisionCage make_hub_cage() {
  const std::vector<Vec2> outline{{-0.066, 0.044}, {-0.030, 0.056},  {0.0, 0.058},     {0.030, 0.056},
                                  {0.066, 0.044},  {0.074, 0.010},   {0.056, -0.044},  {0.030, -0.070},
                                  {0.0, -0.074},   {-0.030, -0.070}, {-0.056, -0.044}, {-0.074, 0.010}};
  std::vector<Vec3> points;
  const double scales[6] = {0.80, 1.0, 1.06, 1.04, 0.86, 0.45},
               heights[6] = {-0.030, -0.022, 0.006, 0.026, 0.040, 0.046};
  for (int i = 0; i < 6; ++i)
    for (const Vec2& q : outline) points.push_back({scales[i] * q.x, scales[i] * q.y, heights[i]});
  SubdivisionCage cage = make_grid_cage(points, static_cast<int>(outline.size()), false, true, 2);
  // Strips between opposite points close the face.
  const int first = 5 * 12;
  for (const auto& [a, b, c, d] : {std::array<int, 4>{0, 1, 10, 11}, {1, 2, 9, 10}, {2, 3, 8, 9}, {3, 4, 7, 8}}) {
    cage.face_sizes.push_back(4);
    cage.face_indices.insert(cage.face_indices.end(), {first + d, first + c, first + b, first + a});
  }
  cage.face_sizes.push_back(4);
  cage.face_indices.insert(cage.face_indices.end(), {first + 4, first + 7, first + 6, first + 5});
  return cage;
}

}  // namespace

void add_steering_wheel(SceneBuilder* builder, const CockpitMaterials& m) {
  const double tilt = radians(24.0);
  const Vec3 centre(0.37, 0.785, 0.205), towards(0.0, std::sin(tilt), -std::cos(tilt));
  const glm::dmat4 wheel = look_at_frame(centre, centre - towards);
  builder->add_part("steering_wheel_rim", make_rim(), m.soft, wheel);
  builder->add_cage("steering_wheel_hub", make_hub_cage(), m.soft, wheel);
  Primitive spokes = make_spoke(97.0, 0.060, 0.036, 0.012);
  append(&spokes, make_spoke(-97.0, 0.060, 0.036, 0.012));
  append(&spokes, make_spoke(180.0, 0.052, 0.036, 0.012));
  builder->add_part("steering_wheel_spokes", spokes, m.hard, wheel);
  Primitive inlay;
  for (const double side : {-1.0, 1.0})
    append(&inlay, transformed(make_rounded_box({0.062, 0.026, 0.008}, 0.0039, 2),
                               translation(side * 0.106, -0.012, 0.013) * rotation(side * 4.0, {0, 1, 0})));
  append(&inlay, transformed(make_rounded_box({0.030, 0.052, 0.008}, 0.0039, 2),
                             translation(0.0, -0.112, 0.012) * rotation(-4.0, {1, 0, 0})));
  builder->add_part("steering_wheel_inlays", inlay, m.brushed, wheel);
  Primitive buttons;
  for (const double side : {-1.0, 1.0})
    for (int i = 0; i < 2; ++i)
      append(&buttons, transformed(make_rounded_box({0.018, 0.014, 0.006}, 0.0028, 2),
                                   translation(side * (0.095 + 0.022 * i), -0.012, 0.0175)));
  builder->add_part("steering_wheel_buttons", buttons, m.piano, wheel);
  builder->add_part("steering_wheel_badge",
                    revolve(round_corners({{0.020, 0.0}, {0.020, 0.004}, {0.0, 0.006}}, 0.002, 3, false), 36), m.chrome,
                    wheel * translation(0.0, 0.0, 0.0385) * rotation(90.0, {1, 0, 0}));
  // Column shroud, shift paddles and stalks.
  builder->add_part("steering_column", make_rounded_box({0.105, 0.095, 0.24}, 0.034, 5), m.hard,
                    wheel * translation(0.0, -0.006, -0.165));
  Primitive paddles;
  for (const double side : {-1.0, 1.0})
    append(&paddles, transformed(make_rounded_box({0.042, 0.070, 0.005}, 0.0029, 2),
                                 translation(side * 0.112, 0.034, -0.032) * rotation(side * -14.0, {0, 0, 1})));
  builder->add_part("shift_paddles", paddles, m.gunmetal, wheel);
  Primitive stalks = make_tube({{0.045, 0.0, -0.075}, {0.12, 0.012, -0.075}, {0.185, 0.022, -0.068}}, 0.009, 12, 12);
  append(&stalks, make_tube({{-0.045, 0.0, -0.075}, {-0.12, 0.012, -0.075}, {-0.185, 0.022, -0.068}}, 0.009, 12, 12));
  builder->add_part("stalks", stalks, m.hard, wheel);
}

}  // namespace maquette::builtin
