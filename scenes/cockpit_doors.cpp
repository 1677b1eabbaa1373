#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/cockpit.h"
#include "scenes/cockpit_surface.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

constexpr int kColumns = 23;  ///< along the car
constexpr int kRows = 14;     ///< upwards

/// z of the door's front or back edge at a height.
double door_edge_z(double y, bool front) {
  double inside = front ? 0.3 : -0.4, outside = front ? 1.0 : -1.0;
  for (int i = 0; i < 40; ++i) {
    const double z = 0.5 * (inside + outside);
    (door_outline({0.9, y, z}) < 0.0 ? inside : outside) = z;
  }
  return 0.5 * (inside + outside);
}

/// Control points whose B-spline surface passes through the flank at the grid's points, with a folded edge all round.
SubdivisionCage make_door_cage() {
  const int columns = kRows + 2, rows = kColumns + 2;
  const auto index = [&](int i, int j) { return static_cast<std::size_t>(i * columns + j); };
  const auto fraction = [](int i, int n) {
    // 0: fold, 1: edge, 2: supporting loop, then even steps; mirrored at the other end.
    const double support = 0.016;
    if (i <= 1) return 0.0;
    if (i >= n) return 1.0;
    return mix(support, 1.0 - support, static_cast<double>(i - 2) / (n - 3));
  };
  std::vector<Vec3> target(static_cast<std::size_t>(rows * columns));
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const double u = fraction(i, rows - 2), v = fraction(j, columns - 2);
      const double z_mid = mix(-0.60, 0.68, u), y = mix(0.236, belt_height(z_mid) - 0.0135, v);
      const double y_edge = std::clamp(y, 0.28, belt_height(z_mid) - 0.05);
      const double z = mix(door_edge_z(y_edge, false), door_edge_z(y_edge, true), u);
      const bool fold = i == 0 || i == rows - 1 || j == 0 || j == columns - 1;
      const double top = mix(0.236, belt_height(z) - 0.0135, v);
      target[index(i, j)] = {flank_x(top, z) - (fold ? 0.028 : 0.0), top, z};
    }
  }
  std::vector<Vec3> points = target;
  for (int pass = 0; pass < 4; ++pass) {
    std::vector<Vec3> next = points;
    for (int i = 2; i < rows - 2; ++i) {
      for (int j = 2; j < columns - 2; ++j) {
        Vec3 limit(0.0);
        const double weight[3] = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};
        for (int a = -1; a <= 1; ++a)
          for (int b = -1; b <= 1; ++b) limit += weight[a + 1] * weight[b + 1] * points[index(i + a, j + b)];
        next[index(i, j)].x += (target[index(i, j)] - limit).x;
      }
    }
    points = std::move(next);
  }
  return make_grid_cage(points, columns, false, false, 2);
}

void turn_faces(SubdivisionCage* cage) {
  for (std::size_t at = 0; at + 3 < cage->face_indices.size(); at += 4)
    std::swap(cage->face_indices[at + 1], cage->face_indices[at + 3]);
}

SubdivisionCage mirrored_cage(const SubdivisionCage& left) {
  SubdivisionCage right = left;
  for (glm::vec3& p : right.positions) p.x = -p.x;
  turn_faces(&right);
  return right;
}

/// Superellipsoid with half axes `size`; an exponent below 1 fills the corners.
Primitive make_pebble(const Vec3& size, double exponent, int n) {
  const auto power = [exponent](double c) { return std::copysign(std::pow(std::abs(c), exponent), c); };
  return make_grid(
      2 * n, n,
      [=](double u, double v) {
        const double a = 2.0 * std::numbers::pi * u, b = std::numbers::pi * (v - 0.5), c = power(std::cos(b));
        return Vec3(size.x * c * power(std::sin(a)), size.y * power(std::sin(b)), size.z * c * power(std::cos(a)));
      },
      {true, false, {1, 1}, false});
}

void add_exterior_mirror(SceneBuilder* builder, const CockpitMaterials& m) {
  const glm::dmat4 pose = translation(0.962, 0.995, 0.310) * rotation(16.0, {0, 1, 0});
  const Field front = [](const Vec3& p) { return -0.040 - p.z; };
  const Rim rim{0.005, 0.010, 3};
  Primitive housing = clip(make_pebble({0.112, 0.070, 0.110}, 0.72, 18), front, &rim);
  add_pair(builder, "mirror_housing", transformed(housing, pose), m.paint);
  Primitive glass =
      extrude(round_corners({{-0.098, -0.056}, {0.098, -0.056}, {0.098, 0.056}, {-0.098, 0.056}}, 0.042, 8, true),
              0.004, 0.001, 1);
  add_pair(
      builder, "mirror_glass",
      // Rotated so that the driver sees the scene behind the car in it.
      transformed(glass, pose * translation(0, 0, -0.046) * rotation(185.6, {0, 1, 0}) * rotation(-3.4, {1, 0, 0})),
      m.mirror);
  add_pair(builder, "mirror_foot",
           transformed(make_rounded_box({0.17, 0.026, 0.060}, 0.012, 2),
                       translation(0.862, 0.938, 0.322) * rotation(18.0, {0, 0, 1})),
           m.piano);
}

void add_handle(SceneBuilder* builder, const CockpitMaterials& m) {
  std::vector<Vec3> path;
  for (int i = 0; i <= 8; ++i) {
    const double z = mix(-0.575, -0.375, i / 8.0), bow = std::sin(std::numbers::pi * i / 8.0);
    path.push_back({flank_x(0.765, z) + 0.004 + 0.016 * std::sqrt(bow), 0.765, z});
  }
  Primitive bar;
  append(&bar, transformed(make_tube(path, 0.010, 14, 40), translation(0, 0, 0)));
  add_pair(builder, "door_handle", bar, m.chrome);
}

}  // namespace

void add_doors(SceneBuilder* builder, const CockpitMaterials& m) {
  SubdivisionCage left = make_door_cage();
  turn_faces(&left);  // rows run forwards and columns up, which faces the cabin
  builder->add_cage("door_front_left", left, m.paint);
  builder->add_cage("door_front_right", mirrored_cage(left), m.paint);
  add_exterior_mirror(builder, m);
  add_handle(builder, m);
}

}  // namespace maquette::builtin
