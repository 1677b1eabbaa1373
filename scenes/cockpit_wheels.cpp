#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/cockpit.h"
#include "scenes/cockpit_surface.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

// Modelled about +Y, outside upwards; y = 0 is the middle of the tyre.
constexpr double kTyreHalfWidth_m = 0.118;
constexpr double kRimRadius_m = 0.246;

Primitive make_tyre() {
  const double w = kTyreHalfWidth_m, r = kWheelRadius_m;
  std::vector<Vec2> outline{
      {kRimRadius_m - 0.004, -w + 0.022}, {kRimRadius_m + 0.012, -w + 0.006}, {r - 0.045, -w}, {r - 0.012, -w + 0.010}};
  outline.push_back({r - 0.001, -w + 0.035});
  for (const double groove : {-0.045, -0.002, 0.041}) {
    outline.push_back({r, groove - 0.006});
    outline.push_back({r - 0.008, groove - 0.005});
    outline.push_back({r - 0.008, groove + 0.005});
    outline.push_back({r, groove + 0.006});
  }
  outline.push_back({r - 0.001, w - 0.035});
  outline.push_back({r - 0.012, w - 0.010});
  outline.push_back({r - 0.045, w});
  outline.push_back({kRimRadius_m + 0.012, w - 0.006});
  outline.push_back({kRimRadius_m - 0.004, w - 0.022});
  return revolve(round_corners(outline, 0.014, 1, false), 50);
}

Primitive make_rim_barrel() {
  const double w = kTyreHalfWidth_m, r = kRimRadius_m;
  const std::vector<Vec2> outline{{r - 0.030, -w + 0.02}, {r + 0.001, -w + 0.015}, {r + 0.002, -w + 0.02}};
  Primitive barrel = revolve(round_corners({{r + 0.003, w - 0.020},
                                            {r + 0.003, w - 0.008},
                                            {r - 0.010, w - 0.010},
                                            {r - 0.022, w - 0.035},
                                            {r - 0.034, -w + 0.03}},
                                           0.006, 2, false),
                             64);
  return barrel;
}

/// One blade from hub to rim, leaning by `spread` at the rim.
Primitive make_blade(double spread) {
  std::vector<Frame> frames;
  const int n = 7;
  for (int i = 0; i <= n; ++i) {
    const double t = static_cast<double>(i) / n, r = mix(0.035, kRimRadius_m - 0.014, t);
    const double angle = spread * t, height = 0.070 + 0.026 * t * t - 0.012 * std::sin(std::numbers::pi * t);
    const Vec3 out(std::sin(angle), 0.0, std::cos(angle));
    const double width = mix(0.034, 0.019, smoother(0.0, 0.7, t)) + 0.012 * smoother(0.85, 1.0, t);
    frames.push_back({out * r + Vec3(0.0, height - 0.02, 0.0),
                      Vec3(0, 1, 0),
                      glm::normalize(glm::cross(out, Vec3(0, 1, 0))),
                      {1.0, width / 0.03}});
  }
  const Profile section =
      round_corners({{-0.022, -0.010}, {0.020, -0.015}, {0.020, 0.015}, {-0.022, 0.010}}, 0.007, 2, true);
  return sweep(frames, section, true, false);
}

Primitive make_spokes() {
  Primitive spokes;
  for (int i = 0; i < 5; ++i)
    for (const double side : {-1.0, 1.0})
      append(&spokes,
             transformed(make_blade(side * 0.25), rotation(72.0 * i, {0, 1, 0}) * rotation(side * 7.0, {0, 1, 0})));
  append(&spokes,
         revolve(round_corners({{0.062, 0.02}, {0.066, 0.062}, {0.052, 0.078}, {0.034, 0.080}}, 0.008, 3, false), 48));
  for (int i = 0; i < 5; ++i)
    append(&spokes,
           transformed(revolve(round_corners({{0.008, 0.0}, {0.008, 0.012}, {0.0, 0.012}}, 0.002, 2, false), 12),
                       rotation(72.0 * i + 36.0, {0, 1, 0}) * translation(0.0, 0.070, 0.050)));
  return spokes;
}

/// Wheel housing: half a drum above the wheel and its inner disc.
Primitive make_housing(double z) {
  const auto drum = [&](double u, double v) {
    const double a = mix(-0.25, std::numbers::pi + 0.25, u), r = kArchRadius_m + 0.012;
    return Vec3(mix(0.48, 0.875, v), kWheelRadius_m + r * std::sin(a), z + r * std::cos(a));
  };
  Primitive housing = make_grid(40, 1, drum);
  const auto wall = [&](double u, double v) {
    const double a = mix(-0.25, std::numbers::pi + 0.25, u), r = v * (kArchRadius_m + 0.012);
    return Vec3(0.48, kWheelRadius_m + r * std::sin(a), z + r * std::cos(a));
  };
  append(&housing, make_grid(40, 1, wall));
  return housing;
}

/// Coordinate of a grid line of the ground at t in [0, 1]: evenly spaced under and around the car, where shadows have
/// edges (visibility is baked at the vertices), with growing distance outside.
double ground_line_m(double t, double fine_half_m) {
  constexpr double kFineShare = 0.7, kHalf_m = 15.0;
  const double s = 2.0 * t - 1.0, outside = std::max(0.0, std::abs(s) - kFineShare) / (1.0 - kFineShare);
  const double slope_m = fine_half_m * (1.0 - kFineShare) / kFineShare;
  const double rest_m = kHalf_m - fine_half_m - slope_m;
  return std::copysign(
      fine_half_m * std::min(std::abs(s) / kFineShare, 1.0) + slope_m * outside + rest_m * outside * outside * outside,
      s);
}

}  // namespace

void add_wheels(SceneBuilder* builder, const CockpitMaterials& m) {
  const glm::dmat4 axle = rotation(-90.0, {0, 0, 1});
  Primitive cap = revolve(round_corners({{0.034, 0.074}, {0.034, 0.084}, {0.0, 0.087}}, 0.004, 3, false), 32);
  Primitive disc =
      revolve(round_corners({{0.05, 0.0}, {0.175, 0.0}, {0.175, 0.020}, {0.08, 0.020}, {0.08, 0.036}, {0.0, 0.036}},
                            0.002, 1, false),
              48);
  const auto on_axle = [&](const Primitive& p) { return transformed(p, axle); };
  std::vector<int> parts;
  const char* corner[4] = {"front_left", "front_right", "rear_left", "rear_right"};
  const double track = 0.782;
  for (int i = 0; i < 4; ++i) {
    const bool right = i % 2 == 1;
    const double z = i < 2 ? kAxleFront_m : kAxleRear_m;
    const glm::dmat4 at =
        translation(right ? -track : track, kWheelRadius_m, z) * rotation(right ? 180.0 : 0.0, {0, 1, 0});
    const std::string suffix = std::string("_") + corner[i];
    if (i == 0) {
      parts = {builder->add_part("tyre" + suffix, on_axle(make_tyre()), m.rubber, at),
               builder->add_part("rim" + suffix, on_axle(make_rim_barrel()), m.gunmetal, at),
               builder->add_part("spokes" + suffix, on_axle(make_spokes()), m.brushed, at),
               builder->add_part("hub_cap" + suffix, on_axle(cap), m.piano, at),
               builder->add_part("brake_disc" + suffix, on_axle(disc), m.disc, at)};
    } else {
      const char* names[5] = {"tyre", "rim", "spokes", "hub_cap", "brake_disc"};
      for (std::size_t k = 0; k < 5; ++k) builder->add_instance(names[k] + suffix, parts[k], at);
    }
    const double back = i < 2 ? -1.0 : 1.0;
    builder->add_part("caliper" + suffix, make_rounded_box({0.075, 0.20, 0.075}, 0.018, 2), m.caliper,
                      translation(right ? -track - 0.018 : track + 0.018, kWheelRadius_m + 0.015, z + back * 0.155));
  }
  add_pair(builder, "wheel_housing_front", make_housing(kAxleFront_m), m.hard);
  add_pair(builder, "wheel_housing_rear", make_housing(kAxleRear_m), m.hard);
}

void add_ground(SceneBuilder* builder, const CockpitMaterials& m) {
  constexpr double kTile_m = 1.5;
  Primitive ground =
      make_grid(96, 120, [](double u, double v) { return Vec3(ground_line_m(u, 2.8), 0.0, -ground_line_m(v, 4.4)); });
  for (std::size_t i = 0; i < ground.positions.size(); ++i)
    ground.uvs[0][i] = glm::vec2(ground.positions[i].x, ground.positions[i].z) / static_cast<float>(kTile_m);
  builder->add_part("ground", std::move(ground), m.asphalt);
}

}  // namespace maquette::builtin
