#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// A bicubic patch laid through the vertices of a part.
struct FittedPatch {
  std::array<glm::dvec3, 16> points{};  ///< [row v][column u], as in BezierPatch
  double largest_m = 0.0, rms_m = 0.0;  ///< distances of the vertices from the patch
};

/// The patch of one triangle of the mesh, and the parameters of the triangle's corners on it.
struct FittedTriangle {
  int patch = -1;                 ///< -1: none
  std::array<glm::dvec2, 3> x{};  ///< [-1, 1]
};

/// Patches that together cover the triangles of a part.
struct PatchFit {
  std::vector<FittedPatch> patches;
  std::vector<FittedTriangle> triangles;  ///< one per triangle of `indices`
  double largest_m = 0.0, rms_m = 0.0;    ///< distances of the vertices from their patches
  double normal_rad = 0.0;                ///< 98th percentile of the angle between the normals of mesh and patches
  std::size_t exact = 0;                  ///< number of patches that are regular faces of a subdivision surface
  bool met = false;                       ///< all vertices are within the tolerance
  std::string why;                        ///< why there is no patch; empty if there is one
};

constexpr double kFitTolerance_m = 2e-4;

struct FitOptions {
  double tolerance_m = kFitTolerance_m;
  /// Polled from several threads while the fit runs; returning true ends it soon, with a result that must not be used.
  std::function<bool()> stop = {};
  /// Receives the share of the triangles that already have a patch, in [0, 1].
  std::function<void(double)> report = {};
};

/// One line: number of patches, how many are exact, and the error.
std::string fit_text(const PatchFit& fit);

/// Fits patches to the vertices that `indices` (three a triangle) name. A closed body is first cut at its creases, and
/// each sheet is fitted separately. Least squares alternates with projection to the nearest points of the patch
/// (Gauss-Newton on the distances along its normals). Where one patch is not accurate enough the part is split at the
/// best of several short trials, as long as that helps.
/// `normals`: unit, of either orientation, as many as positions, or none. `uvs`: texture coordinates, tried as
/// parameters of the patch: a patch that was tessellated with them is recovered to the last digit. Lengths in metres;
/// computed in double. Source: Wang, Pottmann and Liu 2006, "Fitting B-spline curves to point clouds by curvature-based
/// squared distance minimization" (tangent distance, with a small share of the point distance).
PatchFit fit_patches(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                     std::span<const glm::vec2> uvs, std::span<const std::uint32_t> indices,
                     const FitOptions& options = {});

/// The patches of the subdivision surface that the mesh tessellates: exact for regular faces, caps
/// (scenes/subdivision_patches.h) around other vertices, all within the tolerance. Nothing when that needs more than 96
/// patches, or when the mesh no longer matches the cage.
std::optional<PatchFit> limit_patches_of(const SubdivisionCage& cage, const glm::dmat4& world_from_node,
                                         std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                                         std::span<const std::uint32_t> indices, double tolerance_m = kFitTolerance_m);

}  // namespace maquette
