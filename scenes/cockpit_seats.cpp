#include <algorithm>
#include <cmath>

#include "scenes/angles.h"
#include "scenes/builtin.h"
#include "scenes/cockpit.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

/// Half of a seat's cross-section: (distance from the middle as a share of the half width, height share of the
/// bolster).
constexpr double kAcross[5] = {0.22, 0.52, 0.68, 0.86, 1.0};
constexpr double kBolster[5] = {-0.05, 0.0, 0.72, 1.0, 0.25};

/// One ring of a cushion: x across, second coordinate from the back face to the sitting face.
struct SeatRing {
  double along;    ///< position along the cushion
  double half;     ///< half width
  double face;     ///< sitting face in the middle
  double bolster;  ///< how far the side bolsters stand above it
  double back;     ///< back face
};

/// Converts rings to cage points; `to_point(along, x, height)`. The sitting face runs towards +x for travel x (+x) =
/// height.
std::vector<Vec3> seat_points(const std::vector<SeatRing>& rings,
                              const std::function<Vec3(double, double, double)>& to_point) {
  std::vector<Vec3> points;
  for (const SeatRing& r : rings) {
    for (int j = 0; j < 10; ++j) {
      const int k = j < 5 ? 4 - j : j - 5;
      const double side = j < 5 ? -1.0 : 1.0;
      points.push_back(to_point(r.along, side * kAcross[k] * r.half, r.face + kBolster[k] * r.bolster));
    }
    for (int j = 9; j >= 0; --j) {
      const int k = j < 5 ? 4 - j : j - 5;
      const double side = j < 5 ? -1.0 : 1.0;
      points.push_back(
          to_point(r.along, side * kAcross[k] * r.half * 0.97, r.back + (k == 4 ? 0.3 * (r.face - r.back) : 0.0)));
    }
  }
  return points;
}

/// Quilted pad of `flutes` pipes between two heights of a seat face.
std::vector<Vec3> quilt_points(double from, double to, int flutes, const std::function<Vec3(double, double)>& face,
                               const std::function<Vec3(double)>& normal, double half) {
  std::vector<Vec3> points;
  const double shares[6] = {-1.0, -0.93, -0.38, 0.38, 0.93, 1.0};
  const auto ring = [&](double along, double height) {
    const Vec3 n = normal(along);
    for (const double s : shares) {
      const bool rim = std::abs(s) > 0.99;
      points.push_back(face(along, s * half) + n * (rim ? -0.010 : height));
    }
    for (int j = 5; j >= 0; --j) points.push_back(face(along, shares[j] * half) - n * 0.030);
  };
  ring(from, -0.008);
  for (int i = 0; i < flutes; ++i) {
    const double a = mix(from, to, static_cast<double>(i) / flutes), step = (to - from) / flutes;
    ring(a + 0.16 * step, 0.014);
    ring(a + 0.84 * step, 0.014);
    if (i + 1 < flutes) ring(a + step, -0.006);
  }
  ring(to, -0.008);
  return points;
}

double interpolate(const std::vector<SeatRing>& rings, double along, double SeatRing::*value) {
  std::size_t i = 0;
  while (i + 2 < rings.size() && along > rings[i + 1].along) ++i;
  const double t = std::clamp((along - rings[i].along) / (rings[i + 1].along - rings[i].along), 0.0, 1.0);
  return mix(rings[i].*value, rings[i + 1].*value, t);
}

}  // namespace

void add_seat(SceneBuilder* builder, const CockpitMaterials& m, const std::string& name, double x0) {
  const glm::dmat4 at = translation(x0, 0.0, 0.0);
  // Cushion: along +z from back to front, heights are y.
  const std::vector<SeatRing> cushion{{-0.41, 0.235, 0.335, 0.010, 0.240}, {-0.38, 0.255, 0.352, 0.045, 0.225},
                                      {-0.25, 0.266, 0.356, 0.082, 0.220}, {-0.05, 0.270, 0.380, 0.092, 0.220},
                                      {0.10, 0.270, 0.405, 0.078, 0.222},  {0.20, 0.266, 0.416, 0.052, 0.232},
                                      {0.245, 0.258, 0.402, 0.022, 0.250}, {0.26, 0.240, 0.370, 0.004, 0.285}};
  const auto on_cushion = [](double z, double x, double y) { return Vec3(x, y, z); };
  builder->add_cage(name + "_cushion", make_ring_cage(seat_points(cushion, on_cushion), 20, 2), m.seat, at);
  const auto cushion_face = [&](double z, double x) {
    return Vec3(x, interpolate(cushion, z, &SeatRing::face) - 0.008, z);
  };
  builder->add_cage(
      name + "_cushion_insert",
      make_ring_cage(quilt_points(
                         -0.33, 0.215, 5, cushion_face, [](double) { return Vec3(0.0, 0.98, -0.12); }, 0.152),
                     12, 2),
      m.insert, at);

  // Backrest: along the recline, heights point forward.
  const double recline = radians(23.0);
  const Vec3 hinge(0.0, 0.335, -0.385), up(0.0, std::cos(recline), -std::sin(recline)),
      forward(0.0, std::sin(recline), std::cos(recline));
  const std::vector<SeatRing> back{
      {-0.03, 0.205, 0.010, 0.010, -0.085}, {0.00, 0.232, 0.018, 0.045, -0.105},   {0.13, 0.255, 0.030, 0.105, -0.118},
      {0.30, 0.270, 0.018, 0.120, -0.120},  {0.45, 0.268, 0.004, 0.092, -0.112},   {0.55, 0.245, -0.002, 0.050, -0.100},
      {0.61, 0.200, -0.008, 0.020, -0.092}, {0.645, 0.165, -0.016, 0.006, -0.084}, {0.655, 0.135, -0.030, 0.0, -0.072}};
  const auto on_back = [&](double along, double x, double h) {
    return hinge + Vec3(-x, 0.0, 0.0) + along * up + h * forward;
  };
  builder->add_cage(name + "_backrest", make_ring_cage(seat_points(back, on_back), 20, 2), m.seat, at);
  const auto back_face = [&](double along, double x) {
    return on_back(along, x, interpolate(back, along, &SeatRing::face) - 0.004);
  };
  builder->add_cage(name + "_backrest_insert",
                    make_ring_cage(quilt_points(
                                       0.06, 0.55, 5, back_face, [&](double) { return forward; }, 0.140),
                                   12, 2),
                    m.insert, at);

  const std::vector<SeatRing> head{{0.658, 0.105, 0.000, 0.0, -0.055},   {0.668, 0.132, 0.016, 0.010, -0.074},
                                   {0.74, 0.146, 0.034, 0.026, -0.082},  {0.81, 0.140, 0.030, 0.020, -0.074},
                                   {0.850, 0.118, 0.012, 0.006, -0.058}, {0.858, 0.092, -0.006, 0.0, -0.046}};
  builder->add_cage(name + "_headrest", make_ring_cage(seat_points(head, on_back), 20, 2), m.seat, at);
  Primitive posts;
  for (const double x : {-0.05, 0.05})
    append(&posts,
           make_tube({on_back(0.58, x, -0.045), on_back(0.64, x, -0.04), on_back(0.70, x, -0.035)}, 0.006, 12, 4));
  builder->add_part(name + "_headrest_posts", posts, m.chrome, at);

  // Rails, side cover with its lever.
  Primitive base;
  for (const double x : {-0.19, 0.19})
    append(&base, transformed(make_rounded_box({0.045, 0.030, 0.56}, 0.008, 2), translation(x, 0.232, -0.08)));
  for (const double x : {-0.262, 0.262})
    append(&base, transformed(make_rounded_box({0.022, 0.075, 0.44}, 0.010, 2), translation(x, 0.275, -0.12)));
  builder->add_part(name + "_base", base, m.hard, at);
}

}  // namespace maquette::builtin
