#include "render/bezier/patch_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <numeric>

#include "render/bezier/point_cloud.h"
#include "render/bezier/reflector_patch.h"
#include "render/bezier/sheets.h"
#include "scenes/parallel.h"
#include "scenes/subdivision_patches.h"

namespace maquette {

namespace {

using bezier_double::bezier_jet;
using bezier_double::bezier_position;
using bezier_double::SurfaceJet;

constexpr std::size_t kMaxPatchesPerSheet = 32, kMinTriangles = 16;
constexpr std::size_t kMaxPoints = 6000;  // of the equation system; the distances are measured at all vertices

using Surface = bezier_double::BezierSurface;

/// Parameters of the nearest point of the patch, each within `limit`, by Gauss-Newton. The start must be close.
glm::dvec2 foot_point(const Surface& s, const glm::dvec3& p, glm::dvec2 x, double limit) {
  for (int k = 0; k < 4; ++k) {
    const SurfaceJet jet = bezier_jet(s, x);
    const glm::dvec3 d = p - jet.p;
    const double xx = glm::dot(jet.dx, jet.dx), xy = glm::dot(jet.dx, jet.dy), yy = glm::dot(jet.dy, jet.dy);
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 1e-14 * (xx + yy) * (xx + yy))) break;
    const double gx = glm::dot(jet.dx, d), gy = glm::dot(jet.dy, d);
    const glm::dvec2 step((yy * gx - xy * gy) / determinant, (xx * gy - xy * gx) / determinant);
    x = glm::clamp(x + glm::clamp(step, -0.3, 0.3), -limit, limit);
  }
  return x;
}

using Row = std::array<double, 16>;  // factors of the 16 coefficients in a linear form of the surface

Row products(const std::array<double, 4>& x, const std::array<double, 4>& y) {
  Row out;
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i < 4; ++i) out[4 * j + i] = x[i] * y[j];
  return out;
}
std::array<double, 4> powers(double x) { return {1.0, x, x * x, x * x * x}; }
std::array<double, 4> slopes(double x) { return {0.0, 1.0, 2.0 * x, 3.0 * x * x}; }

/// Weight of the point distance, and of the smoothness term for what the points leave undetermined.
struct Weights {
  double point = 1.0, bending = 1e-10;
};

/// Least squares: the coefficients that minimise the distances along `normals`, with a small weight all distances, and,
/// with `normal_weights`, the deviation of the tangents from the plane of the mesh's normals.
Surface solve(const Cloud& cloud, const std::vector<glm::dvec2>& feet, const std::vector<glm::dvec3>& normals,
              const std::vector<double>& normal_weights, const Weights& weights) {
  const std::vector<glm::dvec3>& points = cloud.points;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(48, 48);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(48);
  const std::size_t stride = 1 + points.size() / kMaxPoints;
  for (std::size_t n = 0; n < points.size(); n += stride) {
    const std::array<double, 4> x = powers(feet[n].x), y = powers(feet[n].y);
    const Row b = products(x, y), bx = products(slopes(feet[n].x), y), by = products(x, slopes(feet[n].y));
    const Eigen::Vector3d normal(normals[n].x, normals[n].y, normals[n].z), p(points[n].x, points[n].y, points[n].z);
    const Eigen::Matrix3d share =
        normal * normal.transpose() * (1.0 - weights.point) + weights.point * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d target = share * p;
    Eigen::Matrix3d slope = Eigen::Matrix3d::Zero();
    if (normal_weights[n] > 0.0) {
      const Eigen::Vector3d m(cloud.normals[n].x, cloud.normals[n].y, cloud.normals[n].z);
      slope = normal_weights[n] * m * m.transpose();
    }
    for (int i = 0; i < 16; ++i) {
      const auto ki = static_cast<std::size_t>(i);
      right.segment<3>(3 * i) += b[ki] * target;
      for (int j = i; j < 16; ++j) {
        const auto kj = static_cast<std::size_t>(j);
        matrix.block<3, 3>(3 * i, 3 * j) += b[ki] * b[kj] * share + (bx[ki] * bx[kj] + by[ki] * by[kj]) * slope;
      }
    }
  }
  const double bending = weights.bending * static_cast<double>(points.size());
  for (int k = 0; k < 16; ++k) {
    const double degree = k % 4 + k / 4;
    for (int c = 0; c < 3; ++c) matrix(3 * k + c, 3 * k + c) += bending * (degree > 1.0 ? degree * degree : 1e-3);
  }
  const Eigen::VectorXd solved = matrix.selfadjointView<Eigen::Upper>().ldlt().solve(right);
  Surface s{};
  for (int k = 0; k < 16; ++k) s.c[k] = {solved(3 * k), solved(3 * k + 1), solved(3 * k + 2)};
  return s;
}

struct Distances {
  double largest = 0.0, sum2 = 0.0;
  double misfit = 0.0;  ///< sum of squared distances and squared normal angles, each divided by its tolerance
};

/// Angle between the normals of mesh and patch above which another patch is preferred, rad.
constexpr double kNormalTolerance_rad = 0.02;
/// Limits of one vertex's errors, in tolerances, so that a few wrong vertices do not decide the fit.
constexpr double kMaxDistanceError = 30.0, kMaxNormalError = 3.0;

/// Angle between the mesh's normal and the surface's, ignoring their orientation; 0 where one of them is undefined.
double normal_angle(const SurfaceJet& jet, const glm::dvec3& mesh) {
  const glm::dvec3 n = glm::cross(jet.dx, jet.dy);
  const double along = std::abs(glm::dot(n, mesh)), across = glm::length(glm::cross(n, mesh));
  return across > 0.0 ? std::atan2(across, along) : 0.0;
}

/// Converts powers of 2 u - 1 to Bernstein form: the inverse of make_reflector_patch.
std::array<glm::dvec3, 16> control_points(const Surface& s) {
  const auto blossom = [](const std::array<glm::dvec3, 4>& c) -> std::array<glm::dvec3, 4> {
    return {c[0] - c[1] + c[2] - c[3], c[0] - c[1] / 3.0 - c[2] / 3.0 + c[3], c[0] + c[1] / 3.0 - c[2] / 3.0 - c[3],
            c[0] + c[1] + c[2] + c[3]};
  };
  std::array<std::array<glm::dvec3, 4>, 4> rows{};
  std::array<glm::dvec3, 16> out{};
  for (std::size_t j = 0; j < 4; ++j) rows[j] = blossom({s.c[4 * j], s.c[4 * j + 1], s.c[4 * j + 2], s.c[4 * j + 3]});
  for (std::size_t i = 0; i < 4; ++i) {
    const auto column = blossom({rows[0][i], rows[1][i], rows[2][i], rows[3][i]});
    for (std::size_t j = 0; j < 4; ++j) out[4 * j + i] = column[j];
  }
  return out;
}

/// The 98th percentile of the angles.
double percentile_98(std::vector<double>* angles) {
  if (angles->empty()) return 0.0;
  const auto most = angles->begin() + static_cast<std::ptrdiff_t>(angles->size() * 49 / 50);
  std::nth_element(angles->begin(), most, angles->end());
  return *most;
}

struct LocalFit {
  Cloud cloud;
  std::vector<std::size_t> triangles;  ///< indices within the part
  Surface surface{};
  std::vector<glm::dvec2> feet;
  Distances distances;  ///< m
};

/// Rescales the parameters to [-1, 1].
void normalise(std::vector<glm::dvec2>* feet) {
  glm::dvec2 low(1e300), high(-1e300);
  for (const glm::dvec2& x : *feet) {
    low = glm::min(low, x);
    high = glm::max(high, x);
  }
  for (glm::dvec2& x : *feet) x = glm::clamp(2.0 * (x - low) / glm::max(high - low, 1e-12) - 1.0, -1.0, 1.0);
}

/// Required accuracy of a fit, in units of its cloud, and its largest number of iterations.
struct FitLimits {
  double tolerance = 0.0;
  const std::function<bool()>* stop = nullptr;
  int iterations = 60;
};

/// Fits one patch to a cloud; each iteration solves for the surface and then projects the points on it again.
LocalFit fit_from(const Cloud& cloud, std::vector<glm::dvec2> feet, const FitLimits& limits) {
  constexpr int kPatience = 8;
  constexpr double kBeyond = 1.05;  // the border of the patch may move outwards
  const double tolerance = limits.tolerance;
  LocalFit best;
  normalise(&feet);
  std::vector<glm::dvec3> normals(feet.size(), glm::dvec3(0.0, 0.0, 1.0));
  std::vector<double> normal_weights(feet.size(), 0.0);
  Weights weights;
  int stalled = 0;
  for (int iteration = 0; iteration < limits.iterations && stalled < kPatience; ++iteration) {
    if (iteration > 0 && *limits.stop && (*limits.stop)()) break;
    const Surface s = solve(cloud, feet, normals, normal_weights, weights);
    std::vector<glm::dvec2> inside = feet;
    Distances d;
    for (std::size_t n = 0; n < feet.size(); ++n) {
      inside[n] = foot_point(s, cloud.points[n], feet[n], 1.0);
      feet[n] = foot_point(s, cloud.points[n], feet[n], kBeyond);
      const SurfaceJet jet = bezier_jet(s, inside[n]);
      const glm::dvec3 normal = glm::cross(jet.dx, jet.dy);
      normals[n] = glm::length(normal) > 1e-12 ? glm::normalize(normal) : glm::dvec3(0.0, 0.0, 1.0);
      const double distance = glm::length(jet.p - cloud.points[n]);
      d.largest = std::max(d.largest, distance);
      d.sum2 += distance * distance;
      double angle = 0.0;
      if (!cloud.normals.empty()) {
        angle = normal_angle(jet, cloud.normals[n]);
        // Same weight as the distance, each divided by its tolerance. Cauchy-like weights suppress wrong normals.
        const double slope =
            kNormalTolerance_rad * std::sqrt(glm::dot(jet.dx, jet.dx) + glm::dot(jet.dy, jet.dy) + 1e-12);
        normal_weights[n] =
            tolerance * tolerance / (slope * slope) / (1.0 + std::pow(angle / (2.0 * kNormalTolerance_rad), 4.0));
      }
      const double distance_error = std::min(distance / tolerance, kMaxDistanceError),
                   normal_error = std::min(angle / kNormalTolerance_rad, kMaxNormalError);
      d.misfit += distance_error * distance_error + normal_error * normal_error;
    }
    ++stalled;
    if (iteration == 0 || d.misfit < 0.9 * best.distances.misfit) stalled = 0;
    if (iteration == 0 || d.misfit < best.distances.misfit) {
      best.surface = s;
      best.feet = inside;
      best.distances = d;
    }
    const double rms = std::sqrt(d.sum2 / static_cast<double>(feet.size()));
    if (rms < 1e-3 * tolerance && rms < 3e-8) break;
    normalise(&feet);
    weights.point = std::max(0.3 * weights.point, 1e-3);
  }
  return best;
}

/// Starts from the parameters of the rectangle, or from the texture coordinates where they fit better.
LocalFit fit_cloud(Cloud cloud, std::span<const glm::vec2> uvs, const FitOptions& options) {
  std::vector<glm::dvec2> flat, textured;
  for (std::size_t n = 0; n < cloud.points.size(); ++n) {
    flat.emplace_back(cloud.points[n]);
    if (!uvs.empty()) textured.emplace_back(uvs[cloud.vertices[n]]);
  }
  LocalFit best;
  const FitLimits limits{options.tolerance_m / cloud.scale, &options.stop};
  if (!textured.empty()) best = fit_from(cloud, std::move(textured), limits);
  if (best.feet.empty() || !(best.distances.largest < 1e-2 * limits.tolerance)) {
    LocalFit other = fit_from(cloud, std::move(flat), limits);
    if (best.feet.empty() || !(best.distances.misfit <= other.distances.misfit)) best = std::move(other);
  }
  best.distances.largest *= cloud.scale;
  best.distances.sum2 *= cloud.scale * cloud.scale;
  best.cloud = std::move(cloud);
  return best;
}

std::size_t number_in(const Cloud& cloud, std::uint32_t vertex) {
  return static_cast<std::size_t>(std::lower_bound(cloud.vertices.begin(), cloud.vertices.end(), vertex) -
                                  cloud.vertices.begin());
}

bool is_finite(const glm::vec3& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

FittedPatch in_world(const LocalFit& fit) {
  FittedPatch out;
  out.points = control_points(fit.surface);
  for (glm::dvec3& p : out.points) p = fit.cloud.origin + fit.cloud.scale * (fit.cloud.world_from_local * p);
  out.largest_m = fit.distances.largest;
  out.rms_m = std::sqrt(fit.distances.sum2 / static_cast<double>(fit.feet.size()));
  return out;
}

void add_normal_angles(const LocalFit& fit, std::span<const glm::vec3> normals, std::vector<double>* angles) {
  for (std::size_t n = 0; n < fit.feet.size(); ++n) {
    const SurfaceJet jet = bezier_jet(fit.surface, fit.feet[n]);
    const glm::dvec3 local = glm::cross(jet.dx, jet.dy), mesh(normals[fit.cloud.vertices[n]]);
    if (!(glm::length(local) > 0.0) || !(glm::length(mesh) > 0.0)) continue;
    const glm::dvec3 a = fit.cloud.world_from_local * glm::normalize(local), b = glm::normalize(mesh);
    angles->push_back(std::atan2(glm::length(glm::cross(a, b)), std::abs(glm::dot(a, b))));
  }
}

using Parts = std::array<std::vector<std::size_t>, 2>;

/// Sorts the triangles by their centroids along an axis of the rectangle, and splits them in two: the first share, and
/// the rest.
Parts split(const Cloud& cloud, std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
            std::span<const std::size_t> triangles, int axis, double share) {
  std::vector<std::pair<double, std::size_t>> order;
  double low = 1e300, high = -1e300;
  for (const std::size_t t : triangles) {
    const glm::dvec3 sum = glm::dvec3(positions[indices[3 * t]]) + glm::dvec3(positions[indices[3 * t + 1]]) +
                           glm::dvec3(positions[indices[3 * t + 2]]);
    order.emplace_back(glm::dot(sum / 3.0 - cloud.origin, cloud.world_from_local[axis]), t);
    low = std::min(low, order.back().first);
    high = std::max(high, order.back().first);
  }
  Parts parts;
  for (const auto& [at, t] : order) parts[at > low + share * (high - low)].push_back(t);
  return parts;
}

struct Fitter {
  std::span<const glm::vec3> positions, normals;
  std::span<const glm::vec2> uvs;
  std::span<const std::uint32_t> indices;
  const FitOptions& options;
  std::size_t all_triangles, done = 0;  ///< triangles that already have a patch

  bool cloud_of(const std::vector<std::size_t>& triangles, Cloud* cloud) const {
    std::vector<std::uint32_t> used;
    for (const std::size_t t : triangles)
      for (std::size_t k = 0; k < 3; ++k) used.push_back(indices[3 * t + k]);
    return make_cloud(positions, normals, used, cloud);
  }

  /// Error of a short trial fit through a subset of the vertices.
  double guess_misfit(const std::vector<std::size_t>& triangles) const {
    constexpr std::size_t kEnough = 300;
    constexpr int kIterations = 6;
    Cloud cloud;
    if (!cloud_of(triangles, &cloud)) return 0.0;
    const std::size_t stride = 1 + cloud.points.size() / kEnough;
    Cloud thin = cloud;
    thin.points.clear();
    thin.normals.clear();
    std::vector<glm::dvec2> feet;
    for (std::size_t n = 0; n < cloud.points.size(); n += stride) {
      thin.points.push_back(cloud.points[n]);
      feet.emplace_back(cloud.points[n]);
      if (!cloud.normals.empty()) thin.normals.push_back(cloud.normals[n]);
    }
    const FitLimits limits{options.tolerance_m / cloud.scale, &options.stop, kIterations};
    return fit_from(thin, std::move(feet), limits).distances.misfit * static_cast<double>(stride);
  }

  /// Split for which two patches have the smallest estimated error.
  Parts best_split(const Cloud& cloud, const std::vector<std::size_t>& triangles) const {
    constexpr std::array<double, 5> kShares{0.1, 0.3, 0.5, 0.7, 0.9};
    std::array<Parts, 2 * kShares.size()> tried;
    std::array<double, tried.size()> misfits;
    misfits.fill(1e300);
    parallel_for(std::size_t{0}, tried.size(), [&](std::size_t k) {
      tried[k] = split(cloud, positions, indices, triangles, static_cast<int>(k / kShares.size()),
                       kShares[k % kShares.size()]);
      if (tried[k][0].size() < kMinTriangles || tried[k][1].size() < kMinTriangles) return;
      misfits[k] = guess_misfit(tried[k][0]) + guess_misfit(tried[k][1]);
    });
    const auto best = std::min_element(misfits.begin(), misfits.end());
    return *best < 1e300 ? tried[static_cast<std::size_t>(best - misfits.begin())] : Parts{};
  }

  /// The patches of a part: one, or those of its two halves.
  std::vector<LocalFit> fit(const std::vector<std::size_t>& triangles, std::size_t most) {
    Cloud cloud;
    if (!cloud_of(triangles, &cloud)) return {};
    std::vector<LocalFit> one;
    one.push_back(fit_cloud(std::move(cloud), uvs, options));
    one[0].triangles = triangles;
    const double vertices = static_cast<double>(one[0].feet.size());
    // Many wrong normals justify another patch.
    const bool good = one[0].distances.largest <= options.tolerance_m && one[0].distances.misfit < vertices;
    const bool stopped = options.stop && options.stop();
    if (good || stopped || most < 2 || triangles.size() < 2 * kMinTriangles) {
      done += triangles.size();
      if (options.report) options.report(static_cast<double>(done) / static_cast<double>(all_triangles));
      return one;
    }
    std::vector<LocalFit> parts;
    double misfit = 0.0, sum2 = 0.0;
    for (const auto& part : best_split(one[0].cloud, triangles)) {
      std::vector<LocalFit> some = fit(part, most / 2);
      for (LocalFit& f : some) {
        misfit += f.distances.misfit;
        sum2 += f.distances.sum2;
        parts.push_back(std::move(f));
      }
    }
    // Noise does not shrink with the parts: in that case one smooth patch is the better mirror.
    const bool nearer = one[0].distances.largest > options.tolerance_m && sum2 < 0.5 * one[0].distances.sum2;
    const bool better = nearer || misfit < 0.5 * one[0].distances.misfit;
    return !parts.empty() && better ? std::move(parts) : std::move(one);
  }
};

}  // namespace

std::string fit_text(const PatchFit& fit) {
  char text[80], exact[40] = "";
  if (fit.exact > 0) std::snprintf(exact, sizeof exact, ", %zu of them exact", fit.exact);
  std::snprintf(text, sizeof text, "%zu %s%s, %.2g mm off", fit.patches.size(),
                fit.patches.size() == 1 ? "patch" : "patches", exact, 1e3 * fit.largest_m);
  return text;
}

PatchFit fit_patches(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                     std::span<const glm::vec2> uvs, std::span<const std::uint32_t> indices,
                     const FitOptions& options) {
  PatchFit out;
  out.triangles.resize(indices.size() / 3);
  std::vector<std::uint32_t> used;
  std::vector<std::size_t> numbers;  // of the triangles in `used`, as in `indices`
  for (std::size_t t = 0; t < out.triangles.size(); ++t) {
    const std::uint32_t* v = &indices[3 * t];
    if (!std::all_of(v, v + 3, [&](std::uint32_t k) { return is_finite(positions[k]); })) continue;
    used.insert(used.end(), v, v + 3);
    numbers.push_back(t);
  }
  std::vector<LocalFit> fits;
  Fitter fitter{positions, normals, uvs, used, options, numbers.size()};
  for (const std::vector<std::size_t>& sheet : find_sheets(positions, used)) {
    std::vector<LocalFit> some = fitter.fit(sheet, kMaxPatchesPerSheet);
    std::move(some.begin(), some.end(), std::back_inserter(fits));
  }
  if (fits.empty()) {
    out.why = used.empty() ? "it has no triangles" : "its vertices span no area";
    return out;
  }
  double sum2 = 0.0, count = 0.0;
  std::vector<double> angles;
  for (const LocalFit& fit : fits) {
    for (const std::size_t t : fit.triangles) {
      FittedTriangle& triangle = out.triangles[numbers[t]];
      triangle.patch = static_cast<int>(out.patches.size());
      for (std::size_t k = 0; k < 3; ++k) triangle.x[k] = fit.feet[number_in(fit.cloud, used[3 * t + k])];
    }
    out.patches.push_back(in_world(fit));
    out.largest_m = std::max(out.largest_m, fit.distances.largest);
    sum2 += fit.distances.sum2;
    count += static_cast<double>(fit.feet.size());
    if (!normals.empty()) add_normal_angles(fit, normals, &angles);
  }
  out.rms_m = std::sqrt(sum2 / count);
  out.normal_rad = percentile_98(&angles);
  out.met = out.largest_m <= options.tolerance_m;
  return out;
}

std::optional<PatchFit> limit_patches_of(const SubdivisionCage& cage, const glm::dmat4& world_from_node,
                                         std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                                         std::span<const std::uint32_t> indices, double tolerance_m) {
  constexpr std::size_t kMaxLimitPatches = 96;
  // A mirroring node reverses the winding: the second and third corner change places.
  const bool mirrors = glm::determinant(glm::dmat3(world_from_node)) < 0.0;
  for (int isolation = 1; isolation <= std::min(cage.levels, 4); ++isolation) {
    const LimitPatches limit = make_limit_patches(cage, isolation);
    if (limit.points.size() > kMaxLimitPatches || limit.patch_of_triangle.size() != indices.size() / 3)
      return std::nullopt;
    PatchFit out;
    std::vector<ReflectorPatch> ready;
    for (std::size_t k = 0; k < limit.points.size(); ++k) {
      FittedPatch patch;
      for (std::size_t n = 0; n < 16; ++n)
        patch.points[n] = glm::dvec3(world_from_node * glm::dvec4(limit.points[k][n], 1.0));
      ready.push_back(make_reflector_patch(patch.points));
      out.patches.push_back(patch);
      out.exact += limit.exact[k];
    }
    double sum2 = 0.0;
    std::vector<double> angles;
    for (std::size_t t = 0; t < limit.patch_of_triangle.size(); ++t) {
      FittedTriangle triangle;
      triangle.patch = limit.patch_of_triangle[t];
      triangle.x = limit.x[t];
      if (mirrors) std::swap(triangle.x[1], triangle.x[2]);
      out.triangles.push_back(triangle);
      if (triangle.patch < 0) return std::nullopt;
      const ReflectorPatch& patch = ready[static_cast<std::size_t>(triangle.patch)];
      FittedPatch& fitted = out.patches[static_cast<std::size_t>(triangle.patch)];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = indices[3 * t + k];
        const glm::dvec3 at = glm::dvec3(positions[v]) - patch.origin;
        // The parametrisation of a cap differs from that of the surface.
        if (!limit.exact[static_cast<std::size_t>(triangle.patch)])
          out.triangles.back().x[k] = foot_point(patch.exact, at, triangle.x[k], 1.0);
        const SurfaceJet jet = bezier_jet(patch.exact, out.triangles.back().x[k]);
        const double distance = glm::length(jet.p - at);
        fitted.largest_m = std::max(fitted.largest_m, distance);
        sum2 += distance * distance;
        if (!normals.empty()) angles.push_back(normal_angle(jet, glm::dvec3(normals[v])));
      }
    }
    for (const FittedPatch& patch : out.patches) out.largest_m = std::max(out.largest_m, patch.largest_m);
    out.rms_m = std::sqrt(sum2 / static_cast<double>(std::max<std::size_t>(indices.size(), 1)));
    out.normal_rad = percentile_98(&angles);
    out.met = out.largest_m <= tolerance_m;
    if (out.met) return out;
  }
  return std::nullopt;
}

}  // namespace maquette
