#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace maquette {

inline constexpr int kThetaHCount = 90;
inline constexpr int kThetaDCount = 90;
inline constexpr int kPhiDCount = 180;
inline constexpr int kBrdfEntryCount = kThetaHCount * kThetaDCount * kPhiDCount;

/// Isotropic BRDF as tabulated by MERL, in 1/sr, with unmeasured entries already filled.
/// rgb: [theta_h 90][theta_d 90][phi_d 180] of linear RGB; values belong to bin centres, theta_h bins are square-root
/// spaced.
struct BrdfTable {
  std::string name;
  std::vector<glm::vec3> rgb;
  std::size_t unmeasured_count = 0;  ///< entries that the file marks as not measured
  std::uint64_t hash = 0;            ///< of the filled entries; key of all derived tables
};

/// Loads a MERL `.binary`. Unmeasured (negative, NaN) entries take the last measured value along theta_d; a column
/// without any takes its theta_h neighbour. Throws Error for a wrong header, a truncated or oversized file, infinite
/// values or no measured values.
BrdfTable load_merl(const std::string& path);
/// Writes the 33 MB .binary format (used by `inspect`, tests and export).
void save_merl(const std::string& path, const BrdfTable& table);

struct BuiltinBrdf {
  std::string name;   ///< e.g. `paint-red-metallic`
  std::string label;  ///< shown to the user: "Red metallic paint"
  std::string model;  ///< formula and parameters, with the source
};
/// The built-in library: at least 16 paints and trims.
const std::vector<BuiltinBrdf>& builtin_brdfs();
/// Tabulates one of them. Throws UsageError that suggests the nearest names.
BrdfTable make_builtin_brdf(const std::string& name);
/// Loads `builtin:NAME` or a path.
BrdfTable load_brdf(const std::string& source);

/// Trilinear interpolation between bin centres in double; wi, wo unit, local frame z = normal. 0 below the horizon.
glm::dvec3 evaluate_brdf(const BrdfTable& table, const glm::dvec3& wi, const glm::dvec3& wo);

}  // namespace maquette
