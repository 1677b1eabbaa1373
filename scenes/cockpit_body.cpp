#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/angles.h"
#include "scenes/cockpit.h"
#include "scenes/cockpit_surface.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

constexpr double kGap_m = 0.0035;  ///< between the rims of two parts
constexpr double kRim_m = 0.003;   ///< a rim ends so far outside its cut
constexpr double kSeal_m = 0.010;  ///< depth of what closes the gaps
constexpr double kPaneInset_m = 0.004;

Field inverted(const Field& f) {
  return [f](const Vec3& p) { return -f(p); };
}
Field grown(const Field& f, double by) {
  return [f, by](const Vec3& p) { return f(p) - by; };
}
Primitive symmetric(const Primitive& left) {
  Primitive whole = left;
  append(&whole, mirrored_x(left));
  return whole;
}

/// The same surface with additional vertices along `line`, so that a field whose gradient changes there is cut at the
/// right positions even if its band is narrower than the triangles.
Primitive scored(const Primitive& surface, const Field& line) {
  return merged({clip(surface, line), clip(surface, inverted(line))});
}

/// Angle about the front (rear) end of the car, 0 straight ahead (back), growing to the left flank; degrees.
double heading_deg(const Vec3& p, bool front) {
  return std::atan2(p.x, front ? p.z - 1.25 : -1.50 - p.z) * 180.0 / std::numbers::pi;
}

double head_lamp(const Vec3& p) {
  if (p.z < 1.4) return 1.0;
  const double a = heading_deg(p, true), middle = 0.548 + 0.0024 * (a - 30.0);
  const double half = mix(0.026, 0.040, smoother(28.0, 48.0, a));
  return smooth_max(std::abs(p.y - middle) - half, (std::abs(a - 45.5) - 15.5) * 0.016, 0.03);
}

double grille(const Vec3& p) {
  if (p.z < 1.4) return 1.0;
  const double side = (p.x - 0.47 + 0.30 * (p.y - 0.30)) * 0.96;
  return smooth_max(side, std::abs(p.y - 0.325) - 0.088, 0.06);
}

double side_intake(const Vec3& p) {
  if (p.z < 1.4) return 1.0;
  const double a = heading_deg(p, true);
  return smooth_max((std::abs(a - 45.0 - 40.0 * (0.36 - p.y)) - 4.5) * 0.016, std::abs(p.y - 0.345) - 0.085, 0.05);
}

double nose_slot(const Vec3& p) {
  if (p.z < 1.4) return 1.0;
  return smooth_max(std::abs(p.y - 0.530) - 0.013, p.x - 0.40, 0.012);
}

double tail_lamp_middle(const Vec3& p) { return p.y - 0.822; }

double tail_lamp(const Vec3& p) {
  if (p.z > -1.55) return 1.0;
  const double a = heading_deg(p, false);
  const double half = mix(0.014, 0.030, smoother(20.0, 48.0, a));
  return smooth_max(std::abs(tail_lamp_middle(p)) - half, (a - 72.0) * 0.012, 0.03);
}

double diffuser(const Vec3& p) {
  if (p.z > -1.6) return 1.0;
  return smooth_max(p.y - 0.385, p.x - 0.60 - 0.3 * (p.y - 0.3), 0.05);
}

double front_bumper(const Vec3& p) { return 1.70 + 0.75 * std::max(p.y - 0.49, -0.2) - p.z; }
double rear_bumper(const Vec3& p) { return std::max(p.z + 1.70 + 0.45 * std::max(p.y - 0.49, -0.2), p.y - 0.615); }

double boot_lid(const Vec3& p) {
  if (p.z > -1.4) return 1.0;
  const double lower = smooth_max(smooth_max(p.x - 0.66, 0.625 - p.y, 0.08), p.z + 1.70, 0.08);
  return smooth_max(lower, 0.030 - rear_glass_outline(p), 0.02);
}

double cladding(const Vec3& p) { return p.y - 0.215; }

constexpr double kBeltFront_m = 0.375, kBeltBack_m = -1.36;

/// Height over the strip between door and side glass, and that strip.
double above_belt(const Vec3& p) { return p.y - belt_height(p.z) + 0.004; }
Primitive belt_strip(const Primitive& skin) {
  const Field length = [](const Vec3& p) { return std::max(p.z - kBeltFront_m, kBeltBack_m - p.z); };
  return clip(clip_band(skin, above_belt, -0.0085, 0.0085), length);
}
/// `skin` without that strip.
Primitive without_belt_strip(const Primitive& skin) {
  const Field front = [](const Vec3& p) { return kBeltFront_m - p.z; };
  const Field back = [](const Vec3& p) { return p.z - kBeltBack_m; };
  const Primitive middle = clip(clip(skin, inverted(front)), inverted(back));
  Primitive rest = merged({clip(skin, front), clip(skin, back)});
  append(&rest, clip(middle, [](const Vec3& p) { return above_belt(p) + 0.0085; }));
  append(&rest, clip(middle, [](const Vec3& p) { return 0.0085 - above_belt(p); }));
  return rest;
}

Primitive pane(const Primitive& skin, const Field& outline, double overlap) {
  return offset(clip(skin, grown(outline, overlap)), -kPaneInset_m - 0.004);
}

BezierPatch make_windshield(int material) {
  // The chart's bow is quadratic, and so are the sides, which follow the opening 2 mm behind its edge: degree 2 x 4,
  // which a bicubic patch approximates within 0.01 mm.
  const PaneChart& chart = windshield_chart();
  const double s0 = -0.475, s1 = 0.385, bottom = 0.763, middle = 0.7042, top = 0.612;
  const auto side = [&](double v) {
    return (1.0 - v) * (1.0 - 2.0 * v) * bottom + 4.0 * v * (1.0 - v) * middle + v * (2.0 * v - 1.0) * top;
  };
  const auto point = [&](double u, double v) {
    return chart.point((2.0 * u - 1.0) * side(v), mix(s0, s1, v)) - 0.006 * chart.normal;
  };
  const double t[4] = {0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0};
  // Bezier control values from samples at 0, 1/3, 2/3 and 1.
  const auto control = [](const std::array<Vec3, 4>& f) {
    return std::array<Vec3, 4>{f[0], (-5.0 * f[0] + 18.0 * f[1] - 9.0 * f[2] + 2.0 * f[3]) / 6.0,
                               (2.0 * f[0] - 9.0 * f[1] + 18.0 * f[2] - 5.0 * f[3]) / 6.0, f[3]};
  };
  std::array<std::array<Vec3, 4>, 4> rows{};
  for (std::size_t i = 0; i < 4; ++i)
    rows[i] = control({point(t[0], t[i]), point(t[1], t[i]), point(t[2], t[i]), point(t[3], t[i])});
  BezierPatch patch;
  patch.name = "windshield";
  patch.material = material;
  for (std::size_t j = 0; j < 4; ++j) {
    const std::array<Vec3, 4> column = control({rows[0][j], rows[1][j], rows[2][j], rows[3][j]});
    for (std::size_t i = 0; i < 4; ++i) patch.points[4 * i + j] = glm::vec3(column[i]);
  }
  return patch;
}

void add_glazing(SceneBuilder* builder, const CockpitMaterials& m, const Primitive& skin) {
  builder->add_patch(make_windshield(m.glass));
  add_pair(builder, "side_glass", pane(skin, side_glass_outline, 0.010), m.glass);
  builder->add_part("rear_glass", symmetric(pane(skin, rear_glass_outline, 0.010)), m.glass);
  const Rim thin{0.002, 0.006, 2};
  // Black borders of the panes, the pillar between door and quarter glass, and the bright frame.
  builder->add_part("windshield_border", symmetric(offset(clip_band(skin, windshield_outline, -0.022, 0.004), -0.0035)),
                    m.piano);
  builder->add_part("rear_glass_border", symmetric(offset(clip_band(skin, rear_glass_outline, -0.035, 0.004), -0.0035)),
                    m.piano);
  add_pair(builder, "side_glass_border", offset(clip_band(skin, side_glass_outline, -0.012, 0.004), -0.0035), m.piano);
  const Field pillar = [](const Vec3& p) { return p.z + 0.69 - 0.25 * (p.y - 0.95); };
  add_pair(builder, "b_pillar_cover",
           offset(clip(clip_band(skin, pillar, -0.045, 0.045), grown(side_glass_outline, 0.002)), -0.0025), m.piano);
  add_pair(builder, "window_frame", clip_band(offset(skin, 0.0015), side_glass_outline, 0.0, 0.011, &thin), m.chrome);
}

void add_lamps(SceneBuilder* builder, const CockpitMaterials& m, const Primitive& skin) {
  add_pair(builder, "head_lamp_lens", offset(clip(skin, head_lamp), -0.002), m.lens);
  add_pair(builder, "head_lamp_housing", offset(clip(skin, grown(head_lamp, 0.004)), -0.045), m.piano);
  const Field height = [](const Vec3& p) { return p.y - 0.528 - 0.0024 * (heading_deg(p, true) - 30.0); };
  const Field length = [](const Vec3& p) { return std::max(head_lamp(p) + 0.006, 33.0 - heading_deg(p, true)); };
  add_pair(builder, "running_lamp", offset(clip(clip_band(skin, height, -0.0055, 0.0055), length), -0.012),
           m.daylight_lamp);
  for (int i = 0; i < 3; ++i) {
    // Projector bowls along the lamp.
    const double a = radians(37.0 + 7.5 * i), y = 0.562 + 0.0024 * (37.0 + 7.5 * i - 30.0);
    double r = 0.5;
    while (lower_body({r * std::sin(a), y, 1.25 + r * std::cos(a)}) < 0.0) r += 0.002;
    r -= 0.038;
    const Primitive bowl = revolve(
        round_corners({{0.0, -0.01}, {0.012, -0.008}, {0.021, 0.012}, {0.024, 0.012}, {0.024, -0.02}}, 0.003, 2, false),
        24);
    const glm::dmat4 pose = translation(r * std::sin(a), y, 1.25 + r * std::cos(a)) *
                            rotation(a * 180.0 / std::numbers::pi * 0.4, {0, 1, 0}) * rotation(90.0, {1, 0, 0});
    add_pair(builder, "projector_" + std::to_string(i), transformed(flipped(bowl), pose), m.chrome);
    add_pair(builder, "projector_lens_" + std::to_string(i), transformed(make_sphere(0.013, 6), pose), m.mirror);
  }
  const Rim rim{0.003, 0.01, 2};
  const Primitive lamp = offset(scored(skin, tail_lamp_middle), -0.001);
  builder->add_part("tail_lamp", symmetric(clip(lamp, grown(tail_lamp, -0.004), &rim)), m.tail_lamp);
}

void add_nose(SceneBuilder* builder, const CockpitMaterials& m, const Primitive& skin) {
  const Field openings = [](const Vec3& p) { return std::min({grille(p), side_intake(p), nose_slot(p)}); };
  builder->add_part("grille_back", symmetric(offset(clip(skin, grown(openings, 0.012)), -0.035)), m.hard);
  const Rim rim{0.003, 0.012, 2};
  const Primitive recessed = clip(offset(skin, -0.012), grown(grille, 0.03));
  Primitive bars;
  for (int i = 0; i < 5; ++i) {
    const double y = 0.255 + 0.035 * i;
    const Field height = [y](const Vec3& p) { return p.y - y; };
    append(&bars, clip_band(clip(recessed, grown(grille, 0.012)), height, -0.005, 0.005, &rim));
  }
  builder->add_part("grille_bars", symmetric(bars), m.gunmetal);
  builder->add_part(
      "badge",
      transformed(
          revolve(round_corners({{0.038, 0.0}, {0.038, 0.006}, {0.030, 0.008}, {0.0, 0.009}}, 0.003, 3, false), 40),
          translation(0.0, 0.53, 2.186) * rotation(84.0, {1, 0, 0})),
      m.chrome);
}

void add_tail(SceneBuilder* builder, const CockpitMaterials& m, const Primitive& skin) {
  const Field plate = [](const Vec3& p) {
    return smooth_max(p.x - 0.26, std::abs(p.y - 0.70) - 0.055, 0.01) + (p.z > -1.5 ? 1.0 : 0.0);
  };
  const Rim rim{0.002, 0.006, 2};
  builder->add_part("licence_plate", symmetric(clip(offset(skin, 0.004), plate, &rim)), m.headliner);
  const Primitive pipe = revolve(
      round_corners({{0.036, -0.10}, {0.042, -0.10}, {0.042, 0.012}, {0.036, 0.012}, {0.036, -0.10}}, 0.003, 2, false),
      32);
  add_pair(builder, "exhaust", transformed(pipe, translation(0.47, 0.255, -2.06) * rotation(-90.0, {1, 0, 0})),
           m.chrome);
}

/// Roof lining and pillar covers: the skin from inside, with its edges bent outwards to the panes.
Primitive make_lining(const Primitive& skin) {
  const Field cabin = [](const Vec3& p) {
    return std::max({belt_height(p.z) - 0.06 - p.y, canopy(p) - 0.02, -1.95 - p.z});
  };
  const double depth = 0.034;
  Primitive inner = flipped(offset(clip(skin, cabin), -depth));
  const Rim turned{0.006, 0.026, 2};
  for (const Field& opening : {Field(side_glass_outline), Field(windshield_outline), Field(rear_glass_outline)})
    inner = clip(
        inner, [&](const Vec3& p) { return 0.004 - opening(p + depth * skin_normal(p)); }, &turned);
  return symmetric(inner);
}

/// Dark inside of bonnet and wings, which the driver sees over the dashboard.
Primitive make_cowl(const Primitive& skin) {
  const Field region = [](const Vec3& p) {
    return std::max({0.48 - p.z, p.z - 1.9, 0.72 - p.y, -0.002 - windshield_outline(p), -side_glass_outline(p)});
  };
  return symmetric(flipped(offset(clip(skin, region), -0.012)));
}

/// Panel between bonnet and windshield, lower than the skin there.
Primitive make_scuttle(const Primitive& skin) {
  const Field region = [](const Vec3& p) {
    return std::max({windshield_outline(p) - 0.012, 0.008 - windshield_chart().height(p), 0.45 - p.z});
  };
  const Rim lip{0.002, 0.024, 1};
  return symmetric(clip(offset(skin, -0.0045), region, &lip));
}

/// Strips below the gaps between parts, so that the gaps are dark lines from all sides.
Primitive make_seals(const Primitive& skin) {
  const Field openings = [](const Vec3& p) {
    return -std::min({head_lamp(p), tail_lamp(p), wheel_arches(p), windshield_outline(p), rear_glass_outline(p),
                      side_glass_outline(p), grille(p), side_intake(p)});
  };
  Primitive seals;
  for (const Field& outline : {Field(hood_outline), Field(front_bumper), Field(rear_bumper), Field(boot_lid)})
    append(&seals, clip(clip_band(skin, outline, -0.020, 0.012), openings));
  return symmetric(offset(seals, -kSeal_m));
}

/// Closes the cabin towards the engine: otherwise the driver would see the road below the bonnet.
Primitive make_bulkhead() {
  const Primitive plane = make_quad({0.0, 0.2, 0.9}, {0.0, 0.85, 0.0}, {0.95, 0.0, 0.0}, 24);
  return symmetric(clip(plane, [](const Vec3& p) { return car_body(p) + 0.016; }));
}

}  // namespace

void add_body(SceneBuilder* builder, const CockpitMaterials& m) {
  const Primitive skin = make_half_skin();
  const Rim opening{0.004, 0.010, 2}, shut{kRim_m, 0.016, 2}, arch{0.006, 0.045, 2};
  Primitive body = clip(skin, inverted(side_glass_outline), &opening);
  body = clip(body, inverted(windshield_outline), &opening);
  body = clip(body, inverted(rear_glass_outline), &opening);
  body = clip(body, inverted(wheel_arches), &arch);
  body = clip(body, inverted(grown(door_outline, kGap_m + kRim_m)), &shut);
  body = without_belt_strip(body);

  const auto split = [&](const Field& outline, Primitive* rest) {
    const Primitive part = clip(*rest, grown(outline, -kGap_m - 2.0 * kRim_m), &shut);
    *rest = clip(*rest, inverted(outline), &shut);
    return part;
  };
  Primitive cladding_part = clip(body, cladding);
  body = clip(body, inverted(cladding));
  Primitive diffuser_part = clip(body, grown(diffuser, -0.002), &shut);
  body = clip(body, inverted(diffuser), &shut);
  append(&cladding_part, diffuser_part);
  builder->add_part("hood", symmetric(split(hood_outline, &body)), m.paint);
  const Rim deep{0.003, 0.045, 2};
  body = clip(body, inverted(head_lamp), &deep);
  body = clip(scored(body, tail_lamp_middle), inverted(tail_lamp), &opening);
  Primitive nose = split(front_bumper, &body);
  for (const Field& hole : {Field(grille), Field(side_intake), Field(nose_slot)})
    nose = clip(nose, inverted(hole), &deep);
  builder->add_part("front_bumper", symmetric(nose), m.paint);
  builder->add_part("rear_bumper", symmetric(split(rear_bumper, &body)), m.paint);
  builder->add_part("boot_lid", symmetric(split(boot_lid, &body)), m.paint);
  builder->add_part("body", symmetric(body), m.paint);
  builder->add_part("cladding", symmetric(cladding_part), m.hard);
  builder->add_part("belt_trim", symmetric(belt_strip(skin)), m.chrome);

  add_glazing(builder, m, skin);
  add_lamps(builder, m, skin);
  add_nose(builder, m, skin);
  add_tail(builder, m, skin);
  builder->add_part("shut_seals", make_seals(skin), m.hard);
  builder->add_part("scuttle", make_scuttle(skin), m.hard);
  builder->add_part("cowl", make_cowl(skin), m.hard);
  builder->add_part("bulkhead", make_bulkhead(), m.hard);
  builder->add_part("roof_lining", make_lining(skin), m.headliner);
}

}  // namespace maquette::builtin
