#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "scenes/scene.h"

/// Solid modelling for the built-in scenes: parametric grids, lathes, sweeps and rounded solids in double precision,
/// metres, +Y up. Every surface has exact or finite-difference normals that agree with the winding (counter-clockwise
/// outside).
namespace maquette::modelling {

using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;

/// Linear sRGB from display-encoded 8-bit values.
glm::vec3 srgb(int r, int g, int b);
/// 0 at edge0, 1 at edge1, C2 in between.
double smoother(double edge0, double edge1, double x);
double mix(double a, double b, double t);

/// Natural cubic spline through (x, y) knots of increasing x: C2, so that highlights stay smooth at the knots. Linear
/// outside.
class Curve {
 public:
  Curve(std::initializer_list<Vec2> knots);
  double operator()(double x) const;

 private:
  std::vector<Vec2> knots_;
  std::vector<double> second_derivatives_;  ///< at the knots
};

/// Maximum and minimum with a C2 transition of width k: intersection and union of implicit solids with a rounded edge.
/// Source: Quilez 2013, smooth minimum (cubic polynomial).
double smooth_max(double a, double b, double k);
double smooth_min(double a, double b, double k);

/// Uniform cubic B-spline with clamped ends: t in [0, 1] runs from the first to the last point.
Vec3 b_spline(const std::vector<Vec3>& points, double t);

using SurfaceFunction = std::function<Vec3(double u, double v)>;

struct GridOptions {
  bool wrap_u = false;
  bool wrap_v = false;
  Vec2 uv_scale{1.0, 1.0};  ///< texture coordinates are (u, v) times this
  bool flip = false;        ///< reverses the orientation; without it the outside is d/du x d/dv
};

/// (nu x nv) quads over [0, 1]^2; normals from central differences of `f`, stepping inside at poles.
Primitive make_grid(int nu, int nv, const SurfaceFunction& f, const GridOptions& options = {});

/// Sphere of equal-angle cube faces, n quads along each edge; normals are the exact directions.
Primitive make_sphere(double radius, int n);
/// Box of full size `size` around the origin with edges rounded by `radius` (k quads per quarter turn).
Primitive make_rounded_box(const Vec3& size, double radius, int k = 3);
/// Flat quad from corner `origin` along a and b (outside a x b), n x n quads, UV 0..uv_scale.
Primitive make_quad(const Vec3& origin, const Vec3& a, const Vec3& b, int n = 1, const Vec2& uv_scale = {1.0, 1.0});

/// Point of a planar outline with its unit outward normal.
struct ProfilePoint {
  Vec2 position{};
  Vec2 normal{};
};
using Profile = std::vector<ProfilePoint>;

/// Polyline with arcs of `radius` (shortened where edges are short) at its corners, `k` segments an arc.
/// Normals point to the right of the direction of travel (outwards for a counter-clockwise closed outline).
Profile round_corners(const std::vector<Vec2>& points, double radius, int k, bool closed);
/// Ellipse, counter-clockwise.
Profile make_ellipse(double rx, double ry, int n);

/// Lathe about +Y: profile (radius, height), travelling upwards for an outside that faces away from the axis.
Primitive revolve(const Profile& profile, int segments, double from_rad = 0.0, double to_rad = 2.0 * std::numbers::pi);

/// Pose of a profile: profile x along `x`, profile y along `y`.
struct Frame {
  Vec3 origin{};
  Vec3 x{};
  Vec3 y{};
  Vec2 scale{1.0, 1.0};
};
/// Moves a counter-clockwise profile along frames (outside: the profile's normals).
/// `caps` closes both ends with fans about the frames' origins.
Primitive sweep(const std::vector<Frame>& frames, const Profile& profile, bool closed_profile, bool closed_path,
                bool caps = false);
/// Tube around a polyline that is smoothed by Catmull-Rom, `radius_m` at every point.
Primitive make_tube(const std::vector<Vec3>& path, double radius_m, int around, int along, bool caps = true);
/// Extrudes a closed counter-clockwise outline (star-shaped about its centroid) in the xy plane from z = 0 to `depth`,
/// with edges rounded by `bevel`.
Primitive extrude(const Profile& outline, double depth, double bevel, int k = 2);

/// Signed function of a point; clipping keeps where it is negative.
using Field = std::function<double(const Vec3&)>;

/// Shape of the rim of a cut: rounded by `radius_m`, then turned inwards by `depth_m`. The rim ends `radius_m` outside
/// the cut.
struct Rim {
  double radius_m = 0.003;
  double depth_m = 0.012;
  int segments = 2;
};

/// The part of `surface` where `field` < 0, with new vertices on the edges of its triangles; `rim` shapes the edge if
/// given.
Primitive clip(const Primitive& surface, const Field& field, const Rim* rim = nullptr);
/// The strip of `surface` where from < field < to. Uses two cuts, so that it may be narrower than the triangles.
Primitive clip_band(const Primitive& surface, const Field& field, double from, double to, const Rim* rim = nullptr);
/// Divides triangles until no edge is longer than `longest_m`: what is baked by vertex needs vertices on flat faces
/// too.
void split_long_edges(Primitive* surface, double longest_m);
/// Every vertex moved by `distance_m` along its normal.
Primitive offset(const Primitive& surface, double distance_m);

/// Catmull-Clark cage of quads from a grid of control points with `columns` per row, optionally closed in either
/// direction; the outside is d/drow x d/dcolumn.
SubdivisionCage make_grid_cage(const std::vector<Vec3>& points, int columns, bool wrap_rows, bool wrap_columns,
                               int levels);
/// Closed cage from rings of `columns` points each (outside: travel x column direction); both ends are closed by strips
/// between point i and point columns - 1 - i. `columns` is even.
SubdivisionCage make_ring_cage(const std::vector<Vec3>& points, int columns, int levels);

void append(Primitive* into, const Primitive& other);
Primitive merged(const std::vector<Primitive>& parts);
Primitive transformed(const Primitive& primitive, const glm::dmat4& matrix);
Primitive flipped(const Primitive& primitive);
/// The part mirrored in the x = 0 plane, rewound.
Primitive mirrored_x(const Primitive& primitive);
/// UVs from the position in metres: (x, z), (z, y) or (x, y), for the plane that is most perpendicular to the normal,
/// times `scale`.
void map_box_uvs(Primitive* primitive, double scale);

glm::dmat4 translation(double x, double y, double z);
glm::dmat4 rotation(double degrees, const Vec3& axis);
/// Parent-from-local frame with columns right, up, backward at `origin`: local -Z looks towards `target`.
glm::dmat4 look_at_frame(const Vec3& origin, const Vec3& target, const Vec3& up = {0.0, 1.0, 0.0});

/// Builds a Scene: every call adds a node below the root.
class SceneBuilder {
 public:
  explicit SceneBuilder(const std::string& name) { scene_.name = name; }
  int add_material(const Material& material);
  int material(const std::string& name) const;
  int add_image(const TextureImage& image);
  /// Adds one mesh with one primitive and its node; returns the node.
  int add_part(const std::string& name, Primitive primitive, int material, const glm::dmat4& pose = glm::dmat4(1.0));
  /// Another node of the mesh of `node`.
  int add_instance(const std::string& name, int node, const glm::dmat4& pose);
  int add_cage(const std::string& name, const SubdivisionCage& cage, int material,
               const glm::dmat4& pose = glm::dmat4(1.0));
  int add_patch(const BezierPatch& patch);
  void add_camera(const std::string& name, const Vec3& eye, const Vec3& target, double fov_y_deg);
  void add_empty(const std::string& name, const Vec3& position);
  Scene& scene() { return scene_; }

 private:
  int add_node(Node node);
  Scene scene_;
};

/// A measured material of the library, with a similar analytic material for viewers that do not know it.
Material measured_material(const std::string& name, const std::string& library_name, const glm::vec3& base_color,
                           float metallic, float roughness);
Material plain_material(const std::string& name, const glm::vec3& base_color, float metallic, float roughness);

/// Periodic gradient noise in [-1, 1]: `period` lattice cells each way, a fixed hash of `seed`.
double tileable_noise(double x, double y, int period, unsigned seed);
/// Sum of octaves of tileable_noise, halving in amplitude.
double tileable_fbm(double x, double y, int period, int octaves, unsigned seed);

}  // namespace maquette::modelling
