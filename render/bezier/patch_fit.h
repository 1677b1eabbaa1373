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
  std::array<glm::dvec3, 16> points{};  ///< [row v][column u], as BezierPatch has them
  double largest_m = 0.0, rms_m = 0.0;  ///< distances of the vertices from it
};

/// Which patch serves a triangle of the mesh, and the parameters of its corners there.
struct FittedTriangle {
  int patch = -1;                 ///< -1: none
  std::array<glm::dvec2, 3> x{};  ///< [-1, 1]
};

/// One patch, or several that share the part's triangles between them.
struct PatchFit {
  std::vector<FittedPatch> patches;
  std::vector<FittedTriangle> triangles;  ///< as many as `indices` has
  double largest_m = 0.0, rms_m = 0.0;    ///< distances of the vertices from their patches
  double normal_rad = 0.0;  ///< between the mesh's normals and the patches': all but one in fifty are within
  std::size_t exact = 0;    ///< of the patches: regular faces of a subdivision surface
  bool met = false;         ///< the tolerance
  std::string why;          ///< why there is no patch; empty else
};

constexpr double kFitTolerance_m = 2e-4;

struct FitOptions {
  double tolerance_m = kFitTolerance_m;
  /// Asked while it works, from several threads; true ends the fit soon, with a result that means nothing.
  std::function<bool()> stop = {};
  /// Share of the triangles that have their patch, in [0, 1].
  std::function<void(double)> report = {};
};

/// How many patches, how many of them exact, how far off.
std::string fit_text(const PatchFit& fit);

/// A closed body is taken apart at its creases, and each sheet fitted by itself.
/// Least squares over the vertices that `indices` (three a triangle) name, in turns with the nearest points of the
/// patch (Gauss-Newton on the distances along its normals). A part that one patch misses is cut where short
/// trials promise most, while that helps.
/// `normals`: unit, either side, as many as positions, or none. `uvs`: texture coordinates, tried as the patch's own
/// parameters: a patch that was tessellated with them comes back to the last digit. Sizes in metres; in double
/// throughout. Source: Wang, Pottmann and Liu 2006, "Fitting B-spline curves to point clouds by curvature-based squared
/// distance minimization" (tangent distance, with a small share of the point distance).
PatchFit fit_patches(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                     std::span<const glm::vec2> uvs, std::span<const std::uint32_t> indices,
                     const FitOptions& options = {});

/// The patches of a subdivision surface that the mesh shows as it is: regular faces exactly, what is left around other
/// vertices by caps (scenes/subdivision_patches.h) that miss no vertex by more than the tolerance. Nothing where that
/// takes more than 96 patches, or the mesh has been moved since.
std::optional<PatchFit> limit_patches_of(const SubdivisionCage& cage, const glm::dmat4& world_from_node,
                                         std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                                         std::span<const std::uint32_t> indices, double tolerance_m = kFitTolerance_m);

}  // namespace maquette
